//! Compares part of a denoised image with the CPU reference.

use std::cmp::Ordering;
use std::num::NonZero;
use std::thread;

use crate::denoiser::Denoiser;
use crate::denoiser::alpha::{gray, values, with_alpha};
use crate::denoiser::frame::{Denoised, Frame};
use crate::denoiser::panorama::Wrapped;
use crate::error::{Error, Result};
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::matrix_shape::{Factor, MatrixShape};
use crate::gpu::precision::Precision;
use crate::image::Image;
use crate::image::Rect;
use crate::model::{Encoding, Op, Params, TransferFunction};
use crate::plan::halo::{BLOCK, halo};
use crate::reference::{self, Images, Tensor};

/// The result of [`Denoiser::verify`]: differences between encoded colors, so `[0, 1]` spans the
/// network's range. Where light encodes above 1, the difference is relative.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Verified {
    /// The compared pixels.
    pub rect: Rect,
    /// The largest difference of any value.
    pub largest: f64,
    /// The root mean square of all differences.
    pub rms: f64,
}

impl Verified {
    fn moved_left(mut self, columns: u32) -> Self {
        self.rect.begin[0] -= columns;
        self.rect.end[0] -= columns;
        self
    }
}

impl std::fmt::Display for Verified {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { rect: Rect { begin: [x, y], .. }, largest, rms } = self;
        let [width, height] = self.rect.size();
        write!(
            f,
            "verified {width}×{height} pixels at ({x}, {y}): they differ from the CPU reference by \
             at most {largest:.1e} of the encoded range, {rms:.1e} on average"
        )
    }
}

/// Upper bound on the blocks whose noise is measured; this many take a tenth of a second.
const MOST_BLOCKS: usize = 4096;

impl Denoiser {
    /// Compares a result of [`denoise`](Self::denoise), or the color of
    /// [`denoise_layers`](Self::denoise_layers) if the frame has alpha, with the naive CPU
    /// reference, which computes in 64 bits. Checks the noisiest 16×16 block, out of up to 4096
    /// spread over the frame, and computes it along with the surroundings it depends on. Returns
    /// `None` if the frame has no noise.
    ///
    /// # Errors
    /// Fails if the images do not match, if an image that the weights need is missing, or if the
    /// result differs by more than rounding explains.
    pub fn verify(&self, frame: &Frame<'_>, result: &Image) -> Result<Option<Verified>> {
        let frame = self.readable(frame)?;
        if result.size() != frame.color.size() {
            let ((w, h), (width, height)) = (result.size(), frame.color.size());
            return Err(Error::Image(format!(
                "the result to verify is {w}×{h}, but the frame is {width}×{height}"
            )));
        }
        let verified = self.verified(&frame, result)?;
        if let Some(verified) = &verified {
            self.tolerance().judge(verified)?;
        }
        Ok(verified)
    }

    /// What [`verify`](Self::verify) judges.
    fn verified(&self, frame: &Frame<'_>, result: &Image) -> Result<Option<Verified>> {
        if frame.panorama {
            let wrapped = Wrapped::new(self, frame)?;
            let (result, columns) = (wrapped.wrap(result)?, wrapped.columns);
            let wrap =
                |alpha: &[f32]| Ok(values(&wrapped.wrap(&gray(alpha, frame.color.size())?)?));
            let alpha = frame.alpha.map(wrap).transpose()?;
            let scale = self.scale_of(frame);
            let flat = wrapped.frame().input_scale(scale).alpha(alpha.as_deref());
            let verified = self.verified_between(&flat, &result, columns)?;
            return Ok(verified.map(|verified| verified.moved_left(columns)));
        }
        self.verified_between(frame, result, 0)
    }

