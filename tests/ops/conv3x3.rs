use proptest::prelude::*;
use proptest::sample;
use wgdenoise::model::Params;
use wgdenoise::ops::{channel_map, concat, conv3x3::conv3x3};
use wgdenoise::{KernelSet, Precision, reference};

use crate::common::gpu::{context, kernel_sets, run, stored, sum_tolerance, variants};
use crate::common::{Random, compare, run_cases};

/// Channels in and out, rows, columns, ReLU.
type Case = (usize, usize, usize, usize, bool);

/// Channels at, below and above multiples of 4, 8 and 16; sizes below, at and above the 8 of
/// a workgroup, the 16 of a tile and the 32 of a row of eight lanes with four pixels each.
const CASES: [Case; 12] = [
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
    let operator = conv3x3(context, kernels, &params, &map, relu);
    let found = run(context, &operator, &input, &map, [outputs, height, width]);
    let expected = reference::conv3x3(&input, &params.weight, &params.bias, relu);
    compare(&found, &expected, sum_tolerance(inputs * 9, precision))
}

#[test]
fn conv3x3_reads_a_concatenation_of_widths_that_are_no_multiples_of_four() {
    let map = concat::channel_map(&channel_map(5), &channel_map(6));
    run_cases(variants(), |&(kernels, precision)| {
        let mut random = Random::new(7);
        let params = Params { weight: random.values(10 * 11 * 9), bias: random.values(10) };
        let input = stored(&random.tensor(11, 9, 13), precision);
        let context = context(precision);
        let operator = conv3x3(context, kernels, &params, &map, true);
        let found = run(context, &operator, &input, &map, [10, 9, 13]);
        let expected = reference::conv3x3(&input, &params.weight, &params.bias, true);
        compare(&found, &expected, sum_tolerance(11 * 9, precision))
    });
}

#[test]
fn sums_beyond_half_precision_saturate_instead_of_becoming_infinite() {
    for kernels in kernel_sets() {
        let context = context(Precision::F16);
        let params = Params { weight: vec![1.0; 2 * 9], bias: vec![0.0] };
        let input = reference::Tensor::from_fn(2, 3, 3, |_, _, _| 6e4);
        let map = channel_map(2);
        let operator = conv3x3(context, kernels, &params, &map, true);
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
    let operator = conv3x3(context, KernelSet::Auto, &params, &map, true);
    let found = run(context, &operator, &input, &map, [4, 6, 6]);
    compare(&found, &expected, sum_tolerance(36, Precision::F32)).unwrap_err();
}
