use wgdenoise::internals::model::{Op, Params};
use wgdenoise::internals::self_test::{Tested, self_test};
use wgdenoise::{KernelSet, Precision};

use wgdenoise_testing::gpu::{context, kernel_sets, variants_of};
use wgdenoise_testing::run_cases;

/// The sets with 32-bit sums, like those of the matrices, which the self-test is for.
fn sets(precision: Precision) -> Vec<KernelSet> {
    kernel_sets(precision).into_iter().filter(|&set| set != KernelSet::Half).collect()
}

#[test]
fn every_set_that_runs_here_passes() {
    run_cases(variants_of(sets), |&(kernels, precision)| {
        let context = context(precision);
        let build =
            |tested: &Tested, params: &_, maps: &[&_]| tested.build(context, kernels, params, maps);
        self_test(context, build).map_err(|error| error.to_string())
    });
}

/// Imitates a driver that swaps two weights, drops a bias or forgets a ReLU in one kind of layer.
#[test]
fn a_kernel_that_computes_something_else_fails() {
    let faults: [fn(&mut Tested, &mut Params); 3] = [
        |_, params| params.weight.swap(700, 701),
        |_, params| params.bias[3] = 0.0,
        |tested, _| tested.op = without_relu(tested.op),
    ];
    let kinds = [("conv3x3", false), ("conv3x3", true), ("up_conv", false), ("conv_logits", false)];
    for kernels in sets(Precision::F16) {
        for (i, kind) in kinds.into_iter().enumerate() {
            // The ReLU inside `conv_logits` cannot be removed.
            let count = if i == 3 { 2 } else { 3 };
            for fault in &faults[..count] {
                let error = with_fault(kernels, kind, *fault);
                let found = error.contains("results of a test are wrong");
                assert!(found, "{kernels:?} {kind:?}: {error}");
            }
        }
    }
}

/// The error of a self-test with a fault in one kind of layer, given by its operator and whether it
/// pools.
fn with_fault(
    kernels: KernelSet,
    kind: (&str, bool),
    fault: fn(&mut Tested, &mut Params),
) -> String {
    let context = context(Precision::F16);
    let found = self_test(context, |tested, params, maps| {
        let (mut tested, mut params) = (*tested, params.clone());
        if (tested.op.name(), tested.pools) == kind {
            fault(&mut tested, &mut params);
        }
        tested.build(context, kernels, &params, maps)
    });
    found.expect_err("a fault must show").to_string()
}

fn without_relu(op: Op) -> Op {
    match op {
        Op::Conv3x3 { .. } => Op::Conv3x3 { relu: false },
        Op::UpConv { ups, .. } => Op::UpConv { ups, relu: false },
        other => other,
    }
}
