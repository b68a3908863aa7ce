use proptest::prelude::*;
use proptest::sample;
use wgdenoise::Precision;
use wgdenoise::internals::gpu::tensor::GpuTensor;
use wgdenoise::internals::ops::pyramid::pyramid;
use wgdenoise::internals::reference::{self, Tensor};

use super::gather::{Level, TOLERANCE, constant, equal, is_constant};
use wgdenoise_testing::gpu::{PRECISIONS, context, submit};
use wgdenoise_testing::{Random, compare, run_cases};

/// Rows and columns of the coarser level.
const CASES: [[usize; 2]; 4] = [[1, 1], [8, 8], [9, 17], [3, 40]];

#[test]
fn pyramid_equals_the_reference() {
    let kinds = PRECISIONS.into_iter().flat_map(|p| [false, true].map(|albedo| (p, albedo)));
    let cases = CASES.into_iter().flat_map(|size| kinds.clone().map(move |kind| (size, kind)));
    run_cases(cases, |&(size, kind)| check(size, kind, 1));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn pyramid_equals_the_reference_at_any_size(
        size in [1_usize..30, 1_usize..30],
        (albedo, seed) in (any::<bool>(), any::<u64>()),
        precision in sample::select(PRECISIONS.to_vec()),
    ) {
        check(size, (precision, albedo), seed).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn equal_pixels_stay_as_they_are_bit_for_bit(pixel in equal(), seed in any::<u64>()) {
        let mut random = Random::new(seed);
        let finer = constant(&mut random, [14, 18], pixel);
        let found = run(&finer, &Level::logits(&mut random, 11, [7, 9], Precision::F16));
        prop_assert!(is_constant(&found, pixel), "{found:?}");
    }
}

#[test]
fn what_has_no_weight_does_not_count() {
    let mut random = Random::new(3);
    let mut finer = constant(&mut random, [2, 4], ([1.0; 3], None));
    for (c, value) in [(0, 9.0), (1, 9.0), (2, 9.0), (3, 0.0)] {
        finer.light.data[c * 8] = value;
    }
    let found = run(&finer, &Level::logits(&mut random, 11, [1, 2], Precision::F32));
    assert_eq!(found.at(0, 0, 0), 1.0);
    for c in 0..4 {
        finer.light.data[c * 8..c * 8 + 8].fill(0.0);
    }
    let found = run(&finer, &Level::logits(&mut random, 11, [1, 2], Precision::F32));
    assert_eq!(found.data, [0.0; 8]);
}

fn check(
    [height, width]: [usize; 2],
    (precision, has_albedo): (Precision, bool),
    seed: u64,
) -> Result<(), String> {
    let mut random = Random::new(seed);
    let finer = Level::random(&mut random, [2 * height, 2 * width], precision);
    let finer = if has_albedo { finer.with_albedo(&mut random) } else { finer };
    let level = Level::logits(&mut random, 11, [height, width], precision);
    // The albedo is averaged as if it were another color of the same weight.
    let expected = finer.like(|of| reference::pyramid(&of(&finer), &level.logits));
    compare(&run(&finer, &level), &expected, TOLERANCE)
}

/// Computes the level with these logits above the finer one.
fn run(finer: &Level, level: &Level) -> Tensor {
    let context = context(level.precision);
    let input = finer.upload_light();
    let size = [level.logits.width as u32, level.logits.height as u32];
    let target = GpuTensor::light(context, size, input.quads);
    let call = pyramid(context, &input, &level.upload_logits(), &target);
    submit(context, |pass| call.record(pass));
    Level::download(&target)
}
