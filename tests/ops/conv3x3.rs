use proptest::prelude::*;
use proptest::sample;
use wgdenoise::internals::model::Params;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::need::Need;
use wgdenoise::internals::ops::operator::Operator as _;
use wgdenoise::internals::ops::{concat, conv3x3::conv3x3};
use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::{KernelSet, Precision};

use wgdenoise_testing::gpu::{
    context, convolution_tolerance, factors, fused_sets, has_halves, kernel_sets, stored,
    sum_tolerance, variants, variants_of,
};
use wgdenoise_testing::run::{activity_map, run, run_pooling, run_where};
use wgdenoise_testing::{Random, compare, run_cases};

/// Channels in and out, rows, columns, ReLU.
type Case = (usize, usize, usize, usize, bool);

/// Channels at, below and above multiples of 4, 8 and 16. Sizes around the workgroup's 8, the
/// tile's 16, and the 32 of a row of eight lanes with four pixels each.
const CASES: [Case; 13] = [
    (1, 1, 1, 1, false),
    (1, 1, 3, 2, true),
    (3, 4, 5, 7, true),
    (4, 3, 8, 8, false),
    (9, 16, 16, 16, true),
    (5, 6, 17, 15, true),
    (8, 8, 7, 33, true),
    (16, 17, 9, 31, false),
    (7, 24, 2, 65, true),
    (33, 20, 18, 4, true),
    (64, 32, 3, 34, true),
    (12, 40, 1, 1, false),
    // With one input channel, all nine weights of an output are large.
    (1, 19, 31, 34, false),
];

#[test]
fn conv3x3_equals_the_reference_in_every_variant() {
    let cases =
        CASES.iter().flat_map(|case| variants().into_iter().map(|variant| (*case, variant)));
    run_cases(cases, |&(case, variant)| check(case, variant));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn conv3x3_equals_the_reference_at_any_shape(
        case in (1_usize..40, 1_usize..40, 1_usize..36, 1_usize..70, any::<bool>()),
        variant in sample::select(variants()),
    ) {
        check(case, variant).map_err(TestCaseError::fail)?;
    }
}

fn check(case: Case, (kernels, precision): (KernelSet, Precision)) -> Result<(), String> {
    let (inputs, outputs, height, width, relu) = case;
    let mut random = Random::new(inputs as u64 * 1000 + outputs as u64);
    let weight = random.values(outputs * inputs * 9);
    let params = Params { weight, bias: random.values(outputs) };
    let input = stored(&random.tensor(inputs, height, width), precision);
    let context = context(precision);
    let map = channel_map(inputs);
    let operator = conv3x3(context, kernels, &params, &map, relu, false);
    let found = run(context, &operator, &input, &map, [outputs, height, width]);
    let expected = multiplied(kernels, &input, &params, relu);
    compare(&found, &expected, convolution_tolerance(inputs * 9, (kernels, precision)))
}

/// The reference, using the values that the kernels multiply. Products of 16-bit factors are exact
/// in 32 bits, so the tolerance of a 32-bit sum fits all sets that have one.
fn multiplied(kernels: KernelSet, input: &Tensor, params: &Params, relu: bool) -> Tensor {
    let input = Tensor { data: factors(kernels, &input.data), ..*input };
    reference::conv3x3(&input, &factors(kernels, &params.weight), &params.bias, relu)
}

#[test]
fn conv3x3_reads_a_concatenation_of_widths_that_are_no_multiples_of_four() {
    let map = concat::channel_map(&channel_map(5), &channel_map(6));
    run_cases(variants(), |&(kernels, precision)| {
        let mut random = Random::new(7);
        let params = Params { weight: random.values(10 * 11 * 9), bias: random.values(10) };
        let input = stored(&random.tensor(11, 9, 13), precision);
        let context = context(precision);
        let operator = conv3x3(context, kernels, &params, &map, true, false);
        let found = run(context, &operator, &input, &map, [10, 9, 13]);
        let expected = multiplied(kernels, &input, &params, true);
        compare(&found, &expected, convolution_tolerance(11 * 9, (kernels, precision)))
    });
}

#[test]
fn sums_beyond_half_precision_saturate_instead_of_becoming_infinite() {
    for kernels in kernel_sets(Precision::F16) {
        let context = context(Precision::F16);
        let params = Params { weight: vec![1.0; 2 * 9], bias: vec![0.0] };
        let input = Tensor::from_fn(2, 3, 3, |_, _, _| 6e4);
        let map = channel_map(2);
        let operator = conv3x3(context, kernels, &params, &map, true, false);
        let found = run(context, &operator, &input, &map, [1, 3, 3]);
        assert!(found.data.iter().all(|&v| v == 65504.0), "{kernels:?}: {:?}", found.data);
    }
}

#[test]
fn a_kernel_with_wrong_weights_fails_the_comparison() {
    let context = context(Precision::F32);
    let map = channel_map(4);
    let mut random = Random::new(3);
    let mut params = Params { weight: random.values(4 * 4 * 9), bias: random.values(4) };
    let input = random.tensor(4, 6, 6);
    let expected = reference::conv3x3(&input, &params.weight, &params.bias, true);
    params.weight[40] += 0.01;
    let operator = conv3x3(context, KernelSet::Auto, &params, &map, true, false);
    let found = run(context, &operator, &input, &map, [4, 6, 6]);
    compare(&found, &expected, sum_tolerance(36, Precision::F32)).unwrap_err();
}

