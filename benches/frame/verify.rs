//! Verifies what is timed.

use wgdenoise::internals::reference::{self, Images};
use wgdenoise::{Denoiser, Frame, Image, KernelSet, Precision, Result, Weights};

const SIZE: [u32; 2] = [33, 17];

/// Returns the largest difference from the CPU reference in the transfer domain; panics if it
/// exceeds what the precision explains.
pub(crate) fn error(denoiser: &Denoiser, weights: &Weights, precision: Precision) -> Result<f64> {
    let [width, height] = SIZE;
    let color = noise(width, height)?;
    let frame = Frame::new(&color).albedo(&color).normal(&color);
    let found = denoiser.denoise(&frame)?;
    let scale = reference::autoexposure(&color);
    let images = Images { color: &color, albedo: Some(&color), normal: Some(&color) };
    let expected = reference::denoise(weights, images, scale);
    let encode = |v: &f32| reference::pu(f64::from(*v) * f64::from(scale));
    let values = found.pixels().iter().flatten().zip(expected.pixels().iter().flatten());
    let error = values.map(|(a, b)| (encode(a) - encode(b)).abs()).fold(0.0, f64::max);
    // As for the whole network in the tests. Matrices round their factors as 16-bit tensors do, and
    // the half kernels also round their sums.
    let allowed = match (denoiser.kernels(), precision) {
        (KernelSet::Half, _) => 26e-3,
        (KernelSet::Matrix(_), _) | (_, Precision::F16) => 6e-3,
        _ => 4e-6,
    };
    let finite = found.pixels().iter().flatten().all(|v| v.is_finite());
    assert!(finite && error <= allowed, "{error} from the reference, allowed {allowed}");
    Ok(error)
}

/// Patternless values in `[0, 1)`, the same in every run.
fn noise(width: u32, height: u32) -> Result<Image> {
    let value = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32;
    let pixel = |i: u32| [value(3 * i + 1), value(3 * i + 2), value(3 * i + 3)];
    Image::new(width, height, (0..width * height).map(pixel).collect())
}
