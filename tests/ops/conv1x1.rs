use proptest::prelude::*;
use proptest::sample;
use wgdenoise::internals::model::Params;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::conv1x1::conv1x1;
use wgdenoise::internals::reference;
use wgdenoise::{KernelSet, Precision};

use wgdenoise_testing::gpu::{context, stored, sum_tolerance, variants};
use wgdenoise_testing::run::run;
use wgdenoise_testing::{Random, compare, run_cases};

/// Channels in and out, rows and columns.
type Case = (usize, usize, usize, usize);

const CASES: [Case; 7] = [
    (1, 1, 1, 1),
    (4, 3, 5, 7),
    (6, 5, 8, 8),
    (8, 3, 3, 33),
    (16, 3, 2, 32),
    (17, 20, 9, 31),
    (32, 3, 1, 1),
];

#[test]
fn conv1x1_equals_the_reference_in_every_variant() {
    let cases = CASES.iter().flat_map(|case| variants().into_iter().map(|v| (*case, v)));
    run_cases(cases, |&(case, variant)| check(case, variant));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn conv1x1_equals_the_reference_at_any_shape(
        case in (1_usize..40, 1_usize..40, 1_usize..20, 1_usize..40),
        variant in sample::select(variants()),
    ) {
        check(case, variant).map_err(TestCaseError::fail)?;
    }
}

fn check(case: Case, (kernels, precision): (KernelSet, Precision)) -> Result<(), String> {
    let (inputs, outputs, height, width) = case;
    let mut random = Random::new(inputs as u64 * 1000 + outputs as u64);
    let weight = random.values(outputs * inputs);
    let params = Params { weight, bias: random.values(outputs) };
    let input = stored(&random.tensor(inputs, height, width), precision);
    let (context, map) = (context(precision), channel_map(inputs));
    let operator = conv1x1(context, kernels, &params, &map);
    let found = run(context, &operator, &input, &map, [outputs, height, width]);
    let expected = reference::conv1x1(&input, &params.weight, &params.bias);
    compare(&found, &expected, sum_tolerance(inputs, precision))
}
