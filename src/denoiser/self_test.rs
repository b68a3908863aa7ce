//! Tests whether a driver runs the matrix kernels correctly. Cooperative matrices are new in
//! drivers and experimental in wgpu, so a small convolution of each kind is compared with the CPU
//! reference first.

use crate::error::{Error, Result};
use crate::gpu::kernel::Context;
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::scopes::catch;
use crate::gpu::tensor::GpuTensor;
use crate::gpu::tensor_io::{download, upload};
use crate::model::{Op, Params};
use crate::ops::build::build;
use crate::ops::channel_map::{ChannelMap, channel_map};
use crate::ops::need::{Need, everything};
use crate::ops::operator::{Io, LayerRequest, Operator};
use crate::reference::{self, Tensor};

/// A layer to test.
#[derive(Clone, Copy, Debug)]
pub struct Tested {
    /// What it computes.
    pub op: Op,
    /// Whether a max-pool follows, which the kernel may compute as well.
    pub pools: bool,
    /// Channels of each input.
    inputs: &'static [usize],
    outputs: usize,
    weights: usize,
    biases: usize,
    /// Weights are multiples of this power of two.
    step: f32,
}

/// Multiples of this in `[−1, 1]` are exact 16-bit floats.
const FINE: f32 = 1.0 / 1024.0;

/// Layers whose input channels fill several slices for either tile side, the last one partial, and
/// whose output channels fill two blocks of the 32-channel kernels or one of the 16-channel
/// kernels, each partial. Steps of ¼ keep the folded weights of `up_conv` exact.
const TESTED: [Tested; 5] = [
    Tested::conv3x3(36, 44, false),
    Tested::conv3x3(36, 12, false),
    Tested::conv3x3(12, 20, true),
    Tested {
        op: Op::UpConv { ups: UPS, relu: true },
        pools: false,
        inputs: &[12, 20],
        outputs: 44,
        weights: 20 * UPS * 4 + 44 * (12 + UPS) * 9,
        biases: UPS + 44,
        step: 0.25,
    },
    Tested {
        op: Op::ConvLogits,
        pools: false,
        inputs: &[16],
        outputs: 12,
        weights: 16 * 16 * 9 + 12 * 16,
        biases: 16 + 12,
        step: FINE,
    },
];
const UPS: usize = 6;

impl Tested {
    const fn conv3x3(inputs: usize, outputs: usize, pools: bool) -> Self {
        let weights = inputs * outputs * 9;
        let inputs: &[usize] = if inputs == 36 { &[36] } else { &[12] };
        let op = Op::Conv3x3 { relu: true };
        Self { op, pools, inputs, outputs, weights, biases: outputs, step: FINE }
    }

    /// Builds the operator of a kernel set with these weights. `maps` describe how its inputs are
    /// stored.
    #[must_use]
    pub fn build(
        &self,
        context: &Context,
        kernels: KernelSet,
        params: &Params,
        maps: &[&ChannelMap],
    ) -> Box<dyn Operator> {
        let next = self.pools.then_some(Op::MaxPool);
        build(self.op, &LayerRequest { context, kernels, params, maps, next })
    }
}

/// Columns and rows: several workgroups, the last ones partial.
const SIZE: [usize; 2] = [38, 18];

/// Absolute tolerance. All factors are 16-bit floats in `[−1, 1]`, so products are exact in 32 bits
/// and only the sum of `n = 9 · 36` products rounds: by at most `n · 2⁻²³ · Σ|product|` even if
/// every addition truncates, with `Σ|product|` about `n / 4` for evenly spread factors. Doubling
/// that covers an uneven draw. The other sums are shorter: 9 · 12 + 4 · 20 products in `up_conv`,
/// and 9 · 16 in `conv_logits`, which then sums their errors with 16 weights of ½ on average.
const ABSOLUTE: f32 = 2.0 * 324.0 * 324.0 / 4.0 / (1 << 23) as f32;
/// Relative tolerance, added on top: a 16-bit tensor rounds by `2⁻¹¹` of the value, or by `2⁻¹⁰` if
/// the store truncates.
const RELATIVE: f32 = 1.0 / 1024.0;

/// Builds the operator of each layer with the test's weights, runs it and compares the result with
/// the CPU reference. Submits to the queue and waits.
///
/// # Errors
/// Fails if the device does, or if a result is off; the message gives the first wrong value.
pub fn self_test(
    context: &Context,
    build: impl Fn(&Tested, &Params, &[&ChannelMap]) -> Box<dyn Operator>,
) -> Result<()> {
    TESTED.iter().try_for_each(|tested| {
        let (params, inputs) = problem(tested);
        let maps: Vec<_> = inputs.iter().map(|input| channel_map(input.channels)).collect();
        let found = catch(&context.device, || {
            let operator = build(tested, &params, &maps.iter().collect::<Vec<_>>());
            run(context, operator.as_ref(), &inputs, tested.outputs)
        })?;
        let inputs: Vec<_> = inputs.iter().collect();
        let expected = reference::apply(tested.op, &params, &inputs);
        let pooled = found.get(1).map(|found| (found, reference::max_pool(&expected)));
        compare(&found[0], &expected)?;
        pooled.map_or(Ok(()), |(found, expected)| compare(found, &expected))
    })
}

/// Weights and inputs of a layer. The second input has half the resolution.
fn problem(tested: &Tested) -> (Params, Vec<Tensor>) {
    let mut values = halves();
    let mut take = |count: usize| values.by_ref().take(count).collect::<Vec<_>>();
    let weight = take(tested.weights).into_iter().map(|w| (w / tested.step).round() * tested.step);
    let params = Params { weight: weight.collect(), bias: take(tested.biases) };
    let input = |(level, &channels): (usize, &usize)| {
        let [width, height] = SIZE.map(|side| side >> level);
        Tensor::new(channels, height, width, take(channels * width * height))
    };
    (params, tested.inputs.iter().enumerate().map(input).collect())
}

/// Evenly spread 16-bit floats in `[−1, 1]`, the same sequence every time.
fn halves() -> impl Iterator<Item = f32> {
    // Knuth's MMIX generator; its upper bits are the random ones.
    let step =
        |s: &u64| Some(s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407));
    std::iter::successors(Some(1), step)
        .map(|state| half::f16::from_f32((state >> 40) as f32 / (1 << 23) as f32 - 1.0).to_f32())
}

/// The output, and its max-pool if the operator computes that too.
fn run(
    context: &Context,
    operator: &dyn Operator,
    inputs: &[Tensor],
    outputs: usize,
) -> Result<Vec<Tensor>> {
    let sources: Vec<_> = inputs.iter().map(|input| upload(context, input)).collect();
    let quads = outputs as u32 / 4;
    let textures = [0, 1]
        .map(|level| GpuTensor::texture(context, SIZE.map(|side| (side >> level) as u32), quads));
    let [output, pooled] = [0, 1].map(|i| GpuTensor::of(&textures[i], 0, quads));
    let map = everything(&context.device);
    let need = Some(Need { map: &map, level: 0, reach: 0 });
    let inputs: Vec<_> = sources.iter().collect();
    let io = Io { inputs: &inputs, output: &output, pooled: Some(&pooled), need };
    let call = operator.dispatch(&context.device, &io).expect("a convolution has a kernel");
    let used = if operator.pools() { &textures[..] } else { &textures[..1] };
    used.iter()
        .map(|texture| {
            let mut encoder = context.device.create_command_encoder(&Default::default());
            call.record(&mut encoder.begin_compute_pass(&Default::default()));
            download(context, encoder, texture)
        })
        .collect()
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
