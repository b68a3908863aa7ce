//! Values of flags.

use std::time::Duration;

use clap::ValueEnum;
use clap::builder::{RangedI64ValueParser, RangedU64ValueParser};

use wgdenoise::{KernelSet, MatrixShape, Precision, Quality};

/// [`Quality`] on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum QualityArg {
    /// The least work
    Fast,
    /// Between the two
    Balanced,
    /// The best picture
    High,
}

/// [`Precision`] on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum PrecisionArg {
    /// 32-bit float
    F32,
    /// 16-bit float: half the memory
    F16,
}

/// [`KernelSet`] on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum KernelsArg {
    /// The fastest for the adapter
    Auto,
    /// The readable definition
    Plain,
    /// For GPUs
    Tiled,
    /// For CPU drivers
    Simd,
    /// For GPUs with matrix units
    Matrix,
}

impl From<QualityArg> for Quality {
    fn from(quality: QualityArg) -> Self {
        match quality {
            QualityArg::Fast => Self::Fast,
            QualityArg::Balanced => Self::Balanced,
            QualityArg::High => Self::High,
        }
    }
}

impl From<PrecisionArg> for Precision {
    fn from(precision: PrecisionArg) -> Self {
        match precision {
            PrecisionArg::F32 => Self::F32,
            PrecisionArg::F16 => Self::F16,
        }
    }
}

impl KernelsArg {
    /// The set, where `matrix` is what the adapter can do; `None` if it cannot.
    pub(super) fn set(self, matrix: Option<MatrixShape>) -> Option<KernelSet> {
        match self {
            Self::Auto => Some(KernelSet::Auto),
            Self::Plain => Some(KernelSet::Plain),
            Self::Tiled => Some(KernelSet::Tiled),
            Self::Simd => Some(KernelSet::Simd),
            Self::Matrix => matrix.map(KernelSet::Matrix),
        }
    }
}

/// A side of an image.
pub(super) fn side() -> RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(1..=65536)
}

/// A number of pixels.
pub(super) fn pixels() -> RangedU64ValueParser<u64> {
    clap::value_parser!(u64).range(1..=1 << 40)
}

/// A finite number above 0.
pub(super) fn positive(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && f32::is_finite(value) => Ok(value),
        _ => Err("expected a number above 0".into()),
    }
}

/// A time above 0.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    match Duration::try_from_secs_f32(positive(text)?) {
        Ok(Duration::ZERO) => Err("expected at least a nanosecond".into()),
        time => time.map_err(|error| error.to_string()),
    }
}
