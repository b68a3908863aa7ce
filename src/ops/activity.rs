//! Which blocks of 16×16 pixels the network must work on. See `shaders/activity.wgsl` for what
//! makes a block clean or active, and for the map of distances to active blocks.

use super::input_process::{Sources, tile_binding};
use super::tile::Tile;
use crate::kernel::{Binding, Context, Dispatch, KernelSpec};
use crate::model::Inputs;
pub use crate::plan::halo::BLOCK;

/// Marks the clean blocks.
pub const CLASSIFY: KernelSpec = spec("activity_classify", "classify", [8, 8, 1]);
/// Makes the map from them.
pub const SPREAD: KernelSpec = spec("activity_spread", "spread", [16, 16, 1]);

const fn spec(name: &'static str, entry: &'static str, workgroup: [u32; 3]) -> KernelSpec {
    KernelSpec {
        name: std::borrow::Cow::Borrowed(name),
        source: std::borrow::Cow::Borrowed(include_str!("../../shaders/activity.wgsl")),
        entry,
        bindings: &[
            Binding::Uniform { bytes: size_of::<Tile>() as u64, dynamic: true },
            Binding::Buffer,
            Binding::Buffer,
            Binding::Buffer,
            Binding::Buffer,
            Binding::BufferMut,
            Binding::ActivityOut,
        ],
        overrides: &["has_albedo", "has_normal", "radius", "skip"],
        workgroup,
    }
}

/// Layers of the map: blocks, then squares of 2, 4, 8 and 16 blocks a side.
pub const LAYERS: u32 = 5;
/// The distance where no active block is within the radius.
pub const FAR: u32 = 255;

/// What the kernels make of a tile, and the calls of them.
#[derive(Clone, Debug)]
pub struct Activity {
    /// Distances in blocks: `r32uint`, one texel per block, [`LAYERS`] layers.
    pub map: wgpu::TextureView,
    /// For each block, row by row, a `u32`: 1 if it is clean, 0 if not.
    pub clean: wgpu::Buffer,
}

/// Binds the tiles, the images and the scale of `sources`. `tile` is the tiles' size, width
/// first; it and every tile's origin are multiples of [`BLOCK`]. Layer 0 of the map counts up to
/// `radius` blocks. Without `skip` no block is clean, and the map only says what is stored.
///
/// Needs [`bytes`] of GPU memory.
///
/// # Panics
/// If `tile` is not a multiple of [`BLOCK`] or `radius` is not below [`FAR`].
#[must_use]
pub fn activity(
    context: &Context,
    sources: &Sources<'_>,
    tile: [u32; 2],
    radius: u32,
    skip: bool,
) -> (Activity, [Dispatch; 2]) {
    assert!(tile.iter().all(|side| side % BLOCK == 0), "a tile of {tile:?} has no whole blocks");
    assert!(radius < FAR, "a radius of {radius} blocks cannot be told from {FAR}, none");
    let blocks = tile.map(|side| side / BLOCK);
    let map = map(&context.device, blocks);
    let clean = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("clean blocks"),
        size: flag_bytes(blocks),
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let flag = |set: bool| f64::from(u8::from(set));
    let Inputs { albedo, normal } = sources.inputs();
    let constants = [
        ("has_albedo", flag(albedo)),
        ("has_normal", flag(normal)),
        ("radius", f64::from(radius)),
        ("skip", flag(skip)),
    ];
    let [albedo, normal] = sources.auxiliary();
    let calls = [CLASSIFY, SPREAD].map(|spec| {
        let kernel = context.kernel(&spec, &constants);
        let resources = [
            tile_binding(sources.tiles),
            sources.color.as_entire_binding(),
            albedo.as_entire_binding(),
            normal.as_entire_binding(),
            sources.input_scale.as_entire_binding(),
            clean.as_entire_binding(),
            wgpu::BindingResource::TextureView(&map),
        ];
        kernel.dispatch(kernel.bind(&context.device, &resources), [blocks[0], blocks[1], 1])
    });
    (Activity { map, clean }, calls)
}

/// GPU memory for a tile of this size: 24 bytes per block.
#[must_use]
pub fn bytes(tile: [u32; 2]) -> u64 {
    flag_bytes(tile.map(|side| side / BLOCK)) * u64::from(1 + LAYERS)
}

fn flag_bytes([columns, rows]: [u32; 2]) -> u64 {
    u64::from(columns) * u64::from(rows) * 4
}

/// A map of zeros: every block active.
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
