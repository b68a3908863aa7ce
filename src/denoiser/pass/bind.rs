//! Turns a checked descriptor into a pass.

use super::accumulation::{self, Accumulation};
use super::held::{Held, Rescue};
use super::image::Role;
use super::{InputScale, Pass, PassDescriptor, PassImage};
use crate::denoiser::Denoiser;
use crate::error::{Error, Result};
use crate::gpu::kernel::{Binding, binding_type};
use crate::gpu::scopes::catch;
use crate::network::bind::{Bound, BoundLayer, TileCalls};
use crate::network::compile::CompiledNetwork;
use crate::ops::accumulate::FrameImages;
use crate::ops::accumulate_layer::{LayerHistory, LayerImages};
use crate::ops::autoexposure::{Autoexposure, Band, autoexposure};
use crate::ops::image::ImageBinding;
use crate::ops::input_process::{Sources, scale_binding};
use crate::ops::packing::filled_buffer;
use crate::ops::tile::{Layout, Tile};
use crate::plan::tiles::{PlacedTile, TilePlan};

/// A multiple of every adapter's alignment of dynamic uniform offsets.
const TILE_STRIDE: usize = 256;

/// The images in the form that kernels bind.
struct BoundImages {
    color: Held,
    albedo: Option<Held>,
    normal: Option<Held>,
    motion: Option<Held>,
    depth: Option<Held>,
    output: Held,
    /// Each layer and its output.
    layers: Vec<[Held; 2]>,
    rescues: Vec<Rescue>,
}

impl BoundImages {
    /// The images that frame averaging reads and writes; `None` without motion.
    fn frame<'a>(
        &'a self,
        sources: &Sources<'a>,
        denoised: Option<&'a wgpu::TextureView>,
    ) -> Option<FrameImages<'a>> {
        Some(FrameImages {
            tile: sources.tiles,
            denoised: denoised?,
            motion: self.motion.as_ref()?.binding(),
            albedo: sources.albedo,
            normal: sources.normal,
            unorm_normal: sources.unorm_normal,
            depth: self.depth.as_ref().map(Held::binding),
            input_scale: sources.input_scale,
            output: self.output.binding(),
        })
    }
}

impl Denoiser {
    pub(super) fn bind(
        &self,
        d: &PassDescriptor<'_>,
        network: &CompiledNetwork,
        plan: &TilePlan,
    ) -> Result<Pass> {
        let images = self.hold(d)?;
        self.context.catch(|| Ok(self.bind_images(d, images, network, plan)))
    }

