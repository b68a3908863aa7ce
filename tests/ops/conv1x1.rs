use wgdenoise::model::Params;
use wgdenoise::ops::{channel_map, conv1x1::conv1x1};
use wgdenoise::reference;

use crate::common::gpu::{context, run, stored, sum_tolerance, variants};
use crate::common::{Random, compare, run_cases};

/// Channels in and out, rows and columns.
const CASES: [(usize, usize, usize, usize); 7] = [
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
    let cases =
        CASES.iter().flat_map(|case| variants().into_iter().map(|variant| (*case, variant)));
    run_cases(cases, |&((inputs, outputs, height, width), (kernels, precision))| {
        let mut random = Random::new(inputs as u64 * 1000 + outputs as u64);
        let weight = random.values(outputs * inputs);
        let params = Params { weight, bias: random.values(outputs) };
        let input = stored(&random.tensor(inputs, height, width), precision);
        let (context, map) = (context(precision), channel_map(inputs));
        let operator = conv1x1(context, kernels, &params, &map);
        let found = run(context, &operator, &input, &map, [outputs, height, width]);
        let expected = reference::conv1x1(&input, &params.weight, &params.bias);
        compare(&found, &expected, sum_tolerance(inputs, precision))
    });
}
