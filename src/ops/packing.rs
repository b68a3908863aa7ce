//! Orders weights the way the kernels read them.

use wgpu::util::DeviceExt as _;

use super::channel_map::ChannelMap;
use crate::gpu::kernel::Context;

/// Weights by `(output channel, input channel, tap)`, independent of the file's layout.
pub struct Taps<'a> {
    /// Number of output channels.
    pub outputs: usize,
    /// Number of taps: 9 for 3×3, 4 for the corners of a transposed 2×2, 1 for 1×1, 16 for one 2×2
    /// kernel per parity of row and column.
    pub taps: usize,
    /// How the input is stored.
    pub map: &'a ChannelMap,
    /// The weight of an output channel, an input channel and a tap, all in range.
    pub weight: &'a dyn Fn(usize, usize, usize) -> f32,
}

impl Taps<'_> {
    /// The weight between stored channels; 0 if either is padding or out of range.
    #[must_use]
    pub fn at(&self, output: usize, stored_input: usize, tap: usize) -> f32 {
        match self.map.get(stored_input).copied().flatten() {
            Some(input) if output < self.outputs => (self.weight)(output, input, tap),
            _ => 0.0,
        }
    }

    /// Output channels in groups of four.
    #[must_use]
    pub fn out_quads(&self) -> usize {
        self.outputs.div_ceil(4)
    }

    /// Stored input channels in groups of four.
    #[must_use]
    pub fn in_quads(&self) -> usize {
        self.map.len() / 4
    }

    /// The 4×4 matrix from an input quad to an output quad, column by column.
    #[must_use]
    pub fn matrix(&self, out_quad: usize, in_quad: usize, tap: usize) -> [f32; 16] {
        std::array::from_fn(|i| self.at(out_quad * 4 + i % 4, in_quad * 4 + i / 4, tap))
    }

    /// `[block of `quads` output quads][in_quad][tap][out_quad]` matrices, the layout of the tiled
    /// kernels.
    #[must_use]
    pub fn tiled(&self, blocks: usize, quads: usize) -> Vec<f32> {
        let mut data = Vec::new();
        for block in 0..blocks {
            for (in_quad, tap) in
                (0..self.in_quads()).flat_map(|i| (0..self.taps).map(move |t| (i, t)))
            {
                for quad in 0..quads {
                    data.extend(self.matrix(block * quads + quad, in_quad, tap));
                }
            }
        }
        data
    }
}

/// A read-only storage buffer.
#[must_use]
pub fn storage_buffer<T: bytemuck::NoUninit>(
    context: &Context,
    label: &str,
    data: &[T],
) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE;
    filled_buffer(&context.device, label, bytemuck::cast_slice(data), usage)
}

/// A buffer that begins with these bytes. Failures are reported to the device, whereas wgpu's own
/// helper panics.
pub(crate) fn filled_buffer(
    device: &wgpu::Device,
    label: &str,
    contents: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: (contents.len() as u64).next_multiple_of(4),
        usage,
        mapped_at_creation: true,
    });
    if let Ok(mut bytes) = buffer.get_mapped_range_mut(..) {
        bytes.slice(..contents.len()).copy_from_slice(contents);
    }
    buffer.unmap();
    buffer
}

/// Rows of one bias per output channel, each padded with zeros to a multiple of four.
#[must_use]
pub fn bias_table(context: &Context, bias: &[f32], outputs: usize) -> wgpu::Buffer {
    let padding = vec![0.0; outputs.next_multiple_of(4) - outputs];
    let rows = bias.chunks_exact(outputs);
    let padded: Vec<f32> = rows.flat_map(|row| row.iter().chain(&padding)).copied().collect();
    storage_buffer(context, "bias", &padded)
}

/// `[out_quad][tap][in_quad]` matrices, the layout of the plain kernels.
#[must_use]
pub fn plain_buffer(context: &Context, taps: &Taps<'_>) -> wgpu::Buffer {
    let mut data = Vec::new();
    for out_quad in 0..taps.out_quads() {
        for tap in 0..taps.taps {
            for in_quad in 0..taps.in_quads() {
                data.extend(taps.matrix(out_quad, in_quad, tap));
            }
        }
    }
    storage_buffer(context, "weights", &data)
}

/// An `rgba32float` texture array of `[layer][y][x]` texels.
#[must_use]
pub fn weight_texture(context: &Context, size: [u32; 3], texels: &[f32]) -> wgpu::TextureView {
    let [width, height, layers] = size;
    let descriptor = wgpu::TextureDescriptor {
        label: Some("weights"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let texture = context.device.create_texture_with_data(
        &context.queue,
        &descriptor,
        wgpu::util::TextureDataOrder::LayerMajor,
        bytemuck::cast_slice(texels),
    );
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}
