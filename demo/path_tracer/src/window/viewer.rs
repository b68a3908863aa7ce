//! Draws frames: path tracing, denoising and display in one submission.

use std::time::Instant;

use wgdenoise::{Denoiser, Schedule};

use super::controls::Controls;
use super::orbit::Orbit;
use super::present::Present;
use super::screen::Screen;
use super::stopwatch::{Stopwatch, Times};
use crate::args::Args;
use path_tracer::denoise::{Denoised, denoiser, history};
use path_tracer::renderer::film::Film;
use path_tracer::renderer::motion::Motion;
use path_tracer::renderer::scenes::PERIOD;
use path_tracer::renderer::{Kernels, Renderer, Result};
use path_tracer::stage::{Moment, Stage};

/// A scene in a window.
pub(super) struct Viewer {
    screen: Screen,
    stage: Stage,
    denoiser: Denoiser,
    present: Present,
    stopwatch: Stopwatch,
    canvas: Canvas,
    orbit: Orbit,
    per_frame: u32,
    schedule: Schedule,
    /// Frames since accumulation began.
    frame: u32,
    /// When the last frame was drawn.
    drawn: Instant,
}

/// Maximum animation step per frame in seconds: on slow adapters, spheres slow down instead of
/// jumping.
const LONGEST_STEP: f32 = 1.0 / 24.0;

/// Everything that depends on the window's size.
struct Canvas {
    film: Film,
    motion: Motion,
    denoised: Denoised,
    images: wgpu::BindGroup,
    /// Whether the denoised image shows an earlier accumulation.
    stale: bool,
    /// Whether a frame has been skipped since the last denoised one: motion vectors do not reach
    /// past it.
    skipped: bool,
}

impl Viewer {
    /// Sets up the scene and the denoiser for the screen.
    ///
    /// # Errors
    /// If the device cannot hold them.
    pub(super) fn new(screen: Screen, args: &Args) -> Result<Self> {
        let (device, queue) = (&screen.device, &screen.queue);
        let stage = Stage::new(device, queue, &Kernels::new(device), args.scene);
        let denoiser = denoiser(device, queue, args.quality.into())?;
        let present = Present::new(device, screen.config.format);
        let size = [screen.config.width, screen.config.height];
        let canvas = Canvas::new(&stage.renderer, &denoiser, &present, device, (size, args.seed))?;
        Ok(Self {
            stage,
            denoiser,
            present,
            stopwatch: Stopwatch::new(device, queue),
            canvas,
            orbit: Orbit::new(&args.scene.build()),
            per_frame: args.spp,
            schedule: args.schedule(),
            frame: 0,
            drawn: Instant::now(),
            screen,
        })
    }

    /// Starts over with images of another size. Keeps the denoiser.
    ///
    /// # Errors
    /// If the device cannot hold them.
    pub(super) fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        self.screen.resize(size);
        let (device, seed) = (&self.screen.device, self.canvas.film.seed);
        let Self { stage, denoiser, present, .. } = &*self;
        self.canvas = Canvas::new(&stage.renderer, denoiser, present, device, (size, seed))?;
        Ok(())
    }

    /// Moves the camera.
    pub(super) fn look(&mut self, change: impl FnOnce(&mut Orbit)) {
        change(&mut self.orbit);
    }

    /// Samples per pixel so far.
    pub(super) fn samples(&self) -> u32 {
        self.canvas.film.samples
    }

    /// Width of the window in pixels.
    pub(super) fn width(&self) -> f32 {
        self.screen.config.width as f32
    }

    /// Draws a frame and waits for it; returns `None` while the window cannot be drawn to.
    ///
    /// # Errors
    /// If the device fails.
    pub(super) fn draw(&mut self, controls: &Controls) -> Result<Option<Times>> {
        let Some(target) = self.screen.next()? else { return Ok(None) };
        let view = target.texture.create_view(&Default::default());
        self.stopwatch.start();
        let moment = self.moment(controls.animate);
        self.stage.show(moment, &mut self.canvas.film)?;
        let mut encoder = self.screen.device.create_command_encoder(&Default::default());
        self.record(&mut encoder, controls, &view);
        self.screen.queue.submit([encoder.finish()]);
        self.screen.queue.present(target);
        self.stopwatch.stop(&self.screen.device).map(Some)
    }

    /// The next frame's moment.
    fn moment(&mut self, animate: bool) -> Moment {
        let since = std::mem::replace(&mut self.drawn, Instant::now()).elapsed();
        let step = if animate { since.as_secs_f32().min(LONGEST_STEP) } else { 0.0 };
        Moment { time: (self.stage.now().time + step) % PERIOD, camera: self.orbit.camera() }
    }

    /// Records the whole frame.
    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        controls: &Controls,
        target: &wgpu::TextureView,
    ) {
        let split = controls.split(self.width());
        self.present.write_split(&self.screen.queue, split);
        let canvas = &mut self.canvas;
        if canvas.film.samples == 0 {
            (self.frame, canvas.stale) = (0, true);
        }
        self.stage.encode(encoder, &mut canvas.film, self.per_frame, self.stopwatch.render());
        if split.divider >= self.screen.config.width as f32 {
            (canvas.stale, canvas.skipped) = (true, true);
        } else if canvas.stale || self.schedule.due(self.frame) {
            self.stage.encode_motion(encoder, &canvas.motion);
            let share = self.schedule.blend(canvas.film.samples);
            let frames = if controls.temporal { history(self.frame) } else { 0.0 };
            canvas.denoise(share, frames, encoder);
        }
        self.frame += 1;
        self.present.encode(encoder, &self.canvas.images, target, self.stopwatch.present());
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
        let motion = renderer.motion(size)?;
        let denoised = Denoised::new(denoiser, device, &film, Some(&motion))?;
        let images = present.bind(device, &film.color, &denoised.output);
        Ok(Self { film, motion, denoised, images, stale: true, skipped: false })
    }

    /// Records the denoiser with this share of noisy color, averaging at most this many earlier
    /// frames.
    fn denoise(&mut self, share: f32, frames: f32, encoder: &mut wgpu::CommandEncoder) {
        let pass = &self.denoised.pass;
        pass.set_blend(share);
        pass.set_history(frames);
        if self.skipped {
            pass.reset_history();
        }
        pass.encode(encoder);
        (self.stale, self.skipped) = (false, false);
    }
}
