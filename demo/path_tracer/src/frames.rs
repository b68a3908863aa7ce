//! Draws the frames of a moving scene into numbered files.

use std::path::{Path, PathBuf};

use wgdenoise::Denoiser;

use crate::args::Args;
use crate::headless::{Files, Studio, check_outputs, reference_seed};
use path_tracer::denoise::{Denoised, denoiser, history};
use path_tracer::exr::{ALBEDO, COLOR, DEPTH, MOTION, NORMAL};
use path_tracer::renderer::Result;
use path_tracer::renderer::film::Film;
use path_tracer::renderer::motion::Motion;
use path_tracer::stage::Moment;

/// The images that a frame is drawn on.
struct Canvas {
    film: Film,
    motion: Motion,
    denoised: Denoised,
    reference: Film,
}

/// Draws, denoises and saves frames, starting with the scene's first moment.
///
/// # Errors
/// If a file cannot be written, no adapter is found, or the device fails.
pub(crate) fn run(args: &Args, files: &Files, frames: u32) -> Result<()> {
    let numbered: Vec<_> = (1..=frames).map(|frame| files.numbered(frame)).collect();
    numbered.iter().try_for_each(|files| check_outputs(&files.all()))?;
    let mut studio = Studio::open(args)?;
    let denoiser = denoiser(&studio.gpu.device, &studio.gpu.queue, args.quality.into())?;
    let mut canvas = Canvas::new(&studio, &denoiser, args)?;
    let mut moment = Moment { time: args.start, ..studio.stage.now() };
    for files in &numbered {
        studio.stage.show(moment, &mut canvas.film)?;
        canvas.draw(&studio, args, files)?;
        moment = moment.next(args.orbit, args.animate);
    }
    Ok(())
}

impl Files {
    /// The files of one frame.
    fn numbered(&self, frame: u32) -> Self {
        let number = |file: &PathBuf| numbered(file, frame);
        let (noisy, denoised) = (number(&self.noisy), number(&self.denoised));
        Self { noisy, denoised, reference: self.reference.as_ref().map(number) }
    }
}

/// Turns `out.exr` into `out.0001.exr`.
fn numbered(file: &Path, frame: u32) -> PathBuf {
    let extension = file.extension().unwrap_or("exr".as_ref()).display();
    file.with_extension(format!("{frame:04}.{extension}"))
}

impl Canvas {
    fn new(studio: &Studio, denoiser: &Denoiser, args: &Args) -> Result<Self> {
        let renderer = &studio.stage.renderer;
        let film = renderer.film(args.size, args.seed)?;
        let motion = renderer.motion(args.size)?;
        let along = args.temporal.then_some(&motion);
        let denoised = Denoised::new(denoiser, &studio.gpu.device, &film, along)?;
        denoised.pass.set_history(history(0));
        let reference = renderer.film(args.size, reference_seed(args.seed))?;
        Ok(Self { film, motion, denoised, reference })
    }

    /// Draws the stage's frame. Frames do not share samples, even if nothing moves.
    fn draw(&mut self, studio: &Studio, args: &Args, files: &Files) -> Result<()> {
        let Self { film, motion, denoised, reference } = self;
        film.start_over();
        studio.expose(film, args.spp)?;
        studio.submit(|encoder| {
            studio.stage.encode_motion(encoder, motion);
            denoised.pass.encode(encoder);
        })?;
        let features = [(ALBEDO, &film.albedo), (NORMAL, &film.normal)];
        let moved = [(MOTION, &motion.vectors), (DEPTH, &motion.depth)];
        let noisy: Vec<_> =
            [(COLOR, &film.color)].into_iter().chain(features).chain(moved).collect();
        studio.save(&files.noisy, film.size, &noisy)?;
        studio.save(&files.denoised, film.size, &[(COLOR, &denoised.output)])?;
        let Some(file) = &files.reference else { return Ok(()) };
        reference.start_over();
        studio.expose(reference, args.reference_spp)?;
        studio.save(file, film.size, &[(COLOR, &reference.color)])
    }
}
