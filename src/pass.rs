//! The denoiser bound to a size and to images on the GPU: what a renderer records per frame.

use wgpu::util::DeviceExt as _;

use crate::denoiser::{Denoiser, MAX_SIDE};
use crate::error::{Error, Result};
use crate::frame::check_input_scale;
use crate::graph::Model;
use crate::model::Inputs;
use crate::ops::autoexposure::{Autoexposure, Band, autoexposure};
use crate::ops::input_process::Sources;
use crate::ops::tile::{Layout, Tile};
use crate::plan::tiles::TilePlan;
use crate::tile_graph::{Bound, TileGraph};

/// An image on the GPU.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum PassImage<'a> {
    /// 32-bit floats in a storage buffer.
    Buffer {
        /// The buffer, with usage `STORAGE`.
        buffer: &'a wgpu::Buffer,
        /// Where its pixels are.
        layout: Layout,
    },
}

/// What a pass reads and writes.
#[derive(Clone, Copy, Debug)]
pub struct PassDescriptor<'a> {
    /// Pixels per row of every image.
    pub width: u32,
    /// Rows of every image.
    pub height: u32,
    /// Linear, scene-referred colour.
    pub color: PassImage<'a>,
    /// Albedo in `[0, 1]`, if there is one.
    pub albedo: Option<PassImage<'a>>,
    /// Normal in `[−1, 1]`, if there is one.
    pub normal: Option<PassImage<'a>>,
    /// Where the denoised colour goes. Not one of the inputs.
    pub output: PassImage<'a>,
    /// What colour is multiplied by for the network; `None` measures it anew in every frame.
    pub input_scale: Option<f32>,
}

/// A denoising pass over images on the GPU. Recording it creates nothing and cannot fail.
#[derive(Debug)]
pub struct Pass {
    exposure: Option<Autoexposure>,
    graph: TileGraph,
    /// Offset of each tile in the uniform buffer, in bytes.
    tiles: Vec<u32>,
}

/// Dynamic uniform offsets are multiples of this on every adapter.
const TILE_STRIDE: usize = 256;

impl Denoiser {
    /// Binds the denoiser to images. Another size or other images are another pass.
    ///
    /// # Errors
    /// If a buffer is too small for its image, larger than the device can bind or without the
    /// usage `STORAGE`, pixels overlap, the input scale is no positive number, the weights were
    /// not trained with an input, or the tensors do not fit the memory budget.
    pub fn pass(&self, descriptor: &PassDescriptor<'_>) -> Result<Pass> {
        let inputs = descriptor.inputs();
        descriptor.check(&self.context.device.limits())?;
        let model = self.model(inputs)?;
        let size = [descriptor.width, descriptor.height];
        let plan = self.plan(size, &model, 0)?;
        self.context.catch(|| Ok(self.bind_pass(descriptor, &model, &plan)))
    }

    fn bind_pass(&self, d: &PassDescriptor<'_>, model: &Model, plan: &TilePlan) -> Pass {
        let (context, device) = (&self.context, &self.context.device);
        let scale = scale_buffer(device, d.input_scale.unwrap_or(1.0));
        let tiles = uniform(device, &tile_bytes(d, plan));
        let sources = Sources {
            tiles: &tiles,
            color: d.color.buffer(),
            albedo: d.albedo.map(|image| image.buffer()),
            normal: d.normal.map(|image| image.buffer()),
            input_scale: &scale,
        };
        let bound = Bound {
            tile: plan.tile,
            sources,
            output: d.output.buffer(),
            skip_clean: self.options.skip_clean,
        };
        let graph = TileGraph::new(context, model, &bound);
        let exposure = d.input_scale.is_none().then(|| {
            let band = Band::whole(d.width, d.height, d.color.layout());
            let uniform = uniform(device, bytemuck::bytes_of(&band));
            autoexposure(context, &band, &uniform, d.color.buffer(), &scale)
        });
        let tiles = (0..plan.tiles.len()).map(|i| (i * TILE_STRIDE) as u32).collect();
        Pass { exposure, graph, tiles }
    }
}

