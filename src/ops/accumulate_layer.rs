//! Averages a further layer of the image along motion vectors, with the weights of its beauty.
//! `shaders/accumulate_layer.wgsl` defines it.

use super::accumulate::{History, last_frames, this_frame};
use super::image::{Element, ImageBinding, ImageFormat, accumulate_layer_features};
use super::input_process::{TILE, tile_binding};
use super::tile::Layout;
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::shader::ShaderRoot;

/// Bytes per pixel of a [`LayerHistory`].
pub const BYTES: u64 = 2 * PIXEL_BYTES;

/// A pixel has four 32-bit floats.
const PIXEL_BYTES: u64 = 16;

/// Makes the beauty read its history as softly as the layer, for motion and result in these
/// formats.
#[must_use]
pub fn soften_spec(motion: ImageFormat, output: ImageFormat) -> KernelSpec {
    spec("soften", motion, output)
}

/// Stores the mean, for motion and result in these formats.
#[must_use]
pub fn average_spec(motion: ImageFormat, output: ImageFormat) -> KernelSpec {
    spec("average", motion, output)
}

fn spec(entry: &'static str, motion: ImageFormat, output: ImageFormat) -> KernelSpec {
    let names = format!("{} {}", motion.source_name(), output.target_name());
    KernelSpec {
        name: format!("accumulate_layer_{entry} {names}").into(),
        source: ShaderRoot::Module("accumulate_layer"),
        features: accumulate_layer_features(motion, output).into(),
        entry,
        bindings: vec![
            TILE,
            motion.source_binding(),
            output.target_binding(),
            Binding::BufferMut,
            Binding::Buffer,
            Binding::BufferMut,
        ]
        .into(),
        overrides: &[],
        workgroup: [8, 8, 1],
    }
}

/// The history of a layer's last frames, and the one that the next frame leaves.
#[derive(Debug)]
pub struct LayerHistory {
    last: wgpu::Buffer,
    next: wgpu::Buffer,
}

impl LayerHistory {
    /// An empty history for images of `pixels` pixels.
    #[must_use]
    pub fn new(device: &wgpu::Device, pixels: u64) -> Self {
        Self {
            last: last_frames(device, pixels * PIXEL_BYTES),
            next: this_frame(device, pixels * PIXEL_BYTES),
        }
    }

    /// Receives the denoised layer with its alpha, before [`LayerCalls::average`].
    #[must_use]
    pub fn denoised(&self) -> ImageBinding<'_> {
        let buffer = &self.next;
        ImageBinding::Buffer { buffer, element: Element::F32, offset: 0, size: None }
    }

    /// The layout of [`denoised`](Self::denoised).
    #[must_use]
    pub fn layout(width: u32) -> Layout {
        Layout::packed_rgba(width)
    }

    /// Records the copy that makes this frame the last one. Comes after [`LayerCalls::average`].
    pub fn advance(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.copy_buffer_to_buffer(&self.next, 0, &self.last, 0, self.last.size());
    }
}

/// The images of a layer.
#[derive(Clone, Copy, Debug)]
pub struct LayerImages<'a> {
    /// A [`Tile`](super::tile::Tile) with the size and layouts of the images.
    pub tile: &'a wgpu::Buffer,
    /// The beauty's motion: where each pixel's surface was in the last frame.
    pub motion: ImageBinding<'a>,
    /// Receives the mean, with the denoised layer's alpha.
    pub output: ImageBinding<'a>,
}

/// The calls for a layer.
#[derive(Clone, Debug)]
pub struct LayerCalls {
    /// Runs before [`accumulate`](super::accumulate::accumulate).
    pub soften: Dispatch,
    /// Runs after it.
    pub average: Dispatch,
}

/// The calls for a layer of an image of `size` pixels. `beauty` is the history of the image's color
/// and must have layers. Record the calls with [`Dispatch::record_at`] and the offset of the tile,
/// then [`LayerHistory::advance`].
#[must_use]
pub fn accumulate_layer(
    context: &Context,
    size: [u32; 2],
    images: &LayerImages<'_>,
    history: &LayerHistory,
    beauty: &History,
) -> LayerCalls {
    let LayerImages { tile, motion, output } = images;
    let resources = [
        tile_binding(tile),
        motion.resource(),
        output.resource(),
        beauty.of_this_frame().as_entire_binding(),
        history.last.as_entire_binding(),
        history.next.as_entire_binding(),
    ];
    let call = |spec: KernelSpec| {
        let kernel = context.kernel(&spec, &[]);
        kernel.dispatch(kernel.bind(&context.device, &resources), [size[0], size[1], 1])
    };
    LayerCalls {
        soften: call(soften_spec(motion.format(), output.format())),
        average: call(average_spec(motion.format(), output.format())),
    }
}
