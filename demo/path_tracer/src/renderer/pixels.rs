//! Reads textures back to the CPU.

use half::f16;

use super::Result;

/// Reads a texture's pixels, row by row from the top left; missing channels are 0. Waits for the
/// device.
///
/// # Errors
/// If the device fails.
pub fn read(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<[f32; 4]>> {
    let texel = texture.format().block_copy_size(None).ok_or("the texture has no texels")?;
    let row = texture.width() * texel;
    let padded_row = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: u64::from(padded_row) * u64::from(texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    copy(device, queue, texture, &buffer, padded_row);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let bytes = buffer.get_mapped_range(..)?;
    let rows = bytes.chunks_exact(padded_row as usize);
    Ok(rows.flat_map(|bytes| decode(&bytes[..row as usize], texture.format())).collect())
}

fn copy(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    buffer: &wgpu::Buffer,
    padded_row: u32,
) {
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(padded_row),
        rows_per_image: None,
    };
    let target = wgpu::TexelCopyBufferInfo { buffer, layout };
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
    queue.submit([encoder.finish()]);
}

/// Decodes a row in one of the film's formats.
fn decode(bytes: &[u8], format: wgpu::TextureFormat) -> Vec<[f32; 4]> {
    let channels: Vec<f32> = match format {
        wgpu::TextureFormat::Rgba8Unorm => bytes.iter().map(|&b| f32::from(b) / 255.0).collect(),
        wgpu::TextureFormat::Rgba16Float => {
            bytes.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect()
        }
        _ => bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
    };
    let pixels = channels.chunks_exact(usize::from(format.components()));
    pixels.map(|c| std::array::from_fn(|i| c.get(i).copied().unwrap_or(0.0))).collect()
}