impl Pass {
    /// Records the whole pass: exposure, then tile by tile the network. All of it becomes one
    /// submission of the caller's.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("wgdenoise"),
            timestamp_writes: None,
        });
        if let Some(exposure) = &self.exposure {
            exposure.bins.record(&mut pass);
            exposure.reduce.record(&mut pass);
        }
        for &offset in &self.tiles {
            self.graph.record_at(&mut pass, offset);
        }
    }
}

impl<'a> PassImage<'a> {
    fn buffer(&self) -> &'a wgpu::Buffer {
        let Self::Buffer { buffer, .. } = self;
        buffer
    }

    fn layout(&self) -> Layout {
        let Self::Buffer { layout, .. } = self;
        *layout
    }

    fn check(&self, name: &str, size: [u32; 2], limits: &wgpu::Limits) -> Result<()> {
        let Self::Buffer { buffer, layout } = self;
        let [width, height] = size;
        if layout.pixel_stride < 3 || layout.row_stride / width < layout.pixel_stride {
            return Err(Error::Image(format!(
                "the pixels of {name} overlap: {layout:?} for rows of {width} pixels of three \
                 elements each"
            )));
        }
        let (needed, found) = (layout.elements(width, height) * 4, buffer.size());
        if found < needed {
            return Err(Error::Image(format!(
                "{name} of {width}×{height} pixels needs a buffer of {needed} bytes, found {found}"
            )));
        }
        let most = limits.max_storage_buffer_binding_size;
        if found > most {
            return Err(Error::Image(format!(
                "the buffer of {name} has {found} bytes, but the device was created to bind at \
                 most {most}; ask the adapter for more (see required_limits)"
            )));
        }
        if !buffer.usage().contains(wgpu::BufferUsages::STORAGE) {
            return Err(Error::Image(format!(
                "the buffer of {name} was created without the usage STORAGE; add it"
            )));
        }
        Ok(())
    }
}

impl PassDescriptor<'_> {
    fn inputs(&self) -> Inputs {
        Inputs { albedo: self.albedo.is_some(), normal: self.normal.is_some() }
    }

    fn check(&self, limits: &wgpu::Limits) -> Result<()> {
        check_input_scale(self.input_scale)?;
        let sides = 1..=MAX_SIDE;
        if !sides.contains(&self.width) || !sides.contains(&self.height) {
            return Err(Error::Image(format!(
                "{}×{}: both sides must be at least 1 and at most {MAX_SIDE}",
                self.width, self.height
            )));
        }
        let images = [("albedo", self.albedo), ("normal", self.normal)];
        let present = images.into_iter().filter_map(|(name, image)| Some((name, image?)));
        for (name, image) in present.chain([("color", self.color), ("output", self.output)]) {
            image.check(name, [self.width, self.height], limits)?;
            if name != "output" && image.buffer() == self.output.buffer() {
                return Err(Error::Image(format!(
                    "output and {name} are the same buffer; a tile would read what another wrote"
                )));
            }
        }
        Ok(())
    }
}

/// All tiles of a plan, one every [`TILE_STRIDE`] bytes.
fn tile_bytes(d: &PassDescriptor<'_>, plan: &TilePlan) -> Vec<u8> {
    let mut bytes = vec![0; plan.tiles.len() * TILE_STRIDE];
    for (slot, placed) in bytes.chunks_exact_mut(TILE_STRIDE).zip(&plan.tiles) {
        let tile = Tile {
            image_size: [d.width, d.height],
            origin: placed.origin,
            begin: placed.stores.begin,
            end: placed.stores.end,
            color: d.color.layout(),
            albedo: d.albedo.map(|image| image.layout()).unwrap_or_default(),
            normal: d.normal.map(|image| image.layout()).unwrap_or_default(),
            output: d.output.layout(),
        };
        slot[..size_of::<Tile>()].copy_from_slice(bytemuck::bytes_of(&tile));
    }
    bytes
}

/// A uniform buffer.
fn uniform(device: &wgpu::Device, contents: &[u8]) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("uniform"),
        contents,
        usage: wgpu::BufferUsages::UNIFORM,
    })
}

/// The buffer of the input scale.
fn scale_buffer(device: &wgpu::Device, value: f32) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("input_scale"),
        contents: bytemuck::bytes_of(&value),
        usage: wgpu::BufferUsages::STORAGE,
    })
}
