//! Denoising on the window's device, as the command line does it.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use wgdenoise::wgpu::DeviceType;
use wgdenoise::{Denoiser, Frame, MatrixShape, Options, Precision, Quality, Weights};
use wgdenoise_files::{Denoised, Picture, View};

use crate::gpu::host::Gpu;
use crate::state::settings::{Alpha, Settings};

/// The device with the denoiser that was used last.
#[derive(Debug)]
pub(crate) struct Engine {
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
    pub(crate) fn new(gpu: Gpu) -> Self {
        Self { gpu, made: None }
    }

    /// Denoises every view until `stop` is set; `progress` receives what is done, from 0 to 1.
    ///
    /// # Errors
    /// The sentence of the engine's error.
    pub(crate) fn denoise(
        &mut self,
        picture: &Picture,
        settings: Settings,
        stop: &AtomicBool,
        progress: &mut dyn FnMut(f32),
    ) -> Result<Outcome, String> {
        let prepared = self.prepare(settings)?;
        let Some((_, denoiser)) = &self.made else { unreachable!("it was just prepared") };
        let (start, views) = (Instant::now(), picture.views());
        let mut results = Vec::new();
        for (i, view) in views.iter().enumerate() {
            let mut within = |done: usize, total: usize| {
                progress((i as f32 + done as f32 / total.max(1) as f32) / views.len() as f32);
            };
            results.push(denoise_view(
                denoiser,
                &frame(view, settings).stop(stop),
                view,
                &mut within,
            )?);
        }
        let took = start.elapsed();
        let plan = plan(denoiser, &frame(picture.first(), settings))?;
        let notices = denoiser.take_notices();
        Ok(Outcome { results, took, prepared, plan, notices })
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
        let Gpu { adapter, device, queue } = &self.gpu;
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
    progress: &mut dyn FnMut(usize, usize),
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
