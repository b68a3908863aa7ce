use wgdenoise::Precision;
use wgdenoise::internals::ops::conv3x3::conv3x3;
use wgdenoise::internals::self_test::self_test;

use wgdenoise_testing::gpu::{context, kernel_sets, variants};
use wgdenoise_testing::run_cases;

#[test]
fn every_set_that_runs_here_passes() {
    run_cases(variants(), |&(kernels, precision)| {
        let context = context(precision);
        let build = |params: &_, map: &_| conv3x3(context, kernels, params, map, true, false);
        self_test(context, build).map_err(|error| error.to_string())
    });
}

/// Imitates a driver that swaps two weights or drops negative values.
#[test]
fn a_kernel_that_computes_something_else_fails() {
    let context = context(Precision::F16);
    for kernels in kernel_sets(Precision::F16) {
        let swapped = self_test(context, |params, map| {
            let mut params = params.clone();
            params.weight.swap(700, 701);
            conv3x3(context, kernels, &params, map, true, false)
        });
        let unclamped =
            self_test(context, |p, map| conv3x3(context, kernels, p, map, false, false));
        for result in [swapped, unclamped] {
            let error = result.unwrap_err().to_string();
            assert!(error.contains("results of a test are wrong"), "{kernels:?}: {error}");
        }
    }
}
