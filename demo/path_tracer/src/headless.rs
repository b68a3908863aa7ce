//! Draws into files, without a window.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use wgdenoise::Gpu;
use wgdenoise_files::check_output;

use crate::args::Args;
use crate::frames;
use path_tracer::denoise::{Denoised, denoiser};
use path_tracer::exr::{self, ALBEDO, COLOR, NORMAL};
use path_tracer::renderer::film::Film;
use path_tracer::renderer::pixels::read;
use path_tracer::renderer::{Kernels, Result};
use path_tracer::stage::Stage;

/// A device with a scene on it.
pub(crate) struct Studio {
    pub(crate) gpu: Gpu,
    pub(crate) stage: Stage,
}

/// A texture, and the prefix and channels to write it under.
pub(crate) type Image<'a> = ((&'static str, &'static [&'static str]), &'a wgpu::Texture);

/// The files to write.
pub(crate) struct Files {
    pub(crate) noisy: PathBuf,
    pub(crate) denoised: PathBuf,
    pub(crate) reference: Option<PathBuf>,
}

/// Draws, denoises and writes the requested files.
///
/// # Errors
/// If a file cannot be written, no adapter is found, or the device fails.
pub(crate) fn run(args: &Args, out: &Path) -> Result<()> {
    let files = Files::new(args, out);
    if let Some(frames) = args.frames {
        return frames::run(args, &files, frames);
    }
    if args.animate {
        return Err("one picture does not move: give --frames N with --animate".into());
    }
    check_outputs(&files.all())?;
    let studio = Studio::open(args)?;
    let film = studio.draw(args.size, args.spp, args.seed)?;
    studio.write(&files.noisy, &film)?;
    studio.denoise(args, &film, &files.denoised)?;
    let Some(reference) = &files.reference else { return Ok(()) };
    let film = studio.draw(args.size, args.reference_spp, reference_seed(args.seed))?;
    studio.write(reference, &film)
}

/// A seed far from the image's: the reference must not share its noise.
pub(crate) fn reference_seed(seed: u32) -> u32 {
    seed ^ (1 << 31)
}

impl Files {
    fn new(args: &Args, out: &Path) -> Self {
        let noisy = out.to_path_buf();
        let denoised = args.denoised.clone().unwrap_or_else(|| beside(out));
        Self { noisy, denoised, reference: args.reference.clone() }
    }

    /// All files.
    pub(crate) fn all(&self) -> Vec<&Path> {
        [&self.noisy, &self.denoised]
            .into_iter()
            .chain(&self.reference)
            .map(PathBuf::as_path)
            .collect()
    }
}

/// Rejects files that cannot be written, and duplicate names.
pub(crate) fn check_outputs(files: &[&Path]) -> Result<()> {
    for (i, file) in files.iter().enumerate() {
        check_output(file, true)?;
        if files[..i].contains(file) {
            return Err(format!(
                "{} is named twice; give each output its own name",
                file.display()
            )
            .into());
        }
    }
    Ok(())
}

/// Turns `out.exr` into `out.denoised.exr`.
fn beside(out: &Path) -> PathBuf {
    out.with_extension("denoised.exr")
}

impl Studio {
    /// Opens a device and uploads the scene.
    ///
    /// # Errors
    /// If no adapter is found or the device fails.
    pub(crate) fn open(args: &Args) -> Result<Self> {
        Gpu::silence_device_select();
        let gpu = Gpu::open(args.device.as_deref())?;
        println!("rendering on {}", gpu.info.name);
        let stage = Stage::new(&gpu.device, &gpu.queue, &Kernels::new(&gpu.device), args.scene);
        Ok(Self { gpu, stage })
    }

    fn draw(&self, size: [u32; 2], samples: u32, seed: u32) -> Result<Film> {
        let mut film = self.stage.renderer.film(size, seed)?;
        self.expose(&mut film, samples)?;
        Ok(film)
    }

    /// Adds samples to the film until it has this many per pixel.
    ///
    /// # Errors
    /// If the device fails.
    pub(crate) fn expose(&self, film: &mut Film, samples: u32) -> Result<()> {
        let begin = Instant::now();
        while film.samples < samples {
            let more = samples - film.samples;
            self.submit(|encoder| self.stage.encode(encoder, film, more, None))?;
        }
        let ([width, height], time) = (film.size, ms(begin.elapsed()));
        println!("drew {width}×{height} pixels with {samples} samples each in {time}");
        Ok(())
    }

    /// Denoises twice, since drivers compile kernels the first time they run, and prints both times.
    fn denoise(&self, args: &Args, film: &Film, out: &Path) -> Result<()> {
        let Gpu { device, queue, .. } = &self.gpu;
        let denoiser = denoiser(device, queue, args.quality.into())?;
        let denoised = Denoised::new(&denoiser, device, film, None)?;
        let first = self.submit(|encoder| denoised.pass.encode(encoder))?;
        let again = self.submit(|encoder| denoised.pass.encode(encoder))?;
        println!("denoised in {} (first run {})", ms(again), ms(first));
        self.save(out, film.size, &[(COLOR, &denoised.output)])
    }

    fn write(&self, out: &Path, film: &Film) -> Result<()> {
        self.save(
            out,
            film.size,
            &[(COLOR, &film.color), (ALBEDO, &film.albedo), (NORMAL, &film.normal)],
        )
    }

    /// Writes textures of this size into one file.
    ///
    /// # Errors
    /// If the device fails or the file cannot be written.
    pub(crate) fn save(&self, out: &Path, size: [u32; 2], images: &[Image<'_>]) -> Result<()> {
        let read = |(_, texture): &Image<'_>| read(&self.gpu.device, &self.gpu.queue, texture);
        let pixels = images.iter().map(read).collect::<Result<Vec<_>>>()?;
        let layers = images.iter().zip(&pixels);
        let layers = layers.map(|(((prefix, names), _), pixels)| (*prefix, *names, &pixels[..]));
        exr::write(out, size, &layers.collect::<Vec<_>>())?;
        println!("wrote {}", out.display());
        Ok(())
    }

    /// Submits the recorded commands and waits for them.
    ///
    /// # Errors
    /// If the device fails.
    pub(crate) fn submit(
        &self,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<Duration> {
        let begin = Instant::now();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        record(&mut encoder);
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(begin.elapsed())
    }
}

fn ms(time: Duration) -> String {
    format!("{:.1} ms", time.as_secs_f64() * 1e3)
}
