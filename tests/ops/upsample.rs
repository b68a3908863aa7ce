use proptest::prelude::*;
use wgdenoise::Precision;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::upsample::upsample;
use wgdenoise::internals::reference;

use wgdenoise_testing::gpu::{context, stored};
use wgdenoise_testing::run::run;
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// Values are copied, so nothing is rounded.
const EXACT: Tolerance = Tolerance { absolute: 0.0, relative: 0.0 };

/// Channels, rows and columns of the input.
const CASES: [(usize, usize, usize); 6] =
    [(1, 1, 1), (3, 4, 6), (4, 16, 16), (6, 9, 7), (9, 1, 17), (33, 16, 5)];

#[test]
fn upsample_equals_the_reference_exactly() {
    let precisions = [Precision::F32, Precision::F16];
    let cases = CASES.iter().flat_map(|case| precisions.map(|precision| (*case, precision)));
    run_cases(cases, |&((channels, height, width), precision)| {
        check([channels, height, width], precision)
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn upsample_equals_the_reference_at_any_shape(
        channels in 1_usize..40, height in 1_usize..30, width in 1_usize..30, half: bool,
    ) {
        let precision = if half { Precision::F16 } else { Precision::F32 };
        check([channels, height, width], precision).map_err(TestCaseError::fail)?;
    }
}

fn check([channels, height, width]: [usize; 3], precision: Precision) -> Result<(), String> {
    let input = Random::new(channels as u64).tensor(channels, height, width);
    let input = stored(&input, precision);
    let (context, map) = (context(precision), channel_map(channels));
    let shape = [channels, 2 * height, 2 * width];
    let found = run(context, &upsample(context), &input, &map, shape);
    compare(&found, &reference::upsample(&input), EXACT)
}