    /// Holds the images, rejecting those of other devices.
    fn hold(&self, d: &PassDescriptor<'_>) -> Result<BoundImages> {
        let device = &self.context.device;
        let mut rescues = Vec::new();
        let mut hold = |role: Role, image: PassImage<'_>| {
            let binding = if role.is_output() {
                image.format().target_binding()
            } else {
                image.format().source_binding()
            };
            let held = check_device(device, &role, || {
                let held = Held::new(&image, d.size(), &device.limits());
                try_bind(device, binding, held.binding().resource());
                held
            })?;
            if role.is_output() || !d.overwrites(&image) {
                return Ok(held);
            }
            let (held, rescue) = catch(device, || Ok(held.rescued(device)))?;
            rescues.push(rescue);
            Ok(held)
        };
        let of_normal = Role::Normal { unorm: d.unorm_normal() };
        let color = hold(Role::Color, d.color)?;
        let albedo = d.albedo.map(|image| hold(Role::Albedo, image)).transpose()?;
        let normal = d.normal.map(|image| hold(of_normal, image)).transpose()?;
        let motion = d.motion.map(|image| hold(Role::Motion, image)).transpose()?;
        let depth = d.depth.map(|image| hold(Role::Depth, image)).transpose()?;
        let output = hold(Role::Output, d.output)?;
        let layers = d.layers.iter().enumerate().map(|(i, layer)| {
            Ok([hold(Role::Layer(i), layer.noisy)?, hold(Role::LayerOutput(i), layer.output)?])
        });
        let layers = layers.collect::<Result<_>>()?;
        if let InputScale::Buffer(buffer) = d.input_scale {
            let bind = || try_bind(device, Binding::Buffer, scale_binding(buffer));
            check_device(device, &"input scale", bind)?;
        }
        Ok(BoundImages { color, albedo, normal, motion, depth, output, layers, rescues })
    }

    fn bind_images(
        &self,
        d: &PassDescriptor<'_>,
        images: BoundImages,
        network: &CompiledNetwork,
        plan: &TilePlan,
    ) -> Pass {
        let (context, device) = (&self.context, &self.context.device);
        let scale = scale_buffer(device, &d.input_scale);
        let blend = uniform(device, bytemuck::bytes_of(&0.0_f32));
        let tile = whole_tile(d.size(), &images);
        let tiles = uniform(device, &tile_bytes(&tile, plan));
        let histories = accumulation::layer_histories(device, d);
        let stored = stored_layers(d, &images, &histories);
        let layer_tiles = images.layers.iter().zip(&stored).map(|([noisy, _], (layout, _))| {
            uniform(device, &tile_bytes(&layer_tile(&tile, noisy, *layout), plan))
        });
        let layer_tiles: Vec<_> = layer_tiles.collect();
        let layers = images.layers.iter().zip(&stored).zip(&layer_tiles).zip(d.layers);
        let layers = layers.map(|((([noisy, _], &(_, output)), tiles), layer)| BoundLayer {
            tiles,
            color: noisy.binding(),
            output,
            light: layer.light,
        });
        let layers: Vec<_> = layers.collect();
        let sources = Sources {
            tiles: &tiles,
            color: images.color.binding(),
            albedo: images.albedo.as_ref().map(Held::binding),
            normal: images.normal.as_ref().map(Held::binding),
            unorm_normal: d.unorm_normal(),
            input_scale: &scale,
            encoding: network.encoding,
        };
        let denoised = d.motion.map(|_| accumulation::denoised(device, d.size()));
        let bound = Bound {
            tile: plan.tile,
            sources,
            output: denoised.as_ref().map_or(images.output.binding(), ImageBinding::Texture),
            blend: &blend,
            skip_clean: self.options.skip_clean,
            layers: &layers,
        };
        let graph = TileCalls::new(context, network, &bound);
        let frame = images.frame(&sources, denoised.as_ref());
        let accumulation =
            frame.map(|frame| {
                let tiles = averaged_layer_tiles(device, &tile, &images);
                let layers = images.layers.iter().zip(&tiles).map(|([_, output], tile)| {
                    LayerImages { tile, motion: frame.motion, output: output.binding() }
                });
                Accumulation::new(context, d, &frame, layers.zip(histories).collect())
            });
        let exposure = self.exposure(d, &images.color, &scale);
        let tiles = (0..plan.tiles.len()).map(|i| (i * TILE_STRIDE) as u32).collect();
        let queue = context.queue.clone();
        Pass { rescues: images.rescues, exposure, graph, tiles, accumulation, blend, queue }
    }

    /// The exposure measurement, unless the caller supplies the scale.
    fn exposure(
        &self,
        d: &PassDescriptor<'_>,
        color: &Held,
        scale: &wgpu::Buffer,
    ) -> Option<Autoexposure> {
        if !matches!(d.input_scale, InputScale::Auto)
            || !self.weights().metadata().transfer_function.is_hdr()
        {
            return None;
        }
        let band = Band::whole(d.width, d.height, color.layout);
        let uniform = uniform(&self.context.device, bytemuck::bytes_of(&band));
        Some(autoexposure(&self.context, &band, &uniform, color.binding(), scale))
    }
}

