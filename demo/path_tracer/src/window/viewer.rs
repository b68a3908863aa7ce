//! Draws frames: path tracing, denoising and display in one submission.

use wgdenoise::{Denoiser, Schedule};

use super::orbit::Orbit;
use super::present::{Present, Split};
use super::screen::Screen;
use super::stopwatch::{Stopwatch, Times};
use crate::args::Args;
use path_tracer::denoise::{Denoised, denoiser};
use path_tracer::renderer::film::Film;
use path_tracer::renderer::{Kernels, Method, Renderer, Result};

/// A scene in a window.
pub(super) struct Viewer {
    screen: Screen,
    renderer: Renderer,
    denoiser: Denoiser,
    present: Present,
    stopwatch: Stopwatch,
    canvas: Canvas,
    orbit: Orbit,
    per_frame: u32,
    schedule: Schedule,
    /// Frames since the accumulation began.
    frame: u32,
    /// Whether the denoised image shows an earlier accumulation.
    stale: bool,
}

/// Everything that depends on the window's size.
struct Canvas {
    film: Film,
    denoised: Denoised,
    images: wgpu::BindGroup,
}

impl Viewer {
    /// Sets up the scene and the denoiser for the screen.
    ///
    /// # Errors
    /// If the device cannot hold them.
    pub(super) fn new(screen: Screen, args: &Args) -> Result<Self> {
        let (device, queue) = (&screen.device, &screen.queue);
        let scene = args.scene.build();
        let kernels = Kernels::new(device);
        let renderer = Renderer::new(device, queue, &kernels, &scene, Method::default());
        let denoiser = denoiser(device, queue, args.quality.into())?;
        let present = Present::new(device, screen.config.format);
        let size = [screen.config.width, screen.config.height];
        let canvas = Canvas::new(&renderer, &denoiser, &present, device, (size, args.seed))?;
        Ok(Self {
            renderer,
            denoiser,
            present,
            stopwatch: Stopwatch::new(device, queue),
            canvas,
            orbit: Orbit::new(&scene),
            per_frame: args.spp,
            schedule: args.schedule(),
            frame: 0,
            stale: true,
            screen,
        })
    }

    /// Starts over with images of another size. The denoiser stays.
    ///
    /// # Errors
    /// If the device cannot hold them.
    pub(super) fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        self.screen.resize(size);
        let (device, seed) = (&self.screen.device, self.canvas.film.seed);
        let Self { renderer, denoiser, present, .. } = &*self;
        self.canvas = Canvas::new(renderer, denoiser, present, device, (size, seed))?;
        (self.frame, self.stale) = (0, true);
        Ok(())
    }

    /// Moves the camera and starts over.
    pub(super) fn look(&mut self, change: impl FnOnce(&mut Orbit)) {
        change(&mut self.orbit);
        self.canvas.film.samples = 0;
        (self.frame, self.stale) = (0, true);
    }

    /// Samples per pixel so far.
    pub(super) fn samples(&self) -> u32 {
        self.canvas.film.samples
    }

    /// Width of the window in pixels.
    pub(super) fn width(&self) -> f32 {
        self.screen.config.width as f32
    }

    /// Draws a frame and waits for it; `None` while the window cannot be drawn on.
    ///
    /// # Errors
    /// If the device fails.
    pub(super) fn draw(&mut self, split: Split) -> Result<Option<Times>> {
        let Some(target) = self.screen.next()? else { return Ok(None) };
        let view = target.texture.create_view(&Default::default());
        self.stopwatch.start();
        self.present.write_split(&self.screen.queue, split);
        let mut encoder = self.screen.device.create_command_encoder(&Default::default());
        self.record(&mut encoder, split, &view);
        self.screen.queue.submit([encoder.finish()]);
        self.screen.queue.present(target);
        self.stopwatch.stop(&self.screen.device).map(Some)
    }

    /// Records the whole frame.
    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        split: Split,
        target: &wgpu::TextureView,
    ) {
        let Canvas { film, denoised, images } = &mut self.canvas;
        let times = self.stopwatch.render();
        self.renderer.encode(encoder, film, &self.orbit.camera(), self.per_frame, times);
        if split.divider < self.screen.config.width as f32 {
            if self.stale || self.schedule.due(self.frame) {
                let share = self.schedule.blend(film.samples);
                denoised.encode_blended(share, encoder);
            }
            self.stale = false;
        } else {
            self.stale = true;
        }
        self.frame += 1;
        self.present.encode(encoder, images, target, self.stopwatch.present());
        self.stopwatch.resolve(encoder);
    }
}

impl Canvas {
    fn new(
        renderer: &Renderer,
        denoiser: &Denoiser,
        present: &Present,
        device: &wgpu::Device,
        (size, seed): ([u32; 2], u32),
    ) -> Result<Self> {
        let film = renderer.film(size, seed)?;
        let denoised = Denoised::new(denoiser, device, &film)?;
        let images = present.bind(device, &film.color, &denoised.output);
        Ok(Self { film, denoised, images })
    }
}
