//! One run on one device: opens the adapter, makes the denoisers, and denoises.
//!
//! Consecutive images with the same weights share a denoiser.

use crate::budget;
use crate::cache;
use crate::console::Console;
use crate::failure::Failure;
use crate::request::{DeviceChoice, WeightsChoice};
use crate::weights::Source;
use wgdenoise::{
    Denoised, Denoiser, Frame, Gpu, Inputs, MainImage, MatrixShape, Metadata, Options, Progress,
    Weights,
};
use wgdenoise_files::weights::{self, Subject};

/// Opens the adapter, with the engine's defaults for everything that was not chosen.
pub(crate) fn open(choice: &DeviceChoice) -> Result<(Gpu, Options), Failure> {
    let gpu = Gpu::open(choice.adapter.as_deref())?;
    let default = Options::default();
    let precision = choice.precision.unwrap_or(default.precision);
    let memory_bytes = choice.memory.unwrap_or(default.memory_bytes);
    let matrix = MatrixShape::of(&gpu.adapter, precision);
    let kernels = choice.kernels.on(matrix).ok_or_else(|| {
        let name = &gpu.info.name;
        Failure::Adapter(format!("{name} reports no matrices that fit; choose --kernels auto"))
    })?;
    let options = default
        .precision(precision)
        .memory_bytes(memory_bytes)
        .tile(choice.tile)
        .timeout(choice.timeout)
        .kernels(kernels)
        .matrix(matrix)
        .skip_clean(choice.skip_clean)
        .pipeline_cache(cache::pipelines(&gpu));
    Ok((gpu, options))
}

/// The device and the current denoisers.
pub(crate) struct Session<'a> {
    device_choice: &'a DeviceChoice,
    weights_choice: &'a WeightsChoice,
    console: &'a Console,
    /// Weights from the file that the user named, read first since every image needs them.
    named: Option<Weights>,
    device: Option<(Gpu, Options)>,
    engine: Option<Engine>,
}

/// Weights that have been read.
pub(crate) struct Networks {
    /// `None` if a time budget chooses.
    color: Option<(Source, Weights)>,
    /// For albedo and for normals.
    prefilter: Option<[Weights; 2]>,
}

/// A denoiser for color and, if asked for, one for albedo and one for normals before it.
struct Engine {
    /// `None` if a time budget has chosen.
    source: Option<Source>,
    denoiser: Denoiser,
    prefilter: Option<[Denoiser; 2]>,
}

impl<'a> Session<'a> {
    pub(crate) fn new(
        device_choice: &'a DeviceChoice,
        weights_choice: &'a WeightsChoice,
        console: &'a Console,
    ) -> Result<Self, Failure> {
        let named = match weights_choice {
            WeightsChoice::File(file) => Some(weights::load(file)?),
            _ => None,
        };
        let (device, engine) = (None, None);
        Ok(Self { device_choice, weights_choice, console, named, device, engine })
    }

    /// Reads the weights that an image with these inputs needs; `None` if the current denoisers
    /// have them. Weights are read before the adapter is opened, which takes longer to fail.
    pub(crate) fn networks(&self, inputs: Inputs, hdr: bool) -> Result<Option<Networks>, Failure> {
        if let WeightsChoice::Folder { prefilter: true, .. } = self.weights_choice
            && inputs != Inputs::ALL
        {
            return Err(Failure::Work(format!(
                "--prefilter needs albedo and normal, but the image has {inputs}; leave it out"
            )));
        }
        let subject = Subject { main: MainImage::Color, inputs, hdr, clean: false };
        let source = self.weights_choice.source(subject)?;
        if self.engine.as_ref().is_some_and(|engine| engine.source == source) {
            return Ok(None);
        }
        let load = |source: Source| {
            let named = self.named.as_ref();
            let weights = named.map_or_else(|| source.load(), |weights| Ok(weights.clone()))?;
            Ok::<_, Failure>((source, weights))
        };
        let color = source.map(load).transpose()?;
        Ok(Some(Networks { color, prefilter: self.weights_choice.prefilter()? }))
    }

    /// Opens the adapter, unless it is open.
    pub(crate) fn open(&mut self) -> Result<(), Failure> {
        if self.device.is_none() {
            self.device = Some(open(self.device_choice)?);
        }
        Ok(())
    }

    /// Replaces the current denoisers by ones with these weights. Returns what a user should know
    /// about the choice. A time budget is met for `frame`.
    pub(crate) fn prepare(
        &mut self,
        networks: Networks,
        frame: &Frame<'_>,
    ) -> Result<Vec<String>, Failure> {
        // Its memory may be needed.
        self.engine = None;
        let (gpu, options) = self.device.as_ref().expect("the adapter is open");
        // The memory budget is for one denoiser at a time.
        let options = &options.clone().keep_memory(networks.prefilter.is_none());
        let new = |weights: &Weights| Denoiser::new(&gpu.device, &gpu.queue, weights, options);
        let (source, denoiser) = match networks.color {
            Some((source, weights)) => (Some(source), new(&weights)?),
            None => (None, self.within_budget(gpu, options, frame)?),
        };
        let prefilter = match &networks.prefilter {
            Some([albedo, normal]) => Some([new(albedo)?, new(normal)?]),
            None => None,
        };
        let engine = Engine { source, denoiser, prefilter };
        self.console.detail(|| engine.describe(gpu));
        let notices = engine.notices();
        self.engine = Some(engine);
        Ok(notices)
    }

