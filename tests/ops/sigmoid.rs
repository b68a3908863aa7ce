use proptest::prelude::*;
use wgdenoise::Precision;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::sigmoid::sigmoid;
use wgdenoise::internals::reference;

use wgdenoise_testing::gpu::{context, stored};
use wgdenoise_testing::run::run;
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// WGSL allows `exp` an error of 3 + 2·|x| units in the last place. For |x| below 30, that is 4e-6
/// of a result of at most 1; small results have the same relative error.
const F32: Tolerance = Tolerance { absolute: 1e-12, relative: 8e-6 };
/// A store rounds by 2⁻¹¹ of the value, or by 3e-8 below 6e-5, the smallest normal number.
const F16: Tolerance = Tolerance { absolute: 6e-8, relative: 1.0 / 1024.0 };

#[test]
fn sigmoid_equals_the_reference_from_saturation_to_saturation() {
    let precisions = [(Precision::F32, F32), (Precision::F16, F16)];
    let cases = [0.5_f32, 5.0, 25.0].iter().flat_map(|&range| precisions.map(|p| (range, p)));
    run_cases(cases, |&(range, (precision, tolerance))| {
        check([5, 11, 13], range, precision, tolerance)
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn sigmoid_equals_the_reference_at_any_shape(
        shape in [1_usize..10, 1_usize..40, 1_usize..40], range in 0.1_f32..25.0,
    ) {
        check(shape, range, Precision::F32, F32).map_err(TestCaseError::fail)?;
    }
}

fn check(
    shape: [usize; 3],
    range: f32,
    precision: Precision,
    tolerance: Tolerance,
) -> Result<(), String> {
    let [channels, height, width] = shape;
    let mut input = Random::new(5).tensor(channels, height, width);
    input.data.iter_mut().for_each(|v| *v *= range);
    let input = stored(&input, precision);
    let (context, map) = (context(precision), channel_map(channels));
    let found = run(context, &sigmoid(context), &input, &map, shape);
    compare(&found, &reference::sigmoid(&input), tolerance)
}

#[test]
fn sigmoid_of_huge_values_is_zero_or_one() {
    let input = reference::Tensor::new(1, 1, 4, vec![-1e30, -200.0, 200.0, 1e30]);
    let context = context(Precision::F32);
    let found = run(context, &sigmoid(context), &input, &channel_map(1), [1, 1, 4]);
    let close = |(&v, expected): (&f32, f32)| (v - expected).abs() < 1e-12;
    assert!(found.data.iter().zip([0.0, 0.0, 1.0, 1.0]).all(close), "{:?}", found.data);
}
