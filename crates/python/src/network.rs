//! A denoiser of arrays on a device.

use std::path::PathBuf;
use std::time::Duration;

use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;
use wgdenoise::{
    Denoised, Denoiser, Frame, Gpu, MatrixShape, Options, Precision, Progress, Quality, Weights,
};
use wgdenoise_cli::host;

use crate::arrays;
use crate::errors;
use crate::images::{Given, Images};
use crate::watch::Watch;

/// Compiled kernels and weights on a device. Can be shared by threads.
#[pyclass(frozen)]
pub(crate) struct Network {
    denoiser: Denoiser,
    device: String,
}

/// The network's settings, under their Python names.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Settings {
    quality: String,
    weights: Option<PathBuf>,
    precision: String,
    device: Option<String>,
    memory_bytes: Option<u64>,
    tile: Option<u32>,
    timeout: Option<f64>,
    skip_clean: bool,
    keep_memory: bool,
}

/// The denoised color, layers, and alpha unless it is part of the color.
type Arrays<'py> =
    (Bound<'py, PyArray3<f32>>, Vec<Bound<'py, PyArray3<f32>>>, Option<Bound<'py, PyArray2<f32>>>);

#[pymethods]
impl Network {
    #[new]
    fn new(py: Python<'_>, settings: Settings) -> PyResult<Self> {
        let weights = settings.weights(py)?;
        let options = settings.options(py)?;
        let open = || Self::open(settings.device.as_deref(), &weights, options);
        py.detach(open).map_err(|error| errors::of_engine(py, &error))
    }

    /// The adapter's name.
    #[getter]
    fn device(&self) -> &str {
        &self.device
    }

    /// The running kernel variant.
    #[getter]
    fn kernels(&self) -> String {
        self.denoiser.kernels().to_string()
    }

    /// Returns the notices for the user, each once.
    fn take_notices(&self) -> Vec<String> {
        self.denoiser.take_notices()
    }

    /// Denoises the images of a view.
    fn denoise<'py>(
        &self,
        py: Python<'py>,
        given: Given<'py>,
        input_scale: Option<f32>,
        panorama: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Arrays<'py>> {
        let images = Images::read(py, &given)?;
        let watch = Watch::new(progress);
        let run = py.detach(|| self.run(&images, input_scale, panorama, &watch));
        let run = run.map_err(|error| errors::of_engine(py, &error));
        let Denoised { color, layers, alpha, .. } = watch.outcome(run)?;
        // Noise-free alpha was not denoised.
        let alpha = alpha.as_deref().or(images.alpha.as_deref());
        let fourth = alpha.filter(|_| images.has_fourth_channel);
        let own = alpha.filter(|_| !images.has_fourth_channel);
        Ok((
            arrays::color(py, &color, fourth),
            layers.iter().map(|layer| arrays::color(py, layer, None)).collect(),
            own.map(|alpha| arrays::plane(py, alpha, color.size())),
        ))
    }
}

impl Network {
    /// Opens a device as the command line does.
    fn open(device: Option<&str>, weights: &Weights, options: Options) -> wgdenoise::Result<Self> {
        let gpu = Gpu::open(device)?;
        let options = options.clone().matrix(MatrixShape::of(&gpu.adapter, options.precision));
        let denoiser = Denoiser::new(&gpu.device, &gpu.queue, weights, &options)?;
        Ok(Self { denoiser, device: gpu.info.name })
    }

    fn run(
        &self,
        images: &Images,
        input_scale: Option<f32>,
        panorama: bool,
        watch: &Watch,
    ) -> wgdenoise::Result<Denoised> {
        let layers: Vec<_> = images.layers.iter().collect();
        let frame = Frame::new(&images.color)
            .albedo(&images.albedo)
            .normal(&images.normal)
            .input_scale(input_scale)
            .panorama(panorama)
            .layers(&layers)
            .alpha(images.noisy_alpha())
            .stop(watch.flag());
        self.denoiser.denoise_layers(&frame, &mut |step: Progress<'_>| {
            watch.step(step.done as u64, step.total as u64);
        })
    }
}

impl Settings {
    fn weights(&self, py: Python<'_>) -> PyResult<Weights> {
        if let Some(path) = &self.weights {
            return host::weights(path).map_err(|failure| errors::of_program(py, &failure));
        }
        let names = Quality::ALL.map(Quality::name);
        let index = chosen(py, "quality", &self.quality, &names)?;
        Weights::builtin(Quality::ALL[index]).map_err(|error| errors::of_engine(py, &error))
    }

    fn options(&self, py: Python<'_>) -> PyResult<Options> {
        let index = chosen(py, "precision", &self.precision, &["f16", "f32"])?;
        if self.tile == Some(0) {
            return Err(errors::of_usage(py, "tile is 0, expected at least 1 pixel"));
        }
        let default = Options::default();
        let memory_bytes = self.memory_bytes.unwrap_or(default.memory_bytes);
        Ok(default
            .precision([Precision::F16, Precision::F32][index])
            .memory_bytes(memory_bytes)
            .tile(self.tile)
            .timeout(self.timeout(py)?)
            .skip_clean(self.skip_clean)
            .keep_memory(self.keep_memory))
    }

    fn timeout(&self, py: Python<'_>) -> PyResult<Option<Duration>> {
        let Some(seconds) = self.timeout else { return Ok(None) };
        match Duration::try_from_secs_f64(seconds) {
            Ok(duration) if !duration.is_zero() => Ok(Some(duration)),
            _ => {
                let what = format!("timeout is {seconds}, expected a number of seconds above 0");
                Err(errors::of_usage(py, &what))
            }
        }
    }
}

/// Finds a name in a list of known ones.
fn chosen(py: Python<'_>, argument: &str, name: &str, names: &[&str]) -> PyResult<usize> {
    names.iter().position(|known| *known == name).ok_or_else(|| {
        let (last, others) = names.split_last().expect("there are names");
        let known = format!("{} or {last}", others.join(", "));
        errors::of_usage(py, &format!("{argument} is {name}, expected {known}"))
    })
}