    fn within_budget(
        &self,
        gpu: &Gpu,
        options: &Options,
        frame: &Frame<'_>,
    ) -> Result<Denoiser, Failure> {
        let WeightsChoice::Budget { limit, recalibrate } = *self.weights_choice else {
            unreachable!("only a budget leaves the weights open");
        };
        let measured = budget::calibration(gpu, options, recalibrate, self.console)?;
        let (denoiser, chosen) = budget::choose(&measured, limit, gpu, options, frame)?;
        self.console.notice(&chosen);
        Ok(denoiser)
    }

    /// Denoises a frame with its layers and alpha. With `verify`, checks part of each network's
    /// result against the CPU reference.
    pub(crate) fn denoise(&self, frame: &Frame<'_>, verify: bool) -> Result<Denoised, Failure> {
        let engine = self.engine();
        let Some(prefilter) = &engine.prefilter else {
            return self.run(&engine.denoiser, frame, verify, (0, 1));
        };
        let images = [frame.albedo, frame.normal];
        let clean = |i: usize| {
            let alone = images[i].map(Frame::new);
            alone.map(|frame| self.run(&prefilter[i], &frame, verify, (i, 3))).transpose()
        };
        let [albedo, normal] = [clean(0)?, clean(1)?].map(|image| image.map(|image| image.color));
        let frame = frame.albedo(albedo.as_ref()).normal(normal.as_ref());
        self.run(&engine.denoiser, &frame, verify, (2, 3))
    }

    /// Runs one network, number `stage` of `stages` for this image.
    fn run(
        &self,
        denoiser: &Denoiser,
        frame: &Frame<'_>,
        verify: bool,
        (stage, stages): (usize, usize),
    ) -> Result<Denoised, Failure> {
        let plan = plan(denoiser, frame)?;
        self.console.detail(|| plan);
        let progress = &mut |step: Progress<'_>| {
            let fraction = step.done as f64 / step.total.max(1) as f64;
            self.console.within_item((stage as f64 + fraction) / stages as f64);
        };
        let result = denoiser.denoise_layers(frame, progress);
        denoiser.take_notices().iter().for_each(|notice| self.console.notice(notice));
        let result = result?;
        if verify {
            let verified = denoiser.verify(frame, &result.color)?;
            let told = verified.map_or(NOTHING_TO_VERIFY.into(), |verified| verified.to_string());
            self.console.notice(&told);
        }
        Ok(result)
    }

    /// The metadata of the color's weights.
    pub(crate) fn metadata(&self) -> &Metadata {
        self.engine().denoiser.weights().metadata()
    }

    /// Whether the user named the weights file, rather than a folder or a tier.
    pub(crate) fn weights_are_named(&self) -> bool {
        matches!(self.engine().source, Some(Source::Named(_)))
    }

    fn engine(&self) -> &Engine {
        self.engine.as_ref().expect("the denoisers have been made")
    }

    /// Saves what the driver compiled for the next run.
    pub(crate) fn close(self) {
        if let Some((gpu, options)) = &self.device {
            cache::keep_pipelines(gpu, options);
        }
    }
}

const NOTHING_TO_VERIFY: &str = "nothing to verify: the image has no noise";

/// Describes how a frame is cut into tiles, and the memory that this takes.
fn plan(denoiser: &Denoiser, frame: &Frame<'_>) -> Result<String, Failure> {
    let (own, (width, height)) = (frame.color.width(), denoiser.size_with_columns(frame)?);
    let (plan, bytes) = denoiser.frame_plan(frame)?;
    let memory = bytes.div_ceil(1 << 20);
    let (count, [w, h]) = (plan.tiles.len(), plan.tile);
    let tiles = if count == 1 { "tile" } else { "tiles" };
    let repeated = match width - own {
        0 => String::new(),
        columns => format!(" and {columns} repeated columns"),
    };
    let cut = format!("{own}×{height} pixels{repeated} in {count} {tiles} of {w}×{h}");
    Ok(format!("{cut}, {memory} MiB of GPU memory"))
}

impl Engine {
    fn notices(&self) -> Vec<String> {
        let weights = self.source.as_ref().and_then(Source::notice);
        let prefilter = self.prefilter.as_ref().map(|denoisers| {
            let [albedo, normal] = denoisers.each_ref().map(|d| &d.weights().metadata().name);
            format!("albedo and normal denoised first, by {albedo} and {normal}")
        });
        weights.into_iter().chain(prefilter).chain(self.denoiser.take_notices()).collect()
    }

    fn describe(&self, gpu: &Gpu) -> String {
        let (kernels, precision) = (self.denoiser.kernels(), self.denoiser.precision());
        format!(
            "on {} ({:?}, {:?}), kernels {kernels}, tensors in {precision:?}",
            gpu.info.name, gpu.info.backend, gpu.info.device_type
        )
    }
}
