use proptest::prelude::*;
use proptest::sample;
use wgdenoise::internals::model::Params;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::up_conv::up_conv;
use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::{KernelSet, Precision};

use wgdenoise::internals::ops::need::{Need, everything};
use wgdenoise_testing::gpu::{
    context, convolution_tolerance, factors, fused_sets, stored, sum_tolerance, variants_of,
};
use wgdenoise_testing::run::run_where;
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// Channels of the skip, the low-resolution tensor, the upsampled tensor and the output;
/// low-resolution rows and columns; ReLU.
type Case = (usize, usize, usize, usize, usize, usize, bool);

/// Channels at, below and above multiples of 4, 8 and 16. Low-resolution sizes around the tile's 8,
/// and the 32 of a row of eight lanes with eight pixels each.
const CASES: [Case; 9] = [
    (1, 1, 1, 1, 1, 1, false),
    (2, 3, 1, 4, 1, 2, true),
    (4, 8, 4, 4, 3, 5, false),
    (5, 6, 7, 9, 8, 8, true),
    (16, 32, 16, 16, 2, 33, true),
    (8, 12, 5, 17, 9, 3, false),
    (12, 20, 12, 24, 4, 31, true),
    (3, 40, 9, 33, 5, 7, true),
    (20, 7, 2, 3, 7, 1, false),
];

#[test]
fn up_conv_equals_the_three_plain_operators_in_every_variant() {
    let variants = variants_of(fused_sets);
    let cases = CASES.iter().flat_map(|case| variants.iter().map(|variant| (*case, *variant)));
    run_cases(cases, |&(case, variant)| check(case, variant));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn up_conv_equals_the_three_plain_operators_at_any_shape(
        channels in (1_usize..30, 1_usize..30, 1_usize..20, 1_usize..40),
        (height, width, relu) in (1_usize..18, 1_usize..36, any::<bool>()),
        variant in sample::select(variants_of(fused_sets)),
    ) {
        let (skips, lows, ups, outputs) = channels;
        let case = (skips, lows, ups, outputs, height, width, relu);
        check(case, variant).map_err(TestCaseError::fail)?;
    }
}

struct Problem {
    skip: Tensor,
    low: Tensor,
    params: Params,
}

/// Values that the kernels multiply without rounding. For 16-bit factors, weights are multiples of
/// ¼: each folded weight is a sum of at most 4 · 20 products of two of them, a multiple of 1/16
/// below 80, which is exact in 16-bit floats.
fn problem(case: Case, (kernels, precision): (KernelSet, Precision)) -> Problem {
    let (skips, lows, ups, outputs, height, width, _) = case;
    let mut random = Random::new((skips * 1000 + lows * 100 + outputs) as u64);
    let mut weight = random.values(lows * ups * 4 + outputs * (skips + ups) * 9);
    if factors(kernels, &weight) != weight {
        weight = weight.iter().map(|w| (w * 4.0).round() / 4.0).collect();
    }
    let params = Params { weight, bias: random.values(ups + outputs) };
    let mut tensor = |channels, height, width| {
        let tensor = stored(&random.tensor(channels, height, width), precision);
        Tensor { data: factors(kernels, &tensor.data), ..tensor }
    };
    let (skip, low) = (tensor(skips, 2 * height, 2 * width), tensor(lows, height, width));
    Problem { skip, low, params }
}

/// The plain operators round the upsampled tensor, sums over `lows` channels, and the kernel rounds
/// the folded weights, sums over `ups` channels: together as many terms as both convolutions have.
/// In a chunk of `Half`, a product with a folded weight stands for `ups` products.
fn tolerance(case: Case, (kernels, precision): (KernelSet, Precision)) -> Tolerance {
    let (skips, lows, ups, ..) = case;
    let terms = 9 * (skips + ups * (1 + lows));
    let sum = sum_tolerance(terms, precision);
    let [chunks, in_32_bits] = [kernels, KernelSet::Tiled]
        .map(|kernels| convolution_tolerance(ups * terms, (kernels, precision)).absolute);
    Tolerance { absolute: sum.absolute + chunks - in_32_bits, ..sum }
}

fn check(case: Case, variant: (KernelSet, Precision)) -> Result<(), String> {
    let problem = problem(case, variant);
    let Problem { skip, low, params } = &problem;
    let (_, _, ups, .., relu) = case;
    let expected = reference::up_conv(skip, low, params, ups, relu);
    compare(&run(case, variant, &problem), &expected, tolerance(case, variant))
}

fn run(case: Case, (kernels, precision): (KernelSet, Precision), problem: &Problem) -> Tensor {
    let (_, _, ups, outputs, height, width, relu) = case;
    let Problem { skip, low, params } = problem;
    let context = context(precision);
    let maps = [channel_map(skip.channels), channel_map(low.channels)];
    let operator = up_conv(context, kernels, params, [&maps[0], &maps[1]], ups, relu);
    let map_of_zero = everything(&context.device);
    let need = Need { map: &map_of_zero, level: 0, reach: u32::MAX };
    let inputs = [(skip, &maps[0]), (low, &maps[1])];
    run_where(context, &operator, &inputs, [outputs, 2 * height, 2 * width], need)
}

#[test]
fn a_kernel_with_a_wrong_weight_fails_the_comparison() {
    let case = (4, 4, 4, 4, 3, 3, false);
    for variant in variants_of(fused_sets) {
        let mut problem = problem(case, variant);
        let Problem { skip, low, params } = &problem;
        let expected = reference::up_conv(skip, low, params, 4, false);
        problem.params.weight[7] += 0.25;
        let found = run(case, variant, &problem);
        compare(&found, &expected, tolerance(case, variant)).unwrap_err();
    }
}
