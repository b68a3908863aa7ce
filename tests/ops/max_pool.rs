use proptest::prelude::*;
use wgdenoise::Precision;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::max_pool::max_pool;
use wgdenoise::internals::reference;

use wgdenoise_testing::gpu::{context, stored};
use wgdenoise_testing::run::run;
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// The maximum is one of the stored values, so nothing is rounded.
const EXACT: Tolerance = Tolerance { absolute: 0.0, relative: 0.0 };

/// Channels, rows and columns of the input, all sides even.
const CASES: [(usize, usize, usize); 6] =
    [(1, 2, 2), (3, 4, 6), (4, 16, 16), (6, 18, 14), (9, 2, 34), (33, 32, 10)];

#[test]
fn max_pool_equals_the_reference_exactly() {
    let precisions = [Precision::F32, Precision::F16];
    let cases = CASES.iter().flat_map(|case| precisions.map(|precision| (*case, precision)));
    run_cases(cases, |&((channels, height, width), precision)| {
        check([channels, height, width], precision)
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn max_pool_equals_the_reference_at_any_shape(
        channels in 1_usize..40, height in 1_usize..30, width in 1_usize..30, half: bool,
    ) {
        let precision = if half { Precision::F16 } else { Precision::F32 };
        check([channels, 2 * height, 2 * width], precision).map_err(TestCaseError::fail)?;
    }
}

fn check([channels, height, width]: [usize; 3], precision: Precision) -> Result<(), String> {
    let input = Random::new(channels as u64).tensor(channels, height, width);
    let input = stored(&input, precision);
    let (context, map) = (context(precision), channel_map(channels));
    let shape = [channels, height / 2, width / 2];
    let found = run(context, &max_pool(context), &input, &map, shape);
    compare(&found, &reference::max_pool(&input), EXACT)
}
