//! Tests whether a driver runs the matrix kernels correctly. Cooperative matrices are new in
//! drivers and experimental in wgpu, so one small convolution is compared with the CPU reference
//! first.

use crate::error::{Error, Result};
use crate::gpu::kernel::Context;
use crate::gpu::scopes::catch;
use crate::gpu::tensor::GpuTensor;
use crate::gpu::tensor_io::{download, upload};
use crate::model::Params;
use crate::ops::channel_map::{ChannelMap, channel_map};
use crate::ops::convolution::Convolution;
use crate::ops::need::{Need, everything};
use crate::ops::operator::{Io, Operator as _};
use crate::reference::{self, Tensor};

/// Input channels: several slices for either tile side, the last one partial.
const INPUTS: usize = 36;
/// Output channels: two blocks for the 32-channel kernel, one for the 16-channel kernel, each
/// partial.
const OUTPUTS: [usize; 2] = [44, 12];
/// Columns and rows: several workgroups, the last ones partial.
const SIZE: [usize; 2] = [37, 18];

/// Absolute tolerance. All factors are 16-bit floats in `[−1, 1]`, so products are exact in 32 bits
/// and only the sum of `n = 9 · 36` products rounds: by at most `n · 2⁻²³ · Σ|product|` even if
/// every addition truncates, with `Σ|product|` about `n / 4` for evenly spread factors. Doubling
/// that covers an uneven draw.
const ABSOLUTE: f32 = 2.0 * 324.0 * 324.0 / 4.0 / (1 << 23) as f32;
/// Relative tolerance, added on top: a 16-bit tensor rounds by `2⁻¹¹` of the value, or by `2⁻¹⁰` if
/// the store truncates.
const RELATIVE: f32 = 1.0 / 1024.0;

/// Builds convolutions with the test's weights, runs them and compares the results with the CPU
/// reference. Submits to the queue and waits.
///
/// # Errors
/// Fails if the device does, or if a result is off; the message gives the first wrong value.
pub fn self_test(
    context: &Context,
    build: impl Fn(&Params, &ChannelMap) -> Convolution,
) -> Result<()> {
    OUTPUTS.into_iter().try_for_each(|outputs| test(context, &build, INPUTS, outputs))
}

fn test(
    context: &Context,
    build: &impl Fn(&Params, &ChannelMap) -> Convolution,
    inputs: usize,
    outputs: usize,
) -> Result<()> {
    let mut values = halves();
    let mut take = |count: usize| values.by_ref().take(count).collect::<Vec<_>>();
    let params = Params { weight: take(inputs * outputs * 9), bias: take(outputs) };
    let input = Tensor::new(inputs, SIZE[1], SIZE[0], take(inputs * SIZE[0] * SIZE[1]));
    let found = catch(&context.device, || {
        let operator = build(&params, &channel_map(inputs));
        run(context, &operator, &input, outputs)
    })?;
    let expected = reference::conv3x3(&input, &params.weight, &params.bias, true);
    compare(&found, &expected)
}

/// Evenly spread 16-bit floats in `[−1, 1]`, the same sequence every time.
fn halves() -> impl Iterator<Item = f32> {
    // Knuth's MMIX generator; its upper bits are the random ones.
    let step =
        |s: &u64| Some(s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407));
    std::iter::successors(Some(1), step)
        .map(|state| half::f16::from_f32((state >> 40) as f32 / (1 << 23) as f32 - 1.0).to_f32())
}

fn run(
    context: &Context,
    operator: &Convolution,
    input: &Tensor,
    outputs: usize,
) -> Result<Tensor> {
    let source = upload(context, input);
    let [width, height] = SIZE.map(|side| side as u32);
    let quads = outputs as u32 / 4;
    let texture = GpuTensor::texture(context, [width, height], quads);
    let target = GpuTensor::of(&texture, 0, quads);
    let map = everything(&context.device);
    let need = Some(Need { map: &map, level: 0, reach: 0 });
    let io = Io { inputs: &[&source], output: &target, pooled: None, need };
    let call = operator.dispatch(&context.device, &io);
    let mut encoder = context.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    call.expect("a convolution has a kernel").record(&mut pass);
    drop(pass);
    download(context, encoder, &texture)
}

/// Tests for "not close" rather than "too far": every comparison with NaN is false.
fn compare(found: &Tensor, expected: &Tensor) -> Result<()> {
    let pairs = found.data.iter().zip(&expected.data);
    let close = |&(f, e): &(&f32, &f32)| (f - e).abs() <= ABSOLUTE + RELATIVE * e.abs();
    let (count, wrong) = (found.data.len(), pairs.filter(|pair| !close(pair)));
    let wrong: Vec<_> = wrong.collect();
    match wrong.first() {
        None => Ok(()),
        Some((found, expected)) => Err(Error::WrongResult(format!(
            "{} of {count} results of a test are wrong, the first one {found} instead of {expected}",
            wrong.len()
        ))),
    }
}
