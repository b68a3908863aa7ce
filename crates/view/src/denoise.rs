//! Denoising on the window's device, as the command line does it.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use wgdenoise::wgpu::DeviceType;
use wgdenoise::{Denoiser, Frame, MatrixShape, Options, Precision, Progress, Quality, Weights};
use wgdenoise_files::{Denoised, View};

use crate::gpu::canvas::Canvas;
use crate::gpu::host::Gpu;
use crate::gpu::texture::Texture;
use crate::open::Opened;
use crate::state::settings::{Alpha, Settings};

/// The denoiser that was used last, with its device and the window's.
#[derive(Debug)]
pub(crate) struct Engine {
    window: Gpu,
    gpu: Gpu,
    made: Option<(Key, Denoiser)>,
}

/// What a denoiser is made for.
type Key = (Quality, Precision, bool);

/// A picture that has been denoised.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// By view.
    pub(crate) results: Vec<Denoised>,
    /// The color of the view that is shown, on the window's device.
    pub(crate) texture: Texture,
    /// The time it took, without compiling kernels.
    pub(crate) took: Duration,
    /// The time to compile kernels and upload weights, if that was needed.
    pub(crate) prepared: Option<Duration>,
    /// Tiles and memory, in words.
    pub(crate) plan: String,
    /// What the user should know, a sentence each.
    pub(crate) notices: Vec<String>,
}

impl Engine {
    pub(crate) fn new(window: Gpu) -> Self {
        Self { gpu: window.for_denoiser(), window, made: None }
    }

    /// Denoises every view until `stop` is set; `progress` receives what is done, from 0 to 1.
    ///
    /// # Errors
    /// The sentence of the engine's error.
    pub(crate) fn denoise(
        &mut self,
        opened: &Opened,
        settings: Settings,
        stop: &AtomicBool,
        progress: &mut dyn FnMut(f32),
    ) -> Result<Outcome, String> {
        let prepared = self.prepare(settings)?;
        let Some((_, denoiser)) = &self.made else { unreachable!("it was just prepared") };
        let (start, views) = (Instant::now(), opened.picture.views());
        let shown = frame(opened.view(), settings);
        let canvas = Canvas::new(&self.window, &self.gpu, opened.size(), shown.alpha.is_some())?;
        let mut results = Vec::new();
        for (i, view) in views.iter().enumerate() {
            let mut within = |step: Progress<'_>| {
                let done = step.done as f32 / step.total.max(1) as f32;
                progress((i as f32 + done) / views.len() as f32);
                step.tile.filter(|_| i == opened.shown).into_iter().for_each(|t| canvas.add(t));
            };
            let frame = frame(view, settings).stop(stop);
            results.push(denoise_view(denoiser, &frame, view, &mut within)?);
        }
        let texture = canvas.finish(&results[opened.shown].color)?;
        let took = start.elapsed();
        let plan = plan(denoiser, &shown)?;
        let notices = denoiser.take_notices();
        Ok(Outcome { results, texture, took, prepared, plan, notices })
    }

    /// Makes the denoiser that the settings need; returns how long that took.
    fn prepare(&mut self, settings: Settings) -> Result<Option<Duration>, String> {
        let key = (settings.quality, settings.precision, settings.skip_clean);
        if self.made.as_ref().is_some_and(|(made, _)| *made == key) {
            return Ok(None);
        }
        let start = Instant::now();
        // Its memory may be needed.
        self.made = None;
        let Gpu { adapter, device, queue, .. } = &self.gpu;
        let options = Options::default()
            .precision(settings.precision)
            .skip_clean(settings.skip_clean)
            .tile(tile(adapter.get_info().device_type))
            .matrix(MatrixShape::of(adapter, settings.precision));
        let weights = Weights::builtin(settings.quality).map_err(|error| error.to_string())?;
        let denoiser = Denoiser::new(device, queue, &weights, &options);
        self.made = Some((key, denoiser.map_err(|error| error.to_string())?));
        Ok(Some(start.elapsed()))
    }
}

/// On a CPU driver, the window waits for the layer of the network that runs, so tiles are small there.
/// Tiles never change the result.
fn tile(device: DeviceType) -> Option<u32> {
    (device == DeviceType::Cpu).then_some(1024)
}

fn denoise_view(
    denoiser: &Denoiser,
    frame: &Frame<'_>,
    view: &View,
    progress: &mut dyn FnMut(Progress<'_>),
) -> Result<Denoised, String> {
    let layers: Vec<_> = view.layers().iter().map(|layer| &layer.image).collect();
    let found = denoiser
        .denoise_layers(&frame.layers(&layers), progress)
        .map_err(|error| error.to_string())?;
    Ok(Denoised { color: found.color, alpha: found.alpha, layers: found.layers })
}

fn frame(view: &View, settings: Settings) -> Frame<'_> {
    let takes_alpha = match settings.alpha {
        Alpha::Auto => view.has_fractional_alpha(),
        Alpha::Keep => false,
        Alpha::Denoise => true,
    };
    Frame::new(view.color())
        .albedo(view.albedo().filter(|_| settings.albedo))
        .normal(view.normal().filter(|_| settings.normal))
        .alpha(view.alpha().filter(|_| takes_alpha))
        .panorama(view.is_panorama())
}

/// How a frame is cut into tiles, and the memory that takes.
fn plan(denoiser: &Denoiser, frame: &Frame<'_>) -> Result<String, String> {
    let (plan, bytes) = denoiser.frame_plan(frame).map_err(|error| error.to_string())?;
    let (count, [w, h], memory) = (plan.tiles.len(), plan.tile, bytes.div_ceil(1 << 20));
    let tiles = if count == 1 { "tile" } else { "tiles" };
    Ok(format!("{count} {tiles} of {w}×{h}, {memory} MiB of GPU memory"))
}