/// Blocks of 16×16 pixels at distances 1 and 2, in columns of two blocks.
#[test]
fn what_is_not_needed_is_left_as_it_was() {
    let near_and_far = [1, 1, 2, 2, 1, 1, 2, 2];
    run_cases(variants_of(fused_sets), |&(kernels, precision)| {
        let mut random = Random::new(13);
        let params = Params { weight: random.values(20 * 9 * 9), bias: random.values(20) };
        let input = stored(&random.tensor(9, 32, 64), precision);
        let (context, map) = (context(precision), channel_map(9));
        let operator = conv3x3(context, kernels, &params, &map, true, false);
        let activity = activity_map(context, [4, 2], &near_and_far);
        let need = Need { map: &activity, level: 0, reach: 1 };
        let found = run_where(context, &operator, &[(&input, &map)], [20, 32, 64], need);
        let mut expected = multiplied(kernels, &input, &params, true);
        for row in expected.data.chunks_exact_mut(64) {
            row[32..].fill(-77.0);
        }
        compare(&found, &expected, convolution_tolerance(81, (kernels, precision)))
    });
}

/// The kernel sets for GPUs.
fn pooling_sets(precision: Precision) -> Vec<KernelSet> {
    kernel_sets(precision).into_iter().filter(|set| set.is_for_gpus()).collect()
}

#[test]
fn with_a_max_pool_both_outputs_equal_the_references() {
    let cases = [(3, 5, 2, 2), (16, 16, 32, 48), (8, 20, 18, 34), (5, 33, 6, 20)];
    let variants = variants_of(pooling_sets);
    let cases = cases.into_iter().flat_map(|case| variants.iter().map(move |v| (case, *v)));
    run_cases(cases, |&((inputs, outputs, height, width), (kernels, precision))| {
        let mut random = Random::new(inputs as u64);
        let params =
            Params { weight: random.values(outputs * inputs * 9), bias: random.values(outputs) };
        let input = stored(&random.tensor(inputs, height, width), precision);
        let (context, map) = (context(precision), channel_map(inputs));
        let operator = conv3x3(context, kernels, &params, &map, true, true);
        assert!(operator.pools(), "the {kernels} variant should pool");
        let found = run_pooling(context, &operator, &input, [outputs, height, width]);
        let expected = multiplied(kernels, &input, &params, true);
        let tolerance = convolution_tolerance(inputs * 9, (kernels, precision));
        compare(&found[0], &expected, tolerance)?;
        compare(&found[1], &reference::max_pool(&expected), tolerance)
    });
}

/// Each output's weights are divided by their own power of two, so that the chunks' sums stay
/// within 16 bits: here 2¹⁸, 2⁴ and 2⁻¹¹. Values beyond the 16-bit range are clamped to it.
#[test]
fn chunks_in_16_bits_neither_overflow_nor_vanish() {
    if !has_halves() {
        return;
    }
    let scales = [4096.0, -0.25, 1e-5];
    let weight: Vec<f32> = scales.iter().flat_map(|&scale| [scale; 8 * 9]).collect();
    let params = Params { weight, bias: vec![0.0; 3] };
    for value in [1.0, 65504.0, 1e9] {
        let of = |value: f32| Tensor::from_fn(8, 3, 3, |c, _, _| if c < 4 { value } else { 1.0 });
        let (input, counted) = (of(value), of(value.min(65504.0)));
        let (context, map) = (context(Precision::F32), channel_map(8));
        let operator = conv3x3(context, KernelSet::Half, &params, &map, false, false);
        let found = run(context, &operator, &input, &map, [3, 3, 3]);
        let expected = multiplied(KernelSet::Half, &counted, &params, false);
        for (found, expected) in found.data.iter().zip(&expected.data) {
            let is_close = (found - expected).abs() <= 0.02 * expected.abs();
            assert!(is_close, "{found} instead of {expected} at {value}");
        }
    }
}

/// Above 2048, 16-bit floats are 2 apart: a 1 is lost in the sum of its chunk of four input
/// channels, but not in the sum of chunks.
#[test]
fn half_kernels_add_up_a_chunk_in_16_bits_and_chunks_in_32() {
    if !has_halves() {
        return;
    }
    let (context, map) = (context(Precision::F32), channel_map(8));
    let centers = (0..8 * 9).map(|i| if i % 9 == 4 { 1.0 } else { 0.0 });
    let params = Params { weight: centers.collect(), bias: vec![0.0] };
    let operator = conv3x3(context, KernelSet::Half, &params, &map, false, false);
    for (channel, expected) in [(1, 2048.0), (3, 2048.0), (4, 2049.0), (7, 2049.0)] {
        let value = |c, _, _| if c == channel { 1.0 } else { f32::from(c == 0) * 2048.0 };
        let input = Tensor::from_fn(8, 1, 1, value);
        let found = run(context, &operator, &input, &map, [1, 1, 1]);
        assert_eq!(found.data, [expected], "a 1 in channel {channel}");
    }
}

/// A plain store may round towards 0, as on lavapipe.
#[test]
fn values_are_stored_in_16_bits_as_the_nearest() {
    // Above 1, 16-bit floats are 2⁻¹⁰ apart.
    let step = 2.0_f32.powi(-10);
    let cases = [(0.3, 0.0), (0.5, 0.0), (0.7, 1.0), (1.5, 2.0), (-0.2, 0.0), (-0.4, -0.5)];
    run_cases(kernel_sets(Precision::F16), |&kernels| {
        for (steps, expected) in cases {
            let mut weight = vec![0.0; 9];
            weight[4] = 1.0;
            let params = Params { weight, bias: vec![steps * step] };
            let (context, map) = (context(Precision::F16), channel_map(1));
            let conv = conv3x3(context, kernels, &params, &map, false, false);
            let found = run(context, &conv, &Tensor::new(1, 1, 1, vec![1.0]), &map, [1, 1, 1]);
            if found.data != [1.0 + expected * step] {
                return Err(format!("1 and {steps} steps: {:?}", found.data));
            }
        }
        Ok(())
    });
}