/// Runs `bind`. The image has passed all other checks, so an error blames its device.
fn check_device<T>(
    device: &wgpu::Device,
    name: &dyn std::fmt::Display,
    bind: impl FnOnce() -> T,
) -> Result<T> {
    catch(device, || Ok(bind())).map_err(|report| match report {
        Error::Device { .. } => Error::Image(format!(
            "{name} cannot be bound on the denoiser's device: it belongs to another device or was \
             destroyed; create it on the device passed to Denoiser::new ({report})"
        )),
        // A lost device or a lack of memory is not the image's fault.
        other => other,
    })
}

/// Binds a resource so that the device validates it.
fn try_bind(device: &wgpu::Device, binding: Binding, resource: wgpu::BindingResource<'_>) {
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: binding_type(binding, wgpu::TextureFormat::Rgba32Float),
            count: None,
        }],
    });
    let _ = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource }],
    });
}

/// The whole image as one tile.
fn whole_tile(image_size: [u32; 2], images: &BoundImages) -> Tile {
    let layout = |image: &Option<Held>| image.as_ref().map(|held| held.layout).unwrap_or_default();
    Tile {
        image_size,
        color: images.color.layout,
        albedo: layout(&images.albedo),
        normal: layout(&images.normal),
        motion: layout(&images.motion),
        depth: layout(&images.depth),
        output: images.output.layout,
        ..Tile::default()
    }
}

/// The same tile for a layer whose result has this layout.
fn layer_tile(beauty: &Tile, noisy: &Held, output: Layout) -> Tile {
    Tile { color: noisy.layout, output, beauty: beauty.color, ..*beauty }
}

/// Where the network stores each layer: in its history if there is motion, else in its output.
fn stored_layers<'a>(
    d: &PassDescriptor<'_>,
    images: &'a BoundImages,
    histories: &'a [LayerHistory],
) -> Vec<(Layout, ImageBinding<'a>)> {
    let outputs = images.layers.iter().map(|[_, output]| (output.layout, output.binding()));
    let histories =
        histories.iter().map(|history| (LayerHistory::layout(d.width), history.denoised()));
    if d.motion.is_some() { histories.collect() } else { outputs.collect() }
}

/// One uniform buffer per layer with the whole image as a tile, for averaging.
fn averaged_layer_tiles(
    device: &wgpu::Device,
    beauty: &Tile,
    images: &BoundImages,
) -> Vec<wgpu::Buffer> {
    let tile = |[noisy, output]: &[Held; 2]| layer_tile(beauty, noisy, output.layout);
    let tiles = images.layers.iter().map(tile);
    tiles.map(|tile| uniform(device, bytemuck::bytes_of(&tile))).collect()
}

/// All tiles of a plan, one every [`TILE_STRIDE`] bytes.
fn tile_bytes(whole: &Tile, plan: &TilePlan) -> Vec<u8> {
    let mut bytes = vec![0; plan.tiles.len() * TILE_STRIDE];
    for (slot, placed) in bytes.chunks_exact_mut(TILE_STRIDE).zip(&plan.tiles) {
        let PlacedTile { origin, stores } = *placed;
        let tile = Tile { origin, begin: stores.begin, end: stores.end, ..*whole };
        slot[..size_of::<Tile>()].copy_from_slice(bytemuck::bytes_of(&tile));
    }
    bytes
}

fn uniform(device: &wgpu::Device, contents: &[u8]) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    filled_buffer(device, "uniform", contents, usage)
}

/// The input-scale buffer: the caller's, or a new one with the caller's value or a placeholder.
fn scale_buffer(device: &wgpu::Device, scale: &InputScale<'_>) -> wgpu::Buffer {
    let value = match *scale {
        InputScale::Buffer(buffer) => return buffer.clone(),
        InputScale::Value(value) => value,
        InputScale::Auto => 1.0,
    };
    let value = bytemuck::bytes_of(&value);
    filled_buffer(device, "input_scale", value, wgpu::BufferUsages::STORAGE)
}
