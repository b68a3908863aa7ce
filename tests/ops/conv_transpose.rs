use wgdenoise::model::Params;
use wgdenoise::ops::{channel_map, conv_transpose::conv_transpose};
use wgdenoise::reference;

use crate::common::gpu::{context, run, stored, sum_tolerance, variants};
use crate::common::{Random, compare, run_cases};

/// Channels in and out, rows and columns of the input.
const CASES: [(usize, usize, usize, usize); 9] = [
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
fn conv_transpose_equals_the_reference_in_every_variant() {
    let cases =
        CASES.iter().flat_map(|case| variants().into_iter().map(|variant| (*case, variant)));
    run_cases(cases, |&((inputs, outputs, height, width), (kernels, precision))| {
        let mut random = Random::new(inputs as u64 * 1000 + outputs as u64);
        let weight = random.values(inputs * outputs * 4);
        let params = Params { weight, bias: random.values(outputs) };
        let input = stored(&random.tensor(inputs, height, width), precision);
        let (context, map) = (context(precision), channel_map(inputs));
        let operator = conv_transpose(context, kernels, &params, &map);
        let found = run(context, &operator, &input, &map, [outputs, 2 * height, 2 * width]);
        let expected = reference::conv_transpose(&input, &params.weight, &params.bias);
        compare(&found, &expected, sum_tolerance(inputs, precision))
    });
}
