//! Finds the blocks of 16×16 pixels that the network must work on. `shaders/activity.wgsl` defines
//! clean and active blocks and the map of distances to active ones.

use super::image::{ImageFormat, source_features};
use super::input_process::{Sources, TILE, scale_binding, source_names, tile_binding};
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
pub use crate::plan::halo::BLOCK;
use crate::shader::ShaderRoot;

/// Finds the even blocks of color, albedo and normal in these formats.
#[must_use]
pub fn classify_spec(formats: [ImageFormat; 3]) -> KernelSpec {
    spec("classify", [8, 8, 1], formats)
}

/// Marks the clean blocks.
#[must_use]
pub fn settle_spec(formats: [ImageFormat; 3]) -> KernelSpec {
    spec("settle", [8, 8, 1], formats)
}

/// Builds the distance map from the clean blocks.
#[must_use]
pub fn spread_spec(formats: [ImageFormat; 3]) -> KernelSpec {
    spec("spread", [16, 16, 1], formats)
}

fn spec(entry: &'static str, workgroup: [u32; 3], formats: [ImageFormat; 3]) -> KernelSpec {
    let [color, albedo, normal] = formats.map(ImageFormat::source_binding);
    let (clean, map) = (Binding::BufferMut, Binding::ActivityOut);
    KernelSpec {
        name: format!("activity_{entry} {}", source_names(formats)).into(),
        source: ShaderRoot::Module("activity"),
        features: source_features(formats).into(),
        entry,
        bindings: vec![TILE, color, albedo, normal, Binding::Buffer, clean, map].into(),
        overrides: &[
            "brightest",
            "has_albedo",
            "has_normal",
            "radius",
            "skip",
            "transfer_function",
            "unorm_normal",
        ],
        workgroup,
    }
}

/// Layers of the map: blocks, then squares of 2, 4, 8 and 16 blocks a side.
pub const LAYERS: u32 = 5;
/// The distance if no active block is within the radius.
pub const FAR: u32 = 255;

/// The calls for a tile and the results they write.
#[derive(Clone, Debug)]
pub struct Activity {
    /// Distances in blocks: `r32uint`, one texel per block, [`LAYERS`] layers.
    pub map: wgpu::TextureView,
    /// One `u32` per block, row by row: 1 if clean, 0 if not. A scratch area of the same size
    /// follows, for the kernels alone.
    pub clean: wgpu::Buffer,
}

/// Binds the tiles, the images and the scale of `sources`. `tile` is the size of the tiles, width
/// first; it and every tile's origin are multiples of [`BLOCK`]. Layer 0 of the map counts up to
/// `radius` blocks. Without `skip`, no block is clean and the map only marks what is stored.
///
/// Needs [`bytes`] of GPU memory.
///
/// # Panics
/// Panics if `tile` is not a multiple of [`BLOCK`] or `radius` is not below [`FAR`].
#[must_use]
pub fn activity(
    context: &Context,
    sources: &Sources<'_>,
    tile: [u32; 2],
    radius: u32,
    skip: bool,
) -> (Activity, [Dispatch; 3]) {
    assert!(tile.iter().all(|side| side % BLOCK == 0), "a tile of {tile:?} has no whole blocks");
    assert!(radius < FAR, "a radius of {radius} blocks, but {FAR} means none in reach");
    let blocks = tile.map(|side| side / BLOCK);
    let map = map(&context.device, blocks);
    let clean = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("clean blocks"),
        size: 2 * flag_bytes(blocks),
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let sources = Sources { encoding: sources.encoding.perceptual(), ..*sources };
    let mut constants = sources.constants().to_vec();
    constants.extend([("radius", f64::from(radius)), ("skip", f64::from(u8::from(skip)))]);
    let images = sources.images();
    let formats = images.map(|image| image.format());
    let specs = [classify_spec, settle_spec, spread_spec].map(|spec| spec(formats));
    let calls = specs.map(|spec| {
        let kernel = context.kernel(&spec, &constants);
        let [color, albedo, normal] = images.map(|image| image.resource());
        let resources = [
            tile_binding(sources.tiles),
            color,
            albedo,
            normal,
            scale_binding(sources.input_scale),
            clean.as_entire_binding(),
            wgpu::BindingResource::TextureView(&map),
        ];
        kernel.dispatch(kernel.bind(&context.device, &resources), [blocks[0], blocks[1], 1])
    });
    (Activity { map, clean }, calls)
}

/// GPU memory for a tile of this size: 28 bytes per block.
#[must_use]
pub fn bytes(tile: [u32; 2]) -> u64 {
    flag_bytes(tile.map(|side| side / BLOCK)) * u64::from(2 + LAYERS)
}

fn flag_bytes([columns, rows]: [u32; 2]) -> u64 {
    u64::from(columns) * u64::from(rows) * 4
}

/// A map of zeros: every block is active.
pub(super) fn map(device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("activity"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: LAYERS },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Uint,
        usage: wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}