    /// [`verified`](Self::verified) without the first and last `margin` columns, a multiple of 16.
    fn verified_between(
        &self,
        frame: &Frame<'_>,
        result: &Image,
        margin: u32,
    ) -> Result<Option<Verified>> {
        let encoding = self.weights().metadata().encoding();
        let exposure = Exposure { encoding, scale: self.scale_of(frame) };
        let Some(rect) = noisiest(frame.color, exposure, margin) else { return Ok(None) };
        let (expected, crop) = self.expected(frame, exposure.scale, &rect)?;
        Ok(Some(compare(result, exposure, &rect, &expected, crop.begin)))
    }

    /// The frame's input scale, given or measured.
    fn scale_of(&self, frame: &Frame<'_>) -> f32 {
        self.known_scale(frame).unwrap_or_else(|| reference::autoexposure(frame.color))
    }

    /// The reference result for the part of the frame that `rect` depends on.
    fn expected(&self, frame: &Frame<'_>, scale: f32, rect: &Rect) -> Result<(Image, Rect)> {
        let weights = self.weights().for_inputs(frame.inputs())?;
        let network = weights.network();
        let alignment = network.alignment().max(BLOCK);
        let crop = around(rect, halo(network), alignment, frame.color.size());
        let [color, albedo, normal] = [Some(frame.color), frame.albedo, frame.normal]
            .map(|image| image.map(|image| cut(image, &crop)));
        let color = &color.expect("a frame has a color");
        let images = Images { color, albedo: albedo.as_ref(), normal: normal.as_ref() };
        let expected = reference::denoise_by(&weights, images, scale, on_all_cores);
        let Some(alpha) = frame.alpha else { return Ok((expected, crop)) };
        let alpha = values(&cut(&gray(alpha, frame.color.size())?, &crop));
        let settled = with_alpha(&Frame::new(color), &alpha, |frame| {
            let layer = |layer| reference::denoise_layer(&weights, images, layer, scale);
            Ok(Denoised {
                color: expected,
                layers: frame.kinds().map(layer).collect(),
                alpha: None,
            })
        });
        Ok((settled?.color, crop))
    }

    fn tolerance(&self) -> Tolerance {
        match (self.kernels(), self.precision()) {
            (KernelSet::Half, _) => HALF,
            (KernelSet::Matrix(MatrixShape { factor: Factor::F16, .. }), _) => FACTORS,
            (_, Precision::F16) => F16,
            _ => F32,
        }
    }
}

/// How much a result may differ: far more than correct drivers do (`docs/reliability.md`), and far
/// less than an error of 5 % in a middle gray, which is 3e-3.
struct Tolerance {
    largest: f64,
    rms: f64,
}

/// Vulkan allows a logarithm an error of 2⁻²¹ and a power one of 2⁻¹⁹ of the result: about 1e-6 at
/// each end of the network, and as much again from the exposure. RMS allows ten times that; a
/// single value may be further off.
const F32: Tolerance = Tolerance { largest: 1e-4, rms: 3e-5 };

/// Each of up to twenty layers rounds what it stores, up or down, by up to 2⁻¹¹ of the value, which
/// adds up to about 1e-4. RMS allows four times that; a single value may hit the worst case in
/// every layer.
const F16: Tolerance = Tolerance { largest: 2e-3, rms: 4e-4 };

/// Matrices of 16-bit factors round the weights as well as the tensors: independent errors of the
/// same size, so √2 times as much.
const FACTORS: Tolerance = Tolerance { largest: 2.8e-3, rms: 5.7e-4 };

/// Sums in 16 bits round after each of the 36 products of a chunk, by up to 2⁻¹¹ of the partial
/// sum, which after `k` products is `√(k/36)` of the chunk's sum. Independent roundings add up to
/// `√(36/2)` times 2⁻¹¹ of that sum; with the store's rounding, to √19 times the store's alone.
const HALF: Tolerance = Tolerance { largest: 8.7e-3, rms: 1.7e-3 };

