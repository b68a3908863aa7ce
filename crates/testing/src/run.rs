//! Runs single operators.

use wgdenoise::internals::gpu::kernel::Context;
use wgdenoise::internals::ops::activity::LAYERS;
use wgdenoise::internals::ops::channel_map::{ChannelMap, channel_map};
use wgdenoise::internals::ops::need::{Need, everything};
use wgdenoise::internals::ops::operator::{Io, Operator};
use wgdenoise::internals::reference::Tensor;
use wgdenoise::wgpu::{self, util::DeviceExt as _};

use super::gpu::{download, submit, upload};

/// The result of an operator, `[channels, height, width]`, on one input.
pub fn run(
    context: &Context,
    operator: &dyn Operator,
    input: &Tensor,
    map: &ChannelMap,
    shape: [usize; 3],
) -> Tensor {
    let map_of_zero = everything(&context.device);
    let everything = Need { map: &map_of_zero, level: 0, reach: u32::MAX };
    run_where(context, operator, &[(input, map)], shape, everything)
}

/// Builds the activity map of blocks with these distances. As in `activity.wgsl`, texel `(x, y)` of
/// layer `m` is the minimum over the `2^m × 2^m` blocks from `(x, y) · 2^m`.
pub fn activity_map(
    context: &Context,
    [width, height]: [u32; 2],
    distances: &[u32],
) -> wgpu::TextureView {
    let least = |m: u32, x: u32, y: u32| {
        let covered = |first: u32, end: u32| (first << m)..((first + 1) << m).min(end);
        let blocks = covered(y, height).flat_map(|y| covered(x, width).map(move |x| (x, y)));
        blocks.map(|(x, y)| distances[(y * width + x) as usize]).min().unwrap_or(0)
    };
    let texels = (0..LAYERS).flat_map(|m| (0..height).map(move |y| (m, y)));
    let layers: Vec<u32> =
        texels.flat_map(|(m, y)| (0..width).map(move |x| least(m, x, y))).collect();
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: LAYERS };
    let texture = context.device.create_texture_with_data(
        &context.queue,
        &wgpu::TextureDescriptor {
            label: None,
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R32Uint,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        bytemuck::cast_slice(&layers),
    );
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}

/// Runs an operator where it is needed; unwritten values are −77.
pub fn run_where(
    context: &Context,
    operator: &dyn Operator,
    inputs: &[(&Tensor, &ChannelMap)],
    shape: [usize; 3],
    need: Need<'_>,
) -> Tensor {
    let inputs: Vec<_> = inputs.iter().map(|(input, map)| upload(context, input, map)).collect();
    let inputs: Vec<_> = inputs.iter().collect();
    let [channels, height, width] = shape;
    // Makes unwritten values visible.
    let unwritten = Tensor::from_fn(channels, height, width, |_, _, _| -77.0);
    let output = upload(context, &unwritten, &channel_map(channels));
    let io = Io { inputs: &inputs, output: &output, pooled: None, need: Some(need) };
    let call = operator.dispatch(&context.device, &io).expect("a kernel to run");
    submit(context, |pass| call.record(pass));
    download(context, &output, &channel_map(channels))
}

/// Returns both results of an operator that pools.
pub fn run_pooling(
    context: &Context,
    operator: &dyn Operator,
    input: &Tensor,
    [channels, height, width]: [usize; 3],
) -> [Tensor; 2] {
    let unwritten = |height, width| Tensor::from_fn(channels, height, width, |_, _, _| -77.0);
    let map = channel_map(channels);
    let input = upload(context, input, &channel_map(input.channels));
    let [output, pooled] = [(height, width), (height / 2, width / 2)]
        .map(|(height, width)| upload(context, &unwritten(height, width), &map));
    let map_of_zero = everything(&context.device);
    let need = Need { map: &map_of_zero, level: 0, reach: u32::MAX };
    let io = Io { inputs: &[&input], output: &output, pooled: Some(&pooled), need: Some(need) };
    let call = operator.dispatch(&context.device, &io).expect("a kernel to run");
    submit(context, |pass| call.record(pass));
    [output, pooled].map(|tensor| download(context, &tensor, &map))
}
