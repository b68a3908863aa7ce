//! Denoises on the window's device, as the command line does.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use wgdenoise::{Denoiser, FinishedTile, Frame, Progress};
use wgdenoise_files::{Denoised, Picture, View, fit};

use crate::gpu::canvas::Canvas;
use crate::gpu::host::Gpu;
use crate::gpu::texture::Texture;
use crate::networks::{Key, Networks};
use crate::open::{Opened, sentence};
use crate::state::settings::{Settings, Source};

/// The networks used last, with the window's device and the one they run on.
#[derive(Debug)]
pub(crate) struct Engine {
    window: Gpu,
    gpu: Gpu,
    made: Option<(Key, Networks)>,
}

/// A denoised picture.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// One result per view.
    pub(crate) results: Vec<Denoised>,
    /// The shown view's color, on the window's device.
    pub(crate) texture: Texture,
    /// The settings that produced it.
    pub(crate) settings: Settings,
    /// Total time without compiling kernels.
    pub(crate) took: Duration,
    /// Time the network ran on the GPU.
    pub(crate) network_time: Duration,
    /// Time to compile kernels and upload weights, if that was needed.
    pub(crate) prepared: Option<Duration>,
    /// Tiles and memory, in words.
    pub(crate) plan: String,
    /// Notices for the user, one sentence each.
    pub(crate) notices: Vec<String>,
}

impl Engine {
    pub(crate) fn new(window: Gpu) -> Self {
        Self { gpu: window.for_denoiser(), window, made: None }
    }

    /// Denoises every view until `stop` is set; `progress` receives the completed share, 0 to 1.
    ///
    /// # Errors
    /// The engine's error as a sentence.
    pub(crate) fn denoise(
        &mut self,
        opened: &Opened,
        settings: &Settings,
        stop: &AtomicBool,
        progress: &mut dyn FnMut(f32),
    ) -> Result<Outcome, String> {
        let picture = &opened.picture;
        let prepared = self.prepare(picture, settings)?;
        let Some((key, networks)) = &self.made else { unreachable!("it was just prepared") };
        let (denoiser, metadata) = (&networks.color, networks.color.weights().metadata());
        fit::check(metadata, picture, &opened.path, None).map_err(|error| sentence(&error))?;
        let (start, views) = (Instant::now(), picture.views());
        let shown = frame(denoiser, opened.view(), settings);
        let canvas = Canvas::new(&self.window, &self.gpu, opened.size(), shown.alpha.is_some())?;
        let (mut results, mut network_time) = (Vec::new(), Duration::ZERO);
        for (i, view) in views.iter().enumerate() {
            let mut within = |share: f32, tile: Option<FinishedTile<'_>>| {
                progress((i as f32 + share) / views.len() as f32);
                tile.filter(|_| i == opened.shown).into_iter().for_each(|tile| canvas.add(tile));
            };
            let frame = frame(denoiser, view, settings).stop(stop);
            let (result, time) = denoise_view(networks, &frame, view, &mut within)?;
            results.push(result);
            network_time += time;
        }
        let texture = canvas.finish(&results[opened.shown].color)?;
        let took = start.elapsed();
        let plan = plan(denoiser, &shown)?;
        let notices = key.notice(settings).into_iter().chain(denoiser.take_notices());
        let notices = notices.chain(notices_on_fit(denoiser, picture, settings)).collect();
        Ok(Outcome {
            results,
            texture,
            settings: settings.clone(),
            took,
            network_time,
            prepared,
            plan,
            notices,
        })
    }

    /// Builds the networks that the settings need; returns the time that took.
    fn prepare(
        &mut self,
        picture: &Picture,
        settings: &Settings,
    ) -> Result<Option<Duration>, String> {
        let inputs = light(picture.first(), settings).inputs();
        let key = Key::of(settings, inputs, !picture.is_display_referred())?;
        if self.made.as_ref().is_some_and(|(made, _)| *made == key) {
            return Ok(None);
        }
        let start = Instant::now();
        // Frees its memory, which the new networks may need.
        self.made = None;
        let networks = Networks::new(&self.gpu, &key)?;
        self.made = Some((key, networks));
        Ok(Some(start.elapsed()))
    }
}

/// Denoises a view; also returns how long the network ran. `progress` receives the completed share
/// and the finished tiles.
fn denoise_view(
    networks: &Networks,
    frame: &Frame<'_>,
    view: &View,
    progress: &mut dyn FnMut(f32, Option<FinishedTile<'_>>),
) -> Result<(Denoised, Duration), String> {
    let [albedo, normal] = networks.prefiltered(frame).map_err(|error| error.to_string())?;
    let frame = frame.albedo(albedo.as_ref().or(frame.albedo));
    let frame = frame.normal(normal.as_ref().or(frame.normal));
    let layers: Vec<_> = view.layers().iter().map(|layer| &layer.image).collect();
    let mut network_time = Duration::ZERO;
    let mut within = |step: Progress<'_>| {
        network_time = step.network_time;
        progress(step.done as f32 / step.total.max(1) as f32, step.tile);
    };
    let found = networks.color.denoise_layers(&frame.layers(&layers), &mut within);
    let wgdenoise::Denoised { color, alpha, layers, .. } = found.map_err(|e| e.to_string())?;
    Ok((Denoised { color, alpha, layers }, network_time))
}

/// The view's images without alpha.
fn light<'a>(view: &'a View, settings: &Settings) -> Frame<'a> {
    Frame::new(view.color())
        .albedo(view.albedo().filter(|_| settings.albedo))
        .normal(view.normal().filter(|_| settings.normal))
        .panorama(view.is_panorama())
}

fn frame<'a>(denoiser: &Denoiser, view: &'a View, settings: &Settings) -> Frame<'a> {
    let metadata = denoiser.weights().metadata();
    let (takes_alpha, _) = fit::alpha(settings.alpha, view, None, metadata);
    light(view, settings).alpha(view.alpha().filter(|_| takes_alpha))
}

/// Notices on mismatches between the weights and the image, and on how alpha is handled.
fn notices_on_fit(denoiser: &Denoiser, picture: &Picture, settings: &Settings) -> Vec<String> {
    let (metadata, view) = (denoiser.weights().metadata(), picture.first());
    let (_, alpha) = fit::alpha(settings.alpha, view, None, metadata);
    let is_named = matches!(settings.weights, Source::File(_));
    let fit = fit::notices(metadata, is_named, view, !picture.is_display_referred());
    let pixels = fit::unusable_pixels(metadata, view.color());
    let all = fit.into_iter().chain(pixels).chain(alpha.map(Into::into));
    all.collect()
}

/// Describes a frame's tiles and the memory they take.
fn plan(denoiser: &Denoiser, frame: &Frame<'_>) -> Result<String, String> {
    let (plan, bytes) = denoiser.frame_plan(frame).map_err(|error| error.to_string())?;
    let (count, [w, h], memory) = (plan.tiles.len(), plan.tile, bytes.div_ceil(1 << 20));
    let tiles = if count == 1 { "tile" } else { "tiles" };
    Ok(format!("{count} {tiles} of {w}×{h}, {memory} MiB of GPU memory"))
}