impl Tolerance {
    /// Tests for "not close" rather than "too far": every comparison with NaN is false.
    fn judge(&self, found: &Verified) -> Result<()> {
        if found.largest <= self.largest && found.rms <= self.rms {
            return Ok(());
        }
        let [x, y] = found.rect.begin;
        Err(Error::WrongResult(format!(
            "the result differs from the CPU reference by up to {:.1e} of the encoded range around \
             pixel ({x}, {y}), {:.1e} on average, but rounding explains at most {:.1e} and {:.1e}: \
             the device or its driver computes wrong results; try 32-bit tensors, plain kernels or \
             another adapter",
            found.largest, found.rms, self.largest, self.rms
        )))
    }
}

/// The reference of one layer, with its independent output channels spread over all cores.
fn on_all_cores(op: Op, params: &Params, inputs: &[&Tensor]) -> Tensor {
    let Op::Conv3x3 { .. } = op else { return reference::apply(op, params, inputs) };
    let outputs = params.bias.len();
    let share = outputs.div_ceil(thread::available_parallelism().map_or(1, NonZero::get));
    let filters = params.weight.chunks(params.weight.len() / outputs * share);
    let parts: Vec<Tensor> = thread::scope(|scope| {
        let part = |(weight, bias): (&[f32], &[f32])| {
            let params = Params { weight: weight.to_vec(), bias: bias.to_vec() };
            scope.spawn(move || reference::apply(op, &params, inputs))
        };
        let parts: Vec<_> = filters.zip(params.bias.chunks(share)).map(part).collect();
        parts.into_iter().map(|part| part.join().expect("the reference does not panic")).collect()
    });
    let (height, width) = (parts[0].height, parts[0].width);
    Tensor::new(outputs, height, width, parts.into_iter().flat_map(|part| part.data).collect())
}

/// Converts color to the network's encoding.
#[derive(Clone, Copy)]
struct Exposure {
    encoding: Encoding,
    scale: f32,
}

impl Exposure {
    fn encode(self, value: f32) -> f64 {
        reference::encode(self.encoding, f64::from(value) * f64::from(self.scale))
    }

    /// Whether the network sees this value unrepaired.
    fn is_seen(self, value: f32) -> bool {
        value.is_finite()
            && (value >= 0.0 || self.encoding.transfer_function == TransferFunction::Signed)
    }
}

/// The noisiest block, or `None` if no block is noisy. Blocks with values that the repair replaces
/// come last: not all of their noise is the renderer's.
fn noisiest(color: &Image, exposure: Exposure, margin: u32) -> Option<Rect> {
    let (width, height) = (color.width() - 2 * margin, color.height());
    let [columns, rows] = [width, height].map(|side| side.div_ceil(BLOCK));
    let count = columns as usize * rows as usize;
    let step = (count as f64 / MOST_BLOCKS as f64).sqrt().ceil() as usize;
    let block = |x: u32, y: u32| {
        let begin = [x * BLOCK, y * BLOCK];
        let end = [(begin[0] + BLOCK).min(width), (begin[1] + BLOCK).min(height)];
        let [begin, end] = [begin, end].map(|[x, y]| [x + margin, y]);
        Rect { begin, end }
    };
    let noise = |rect: Rect| (noise(&cut(color, &rect), exposure), rect);
    let along = |side: u32| (0..side).step_by(step);
    let blocks = along(rows).flat_map(|y| along(columns).map(move |x| block(x, y)));
    // A block without noise is constant or a ramp, and the network may have skipped it (see
    // [`crate::ops::activity`]).
    let noisy = blocks.map(noise).filter(|(noise, _)| noise.bend > 0.0);
    noisy.max_by(|(a, _), (b, _)| a.order(b)).map(|(_, rect)| rect)
}

/// How noisy a block is.
struct Noise {
    /// Whether the network sees all of its values unrepaired.
    is_sound: bool,
    /// The mean absolute second difference of its encoded rows and columns, where the network sees
    /// all three values unrepaired.
    bend: f64,
}

impl Noise {
    /// Orders unsound blocks before sound ones, then less noisy before noisier ones.
    fn order(&self, other: &Self) -> Ordering {
        self.is_sound.cmp(&other.is_sound).then(self.bend.total_cmp(&other.bend))
    }
}

