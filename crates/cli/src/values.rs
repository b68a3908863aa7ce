//! Parsers of flag values.

use std::time::Duration;

use bytesize::ByteSize;
use clap::ValueEnum;
use clap::builder::{RangedI64ValueParser, RangedU64ValueParser};

use crate::request::Kernels;
use wgdenoise::{KernelSet, Precision, Quality};
use wgdenoise_files::Format;

/// [`Quality`] on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum QualityArg {
    /// Least work
    Fast,
    /// In between
    Balanced,
    /// Best result
    High,
}

/// [`Precision`] on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum PrecisionArg {
    /// 32-bit float
    F32,
    /// 16-bit float: half the memory
    F16,
}

/// [`Format`] on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FormatArg {
    /// Light of any brightness
    Exr,
    /// Display colors
    Png,
    /// Display colors without alpha
    #[value(alias = "jpeg")]
    Jpg,
}

/// [`Kernels`] on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum KernelsArg {
    /// The fastest for the adapter
    Auto,
    /// The readable definition
    Plain,
    /// For GPUs
    Tiled,
    /// For GPUs, with other tiles
    Wide,
    /// For GPUs, in 16-bit arithmetic
    Half,
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

impl From<FormatArg> for Format {
    fn from(format: FormatArg) -> Self {
        match format {
            FormatArg::Exr => Self::Exr,
            FormatArg::Png => Self::Png,
            FormatArg::Jpg => Self::Jpeg,
        }
    }
}

impl From<KernelsArg> for Kernels {
    fn from(kernels: KernelsArg) -> Self {
        match kernels {
            KernelsArg::Auto => Self::Set(KernelSet::Auto),
            KernelsArg::Plain => Self::Set(KernelSet::Plain),
            KernelsArg::Tiled => Self::Set(KernelSet::Tiled),
            KernelsArg::Wide => Self::Set(KernelSet::Wide),
            KernelsArg::Half => Self::Set(KernelSet::Half),
            KernelsArg::Simd => Self::Set(KernelSet::Simd),
            KernelsArg::Matrix => Self::Matrix,
        }
    }
}

/// A side of an image in pixels.
pub(crate) fn side() -> RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(1..=65536)
}

/// A number of pixels.
pub(crate) fn pixels() -> RangedU64ValueParser<u64> {
    clap::value_parser!(u64).range(1..=1 << 40)
}

/// A number of runs.
pub(crate) fn runs() -> RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(1..=10_000)
}

/// A finite number above 0 that keeps full precision as a 32-bit float.
pub(crate) fn positive(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && f32::is_normal(value) => Ok(value),
        _ => Err("expected a number from 1.2e-38 to 3.4e38".into()),
    }
}

/// Stops of exposure; beyond ±64, everything is black or white.
pub(crate) fn stops(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(value) if (-64.0..=64.0).contains(&value) => Ok(value),
        _ => Err("expected stops from -64 to 64, such as 1.5 or -2".into()),
    }
}

/// A time above 0 with a unit.
pub(crate) fn time(text: &str) -> Result<Duration, String> {
    match humantime::parse_duration(text) {
        Ok(time) if time > Duration::ZERO => Ok(time),
        _ if lacks_only_a_unit(text) => {
            Err(format!("a time needs a unit: write {text}s or {text}ms"))
        }
        _ => Err("expected a time above 0 with a unit, such as 60s or 40ms".into()),
    }
}

/// An amount of memory with a unit, in bytes.
pub(crate) fn memory(text: &str) -> Result<u64, String> {
    if lacks_only_a_unit(text) {
        return Err(format!("memory needs a unit: write {text}MiB or {text}GiB"));
    }
    match text.parse().map(|ByteSize(bytes)| bytes) {
        Ok(bytes) if (1 << 20..=1 << 44).contains(&bytes) => Ok(bytes),
        _ => Err("expected 1MiB to 16TiB with a unit, such as 512MiB or 2GiB".into()),
    }
}

/// Whether the text is an amount that lacks only its unit.
fn lacks_only_a_unit(text: &str) -> bool {
    text.parse().is_ok_and(|value: f64| value > 0.0 && value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_required_and_the_right_form_is_shown() {
        assert_eq!(time("60s"), Ok(Duration::from_mins(1)));
        assert_eq!(time("4.7ms"), Ok(Duration::from_micros(4700)));
        assert_eq!(time("1m 30s"), Ok(Duration::from_secs(90)));
        assert_eq!(memory("2GiB"), Ok(2 << 30));
        assert_eq!(memory("512 MiB"), Ok(512 << 20));
        assert_eq!(memory("3GB"), Ok(3_000_000_000));
        for text in ["60", "1e3", ".5"] {
            let error = time(text).unwrap_err();
            assert!(error.contains("unit") && error.contains("ms"), "{text}: {error}");
            let error = memory(text).unwrap_err();
            assert!(error.contains("unit") && error.contains("GiB"), "{text}: {error}");
        }
    }

    #[test]
    fn what_is_no_amount_is_refused() {
        for text in ["", "s", "soon", "0s", "0ms", "-1s", "5 parsecs", "99999999999999999999s"] {
            assert!(time(text).is_err(), "{text}");
        }
        for text in ["0", "-1", "nan", "inf"] {
            assert!(time(text).unwrap_err().ends_with("such as 60s or 40ms"), "{text}");
            assert!(memory(text).unwrap_err().ends_with("such as 512MiB or 2GiB"), "{text}");
        }
        for text in ["", "GiB", "much", "0MiB", "1KiB", "17TiB", "99999999999999999999EiB", "-1GiB"]
        {
            assert!(memory(text).is_err(), "{text}");
        }
        assert!(["nan", "inf", "65", "bright"].iter().all(|text| stops(text).is_err()));
        assert_eq!((stops("-1.5"), positive("0.5")), (Ok(-1.5), Ok(0.5)));
    }
}
