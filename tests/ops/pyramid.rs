use proptest::prelude::*;
use proptest::sample;
use wgdenoise::Precision;
use wgdenoise::internals::ops::pyramid::pyramid;
use wgdenoise::internals::reference;

use super::gather::{Level, TOLERANCE, colors, constant};
use wgdenoise_testing::gpu::{PRECISIONS, context, submit};
use wgdenoise_testing::{Random, compare, run_cases};

/// Rows and columns of the coarser level.
const CASES: [[usize; 2]; 4] = [[1, 1], [8, 8], [9, 17], [3, 40]];

#[test]
fn pyramid_equals_the_reference() {
    let cases = CASES.into_iter().flat_map(|size| PRECISIONS.map(|precision| (size, precision)));
    run_cases(cases, |&(size, precision)| check(size, precision, 1));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn pyramid_equals_the_reference_at_any_size(
        size in [1_usize..30, 1_usize..30],
        seed in any::<u64>(),
        precision in sample::select(PRECISIONS.to_vec()),
    ) {
        check(size, precision, seed).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn equal_colors_stay_that_color_bit_for_bit(color in [any::<f32>(); 3], seed in any::<u64>()) {
        // Shaders may turn subnormal products into 0.
        prop_assume!(color.iter().all(|&v| v == 0.0 || (1e-30..1e30).contains(&v.abs())));
        let mut random = Random::new(seed);
        let finer = constant(&mut random, [14, 18], color);
        let found = run(&finer, &Level::logits(&mut random, 11, [7, 9], Precision::F16));
        prop_assert!(colors(&found.light).iter().all(|found| *found == color), "{:?}", found.light);
    }
}

#[test]
fn what_has_no_weight_does_not_count() {
    let mut random = Random::new(3);
    let mut finer = constant(&mut random, [2, 4], [1.0; 3]);
    for (c, value) in [(0, 9.0), (1, 9.0), (2, 9.0), (3, 0.0)] {
        finer.light.data[c * 8] = value;
    }
    let found = run(&finer, &Level::logits(&mut random, 11, [1, 2], Precision::F32));
    assert_eq!(found.light.at(0, 0, 0), 1.0);
    for c in 0..4 {
        finer.light.data[c * 8..c * 8 + 8].fill(0.0);
    }
    let found = run(&finer, &Level::logits(&mut random, 11, [1, 2], Precision::F32));
    assert_eq!(found.light.data, [0.0; 8]);
}

fn check([height, width]: [usize; 2], precision: Precision, seed: u64) -> Result<(), String> {
    let mut random = Random::new(seed);
    let finer = Level::random(&mut random, [2 * height, 2 * width], precision);
    let level = Level::logits(&mut random, 11, [height, width], precision);
    let expected = reference::pyramid(&finer.premultiplied(), &level.logits);
    compare(&run(&finer, &level).light, &Level::light_of(&expected), TOLERANCE)
}

/// Computes the level with `logits` above the finer one.
fn run(finer: &Level, level: &Level) -> Level {
    let [height, width] = [level.logits.height, level.logits.width];
    let output = Level::empty([height, width]);
    let context = context(level.precision);
    let [input, target] = [finer, &output].map(Level::upload_light);
    let call = pyramid(context, &input, &level.upload_logits(), &target);
    submit(context, |pass| call.record(pass));
    Level { light: Level::download(&target), ..output }
}
