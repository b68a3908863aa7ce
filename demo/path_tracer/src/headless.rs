//! Draws into files, without a window.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use wgdenoise::Gpu;
use wgdenoise_files::check_output;

use crate::args::Args;
use path_tracer::denoise::{Denoised, denoiser};
use path_tracer::exr::{self, ALBEDO, COLOR, NORMAL};
use path_tracer::renderer::film::Film;
use path_tracer::renderer::pixels::read;
use path_tracer::renderer::scene::Scene;
use path_tracer::renderer::{Kernels, Method, Renderer, Result};

/// A device with a scene on it.
struct Studio {
    gpu: Gpu,
    scene: Scene,
    renderer: Renderer,
}

/// Draws, denoises and writes the requested files.
///
/// # Errors
/// If a file cannot be written, no adapter is found, or the device fails.
pub(crate) fn run(args: &Args, out: &Path) -> Result<()> {
    let denoised = args.denoised.clone().unwrap_or_else(|| beside(out));
    let files = [Some(out), Some(&denoised), args.reference.as_deref()];
    check_outputs(&files.into_iter().flatten().collect::<Vec<_>>())?;
    Gpu::silence_device_select();
    let gpu = Gpu::open(args.device.as_deref())?;
    println!("rendering on {}", gpu.info.name);
    let scene = args.scene.build();
    let kernels = Kernels::new(&gpu.device);
    let renderer = Renderer::new(&gpu.device, &gpu.queue, &kernels, &scene, Method::default());
    let studio = Studio { gpu, scene, renderer };
    let film = studio.draw(args.size, args.spp, args.seed)?;
    studio.write(out, &film)?;
    studio.denoise(args, &film, &denoised)?;
    let Some(reference) = &args.reference else { return Ok(()) };
    // The reference must not share the picture's noise.
    let film = studio.draw(args.size, args.reference_spp, !args.seed)?;
    studio.write(reference, &film)
}

/// Refuses files that cannot be written and names given twice.
fn check_outputs(files: &[&Path]) -> Result<()> {
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
    fn draw(&self, size: [u32; 2], samples: u32, seed: u32) -> Result<Film> {
        let mut film = self.renderer.film(size, seed)?;
        let begin = Instant::now();
        while film.samples < samples {
            let more = samples - film.samples;
            self.submit(|encoder| {
                self.renderer.encode(encoder, &mut film, &self.scene.camera, more, None);
            })?;
        }
        let [width, height] = size;
        println!(
            "drew {width}×{height} pixels with {samples} samples each in {}",
            ms(begin.elapsed())
        );
        Ok(film)
    }

    /// Denoises twice, since drivers compile kernels the first time they run, and prints both times.
    fn denoise(&self, args: &Args, film: &Film, out: &Path) -> Result<()> {
        let Gpu { device, queue, .. } = &self.gpu;
        let denoiser = denoiser(device, queue, args.quality.into())?;
        let denoised = Denoised::new(&denoiser, device, film)?;
        let first = self.submit(|encoder| denoised.encode(encoder))?;
        let again = self.submit(|encoder| denoised.encode(encoder))?;
        println!("denoised in {} (first run {})", ms(again), ms(first));
        let color = read(device, queue, &denoised.output)?;
        exr::write(out, film.size, &[(COLOR.0, COLOR.1, &color)])?;
        println!("wrote {}", out.display());
        Ok(())
    }

    fn write(&self, out: &Path, film: &Film) -> Result<()> {
        let read = |texture| read(&self.gpu.device, &self.gpu.queue, texture);
        let [color, albedo, normal] = [&film.color, &film.albedo, &film.normal].map(read);
        let (color, albedo, normal) = (color?, albedo?, normal?);
        let layers = [
            (COLOR.0, COLOR.1, &color[..]),
            (ALBEDO.0, ALBEDO.1, &albedo),
            (NORMAL.0, NORMAL.1, &normal),
        ];
        exr::write(out, film.size, &layers)?;
        println!("wrote {}", out.display());
        Ok(())
    }

    /// Submits the recorded commands and waits for them.
    fn submit(&self, record: impl FnOnce(&mut wgpu::CommandEncoder)) -> Result<Duration> {
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
