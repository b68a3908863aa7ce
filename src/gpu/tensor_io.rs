//! Copies whole tensors between CPU and GPU, for tests; images use other paths.

use super::kernel::Context;
use super::precision::Precision;
use super::tensor::GpuTensor;
use super::wait::read;
use crate::error::Result;
use crate::reference::Tensor;

/// Uploads a tensor whose channel count is a multiple of four.
pub(crate) fn upload(context: &Context, tensor: &Tensor) -> GpuTensor {
    let [width, height, quads] = [tensor.width, tensor.height, tensor.channels / 4];
    let texel = |i: usize| [0, 1, 2, 3].map(|c| (i / (width * height) * 4 + c, i));
    let at = |(c, i): (usize, usize)| tensor.at(c, i / width % height, i % width);
    let values = (0..quads * width * height).flat_map(texel).map(at);
    let bytes: Vec<u8> = match context.precision {
        Precision::F32 => values.flat_map(f32::to_le_bytes).collect(),
        Precision::F16 => values.flat_map(|v| half::f16::from_f32(v).to_le_bytes()).collect(),
    };
    let texture = GpuTensor::texture(context, [width as u32, height as u32], quads as u32);
    let row = width as u32 * context.precision.texel_bytes() as u32;
    let layout = layout(row, &texture);
    context.queue.write_texture(texture.as_image_copy(), &bytes, layout, texture.size());
    GpuTensor::of(&texture, 0, quads as u32)
}

/// Submits the recorded commands and waits for the texture they fill.
pub(crate) fn download(
    context: &Context,
    mut encoder: wgpu::CommandEncoder,
    texture: &wgpu::Texture,
) -> Result<Tensor> {
    let texel = context.precision.texel_bytes() as usize;
    let row = (texture.width() as usize * texel)
        .next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
    let layout = layout(row as u32, texture);
    let buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: row as u64 * u64::from(texture.height() * texture.depth_or_array_layers()),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let target = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
    context.queue.submit([encoder.finish()]);
    let [channels, height] = [texture.depth_or_array_layers() * 4, texture.height()];
    let [channels, height, width] = [channels, height, texture.width()].map(|n| n as usize);
    read(context, &buffer, |bytes| {
        Tensor::from_fn(channels, height, width, |c, y, x| {
            let place = (c / 4 * height + y) * row + x * texel + c % 4 * texel / 4;
            decode(&bytes[place..place + texel / 4])
        })
    })
}

fn layout(row: u32, texture: &wgpu::Texture) -> wgpu::TexelCopyBufferLayout {
    let (bytes_per_row, rows_per_image) = (Some(row), Some(texture.height()));
    wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image }
}

fn decode(bytes: &[u8]) -> f32 {
    match *bytes {
        [a, b] => half::f16::from_le_bytes([a, b]).to_f32(),
        [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
        _ => unreachable!("tensors have 16 or 32 bits"),
    }
}
