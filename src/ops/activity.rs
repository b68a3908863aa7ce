//! Finds the blocks of 16×16 pixels that the network must process. `shaders/activity.wgsl` defines
//! clean and active blocks and the map of distances to active ones.

use super::image::{ImageBinding, ImageFormat, color_features};
use super::input_process::{TILE, tile_binding};
use crate::gpu::kernel::{Binding, Context, Dispatch, KernelSpec};
pub use crate::plan::halo::BLOCK;
use crate::shader::ShaderRoot;

/// Finds the constant blocks of a color in this format.
#[must_use]
pub fn classify_spec(color: ImageFormat) -> KernelSpec {
    spec("classify", [8, 8, 1], color)
}

/// Marks the clean blocks.
#[must_use]
pub fn settle_spec(color: ImageFormat) -> KernelSpec {
    spec("settle", [8, 8, 1], color)
}

/// Builds the distance map from the clean blocks.
#[must_use]
pub fn spread_spec(color: ImageFormat) -> KernelSpec {
    spec("spread", [16, 16, 1], color)
}

fn spec(entry: &'static str, workgroup: [u32; 3], color: ImageFormat) -> KernelSpec {
    let (clean, map) = (Binding::BufferMut, Binding::ActivityOut);
    KernelSpec {
        name: format!("activity_{entry} {}", color.source_name()).into(),
        source: ShaderRoot::Module("activity"),
        features: color_features(color).into(),
        entry,
        bindings: vec![TILE, color.source_binding(), clean, map].into(),
        overrides: &["constant_radius", "radius"],
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
    /// follows, for the kernels only.
    pub clean: wgpu::Buffer,
}

/// Binds the tiles and the color. `tile` is the size of the tiles, width first; it and every tile's
/// origin are multiples of [`BLOCK`]. Layer 0 of the map counts up to `radius` blocks. A block is
/// clean if it and all blocks up to `constant_radius` away are the same constant color. Without
/// that radius, no block is clean, and every block with stored pixels is active.
///
/// Needs [`bytes`] of GPU memory.
///
/// # Panics
/// Panics if `tile` is not a multiple of [`BLOCK`] or `radius` is not below [`FAR`].
#[must_use]
pub fn activity(
    context: &Context,
    tiles: &wgpu::Buffer,
    color: ImageBinding<'_>,
    tile: [u32; 2],
    radius: u32,
    constant_radius: Option<u32>,
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
    let constants = [
        ("constant_radius", constant_radius.map_or(-1.0, f64::from)),
        ("radius", f64::from(radius)),
    ];
    let calls = [classify_spec, settle_spec, spread_spec].map(|spec| {
        let kernel = context.kernel(&spec(color.format()), &constants);
        let resources = [
            tile_binding(tiles),
            color.resource(),
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
