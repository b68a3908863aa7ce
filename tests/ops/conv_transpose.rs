use proptest::prelude::*;
use proptest::sample;
use wgdenoise::Precision;
use wgdenoise::internals::model::Params;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::conv_transpose::conv_transpose;
use wgdenoise::internals::reference;

use wgdenoise_testing::gpu::{PRECISIONS, context, stored, sum_tolerance};
use wgdenoise_testing::run::run;
use wgdenoise_testing::{Random, compare, run_cases};

/// Channels in and out, rows and columns of the input.
type Case = (usize, usize, usize, usize);

const CASES: [Case; 9] = [
    (1, 1, 1, 1),
    (2, 3, 1, 2),
    (4, 4, 3, 5),
    (5, 6, 8, 8),
    (8, 12, 4, 9),
    (16, 8, 2, 31),
    (20, 17, 3, 33),
    (32, 16, 1, 32),
    (7, 40, 9, 3),
];

#[test]
fn conv_transpose_equals_the_reference_in_both_precisions() {
    let cases = CASES.iter().flat_map(|case| PRECISIONS.map(|precision| (*case, precision)));
    run_cases(cases, |&(case, precision)| check(case, precision));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn conv_transpose_equals_the_reference_at_any_shape(
        case in (1_usize..40, 1_usize..40, 1_usize..20, 1_usize..40),
        precision in sample::select(&PRECISIONS[..]),
    ) {
        check(case, precision).map_err(TestCaseError::fail)?;
    }
}

fn check(case: Case, precision: Precision) -> Result<(), String> {
    let (inputs, outputs, height, width) = case;
    let mut random = Random::new(inputs as u64 * 1000 + outputs as u64);
    let weight = random.values(inputs * outputs * 4);
    let params = Params { weight, bias: random.values(outputs) };
    let input = stored(&random.tensor(inputs, height, width), precision);
    let (context, map) = (context(precision), channel_map(inputs));
    let operator = conv_transpose(context, &params, &map);
    let found = run(context, &operator, &input, &map, [outputs, 2 * height, 2 * width]);
    let expected = reference::conv_transpose(&input, &params.weight, &params.bias);
    compare(&found, &expected, sum_tolerance(inputs, precision))
}