fn noise(block: &Image, exposure: Exposure) -> Noise {
    let rows: Vec<&[[f32; 3]]> = (0..block.height()).map(|y| block.row(y)).collect();
    let column = |x: u32| rows.iter().map(|row| row[x as usize]).collect::<Vec<_>>();
    let columns: Vec<_> = (0..block.width()).map(column).collect();
    let lines = rows.iter().copied().chain(columns.iter().map(Vec::as_slice));
    let bend = |w: &[[f32; 3]], c: usize| {
        let values = [0, 1, 2].map(|i| w[i][c]);
        let [before, here, after] = values.map(|v| exposure.encode(v));
        values.iter().all(|&v| exposure.is_seen(v)).then(|| (before - 2.0 * here + after).abs())
    };
    let windows = lines.flat_map(|line| line.windows(3));
    let bends: Vec<_> = windows.flat_map(|w| [0, 1, 2].map(|c| bend(w, c))).flatten().collect();
    Noise {
        is_sound: block.pixels().iter().flatten().all(|&v| exposure.is_seen(v)),
        bend: bends.iter().sum::<f64>() / bends.len().max(1) as f64,
    }
}

/// The pixels that `rect` depends on, aligned outward and clipped to the image.
fn around(rect: &Rect, halo: u32, alignment: u32, (width, height): (u32, u32)) -> Rect {
    let begin = rect.begin.map(|at| at.saturating_sub(halo) / alignment * alignment);
    let end = |at: u32, side: u32| (at + halo).next_multiple_of(alignment).min(side);
    Rect { begin, end: [end(rect.end[0], width), end(rect.end[1], height)] }
}

fn cut(image: &Image, rect: &Rect) -> Image {
    let columns = rect.begin[0] as usize..rect.end[0] as usize;
    let rows = rect.begin[1]..rect.end[1];
    let pixels = rows.flat_map(|y| &image.row(y)[columns.clone()]).copied().collect();
    let [width, height] = rect.size();
    Image::new(width, height, pixels).expect("the part has pixels")
}

/// Compares the encoded colors in `rect`. The first pixel of `expected` is at `corner`.
fn compare(
    result: &Image,
    exposure: Exposure,
    rect: &Rect,
    expected: &Image,
    corner: [u32; 2],
) -> Verified {
    let columns = || rect.begin[0]..rect.end[0];
    let pixels = (rect.begin[1]..rect.end[1]).flat_map(|y| columns().map(move |x| (x, y)));
    let differences = pixels.flat_map(|(x, y)| {
        let found = result.row(y)[x as usize];
        let expected = expected.row(y - corner[1])[(x - corner[0]) as usize];
        [0, 1, 2].map(|c| {
            let expected = exposure.encode(expected[c]);
            // The step between 16-bit floats grows with the value.
            (exposure.encode(found[c]) - expected).abs() / expected.max(1.0)
        })
    });
    let differences: Vec<_> = differences.collect();
    // A manual fold, because `f64::max` would drop a NaN.
    let largest = differences.iter().fold(0.0, |most, &d| if d <= most { most } else { d });
    let square = differences.iter().map(|d| d * d).sum::<f64>() / differences.len() as f64;
    Verified { rect: *rect, largest, rms: square.sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cores_that_share_a_layer_make_what_one_core_makes() {
        let input = Tensor::from_fn(2, 3, 4, |c, y, x| (c * 7 + y * 5 + x * 3) as f32 % 4.0 - 1.5);
        for outputs in [1, 2, 3, 7] {
            let weight = (0..outputs * 2 * 9).map(|i| (i * 37 % 11) as f32 - 5.0).collect();
            let params = Params { weight, bias: (0..outputs).map(|o| o as f32).collect() };
            let op = Op::Conv3x3 { relu: true };
            let [shared, alone] =
                [on_all_cores, reference::apply].map(|f| f(op, &params, &[&input]));
            assert_eq!(shared, alone, "{outputs} channels");
        }
    }
}
