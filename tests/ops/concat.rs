use proptest::prelude::*;
use wgdenoise::internals::gpu::tensor::GpuTensor;
use wgdenoise::internals::model::Params;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::operator::{Io, Operator as _};
use wgdenoise::internals::ops::{concat, conv1x1::conv1x1};
use wgdenoise::internals::reference;
use wgdenoise::{KernelSet, Precision};

use wgdenoise_testing::gpu::{context, download, submit, upload};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// Convolution with the identity multiplies by 1 and adds 0, so nothing is rounded.
const EXACT: Tolerance = Tolerance { absolute: 0.0, relative: 0.0 };

/// Two kernels write to their layer ranges of one texture. Read through the channel map, its
/// contents are the concatenation.
#[test]
fn writing_side_by_side_is_concatenation() {
    run_cases([(4, 4), (5, 6), (1, 7), (8, 3)], |&(first, second)| check(first, second));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn any_two_tensors_can_be_written_side_by_side(first in 1_usize..30, second in 1_usize..30) {
        check(first, second).map_err(TestCaseError::fail)?;
    }
}

fn check(first: usize, second: usize) -> Result<(), String> {
    let context = context(Precision::F32);
    let mut random = Random::new(9);
    let parts = [random.tensor(first, 5, 9), random.tensor(second, 5, 9)];
    let map = concat::channel_map(&channel_map(first), &channel_map(second));
    let both = GpuTensor::texture(context, [9, 5], map.len() as u32 / 4);
    let mut first_quad = 0;
    for part in &parts {
        let quads = part.channels.div_ceil(4) as u32;
        copy(context, part, &GpuTensor::of(&both, first_quad, quads));
        first_quad += quads;
    }
    let found = download(context, &GpuTensor::of(&both, 0, first_quad), &map);
    compare(&found, &reference::concat(&parts[0], &parts[1]), EXACT)
}

/// Copies a tensor with a kernel, as the network does.
fn copy(
    context: &wgdenoise::internals::gpu::kernel::Context,
    tensor: &reference::Tensor,
    target: &GpuTensor,
) {
    let n = tensor.channels;
    let weight = (0..n * n).map(|i| if i % (n + 1) == 0 { 1.0 } else { 0.0 }).collect();
    let identity = Params { weight, bias: vec![0.0; n] };
    let map = channel_map(n);
    let operator = conv1x1(context, KernelSet::Plain, &identity, &map);
    let source = upload(context, tensor, &map);
    let io = Io { inputs: &[&source], output: target, pooled: None, need: None };
    let call = operator.dispatch(&context.device, &io).expect("a kernel to run");
    submit(context, |pass| call.record(pass));
}
