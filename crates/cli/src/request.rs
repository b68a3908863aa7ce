//! What a command line asks for, as plain types.

use std::path::{Path, PathBuf};
use std::time::Duration;

use wgdenoise::{KernelSet, MatrixShape, Precision, Quality};
use wgdenoise_files::frames::Frames;
use wgdenoise_files::{Format, LayerChoice, Limits, fit};

use crate::console::Verbosity;

/// One run of the program.
#[derive(Debug)]
pub(crate) enum Request {
    Denoise(Denoise),
    Info(Info),
    Preview(Preview),
    Compare(Compare),
    /// List the adapters, as JSON or text.
    Devices {
        json: bool,
    },
    Bench(Bench),
    Profile(Bench),
    Report(Report),
    Convert(Convert),
    /// Print these bytes: a completion script or the manual page.
    Print(Vec<u8>),
}

/// `wgdenoise IN... OUT`.
#[derive(Clone, Debug)]
pub(crate) struct Denoise {
    pub(crate) verbosity: Verbosity,
    /// Files, sequences and patterns, at least one.
    pub(crate) inputs: Vec<PathBuf>,
    /// `None` if each image replaces itself.
    pub(crate) output: Option<PathBuf>,
    /// The frames of a sequence to process; all by default.
    pub(crate) frames: Option<Frames>,
    pub(crate) layers: LayerChoice,
    /// How many frames on either side each frame is averaged with.
    pub(crate) temporal: usize,
    pub(crate) weights: WeightsChoice,
    pub(crate) device: DeviceChoice,
    /// The factor that scales color to the exposure the network was trained at; measured by
    /// default.
    pub(crate) input_scale: Option<f32>,
    /// Skip images whose output exists.
    pub(crate) skip_existing: bool,
    /// The format of standard output; that of the input by default.
    pub(crate) format: Option<Format>,
    /// Read the next image and write the last one while denoising.
    pub(crate) overlap: bool,
    /// What to do with the alpha; by default, denoise it if it is fractional.
    pub(crate) alpha: Option<Alpha>,
    /// Check part of each result against the CPU reference.
    pub(crate) verify: bool,
    /// Stops by which to brighten PNG and JPEG outputs.
    pub(crate) exposure: Option<f32>,
    pub(crate) writing: Writing,
}

impl Denoise {
    /// The files to read, and layers that may be files.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        let features = [&self.layers.albedo, &self.layers.normal].into_iter().flatten();
        self.inputs.iter().map(PathBuf::as_path).chain(features.map(Path::new))
    }
}

/// What to do with a picture's alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Alpha {
    /// Leave it as it is.
    Keep,
    /// Denoise it with the color's weights.
    Denoise,
}

impl From<Alpha> for fit::Alpha {
    fn from(alpha: Alpha) -> Self {
        match alpha {
            Alpha::Keep => Self::Keep,
            Alpha::Denoise => Self::Denoise,
        }
    }
}

/// What may be done to existing files and missing folders.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Writing {
    /// Replace outputs that exist.
    pub(crate) force: bool,
    /// Replace an input with its own result.
    pub(crate) in_place: bool,
    /// Create missing folders.
    pub(crate) parents: bool,
}

/// Where weights come from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum WeightsChoice {
    BuiltIn(Quality),
    File(PathBuf),
    /// A folder of Open Image Denoise's weights, from which each image gets those for its layers.
    Folder {
        path: PathBuf,
        quality: Option<Quality>,
        /// Denoise albedo and normal first.
        prefilter: bool,
    },
    /// The best built-in weights predicted to meet a time limit.
    Budget {
        limit: Duration,
        /// Ignore earlier measurements.
        recalibrate: bool,
    },
}

/// The adapter, and how to run the network on it.
#[derive(Clone, Debug)]
pub(crate) struct DeviceChoice {
    /// Part of a name, or an index; the fastest kind by default.
    pub(crate) adapter: Option<String>,
    pub(crate) precision: Option<Precision>,
    /// Bytes.
    pub(crate) memory: Option<u64>,
    /// Pixels.
    pub(crate) tile: Option<u32>,
    pub(crate) timeout: Option<Duration>,
    pub(crate) kernels: Kernels,
    pub(crate) skip_clean: bool,
}

/// A kernel set; the adapter decides the shape of matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kernels {
    Set(KernelSet),
    Matrix,
}

impl Kernels {
    /// The kernel set for the matrix shape that the adapter reports; `None` if the set needs one
    /// and there is none.
    pub(crate) fn on(self, matrix: Option<MatrixShape>) -> Option<KernelSet> {
        match self {
            Self::Set(set) => Some(set),
            Self::Matrix => matrix.map(KernelSet::Matrix),
        }
    }
}

/// `wgdenoise bench` and `wgdenoise profile`: denoise an image of random values.
#[derive(Clone, Debug)]
pub(crate) struct Bench {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) runs: u32,
    pub(crate) weights: WeightsChoice,
    pub(crate) device: DeviceChoice,
    pub(crate) json: bool,
}

/// `wgdenoise report`.
#[derive(Clone, Debug)]
pub(crate) struct Report {
    pub(crate) noisy: PathBuf,
    pub(crate) reference: PathBuf,
    pub(crate) layers: LayerChoice,
    pub(crate) runs: u32,
    pub(crate) device: DeviceChoice,
    /// The folder for `report.md`, `report.json` and `report.svg`.
    pub(crate) out: Option<PathBuf>,
    pub(crate) force: bool,
    pub(crate) json: bool,
}

/// `wgdenoise info`.
#[derive(Clone, Debug)]
pub(crate) struct Info {
    pub(crate) input: PathBuf,
    pub(crate) layers: LayerChoice,
    pub(crate) json: bool,
}

/// `wgdenoise compare`.
#[derive(Clone, Debug)]
pub(crate) struct Compare {
    pub(crate) image: PathBuf,
    pub(crate) reference: PathBuf,
    /// The layers to read from both files.
    pub(crate) layers: LayerChoice,
    pub(crate) json: bool,
}

/// `wgdenoise preview`.
#[derive(Clone, Debug)]
pub(crate) struct Preview {
    pub(crate) input: PathBuf,
    pub(crate) output: PathBuf,
    pub(crate) layer: Option<String>,
    /// Stops.
    pub(crate) exposure: f32,
    pub(crate) limits: Limits,
    pub(crate) writing: Writing,
}

/// `wgdenoise convert`.
#[derive(Clone, Debug)]
pub(crate) struct Convert {
    pub(crate) input: PathBuf,
    pub(crate) output: PathBuf,
    pub(crate) force: bool,
}
