//! GPU buffers for the part of an image that one tile reads and writes.

use std::sync::Arc;

use crate::denoiser::frame::{Contents, Frame};
use crate::error::{Error, Result};
use crate::gpu::kernel::Context;
use crate::gpu::wait::{read, wait_for};
use crate::image::Image;
use crate::image::Rect;
use crate::network::bind::{Bound, BoundLayer, TileCalls};
use crate::network::call::Call;
use crate::network::compile::CompiledNetwork;
use crate::ops::autoexposure::{BIN, Band};
use crate::ops::input_process::Sources;
use crate::ops::tile::Tile;
use crate::plan::tiles::PlacedTile;

/// Bytes per pixel of an image.
pub(super) const PIXEL_BYTES: u64 = size_of::<[f32; 3]>() as u64;

/// Each tile is bound once for layers of light and once for other layers, on the same buffers.
const LIGHT: [bool; 2] = [true, false];

/// What determines the size and number of a tile's resources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TileShape {
    /// Width and height in pixels.
    pub(crate) tile: [u32; 2],
    /// Pixels per row of the whole image, for the bands that measure its exposure.
    pub(crate) image_width: u32,
    /// The images to denoise.
    pub(crate) contents: Contents,
}

impl TileShape {
    fn image_bytes(&self) -> u64 {
        let [width, height] = self.tile.map(u64::from);
        width * height * PIXEL_BYTES
    }

    /// Bytes of the color, which holds a band of the image or a tile of it.
    fn color_bytes(&self) -> u64 {
        let band = u64::from(BIN) * u64::from(self.image_width) * PIXEL_BYTES;
        self.image_bytes().max(band)
    }
}

/// The buffers of a tile and the kernel calls on them.
#[derive(Debug)]
pub(crate) struct TileBuffers {
    context: Arc<Context>,
    pub(crate) shape: TileShape,
    calls: TileCalls,
    pub(crate) color: wgpu::Buffer,
    albedo: Option<wgpu::Buffer>,
    normal: Option<wgpu::Buffer>,
    /// One layer at a time.
    layer: Option<wgpu::Buffer>,
    pub(crate) output: wgpu::Buffer,
    readback: wgpu::Buffer,
    pub(crate) input_scale: wgpu::Buffer,
    /// Uniform buffer holding one [`Tile`].
    pub(crate) tile: wgpu::Buffer,
    /// Uniform buffer holding one [`Band`].
    pub(crate) band: wgpu::Buffer,
}

impl TileBuffers {
    /// Buffers for tiles of this shape, bound to the network's kernels.
    pub(crate) fn new(
        context: &Arc<Context>,
        network: &CompiledNetwork,
        shape: TileShape,
        skip_clean: bool,
    ) -> Self {
        use wgpu::BufferUsages as Usage;
        let create = |label, size, usage| {
            let descriptor = wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            };
            context.device.create_buffer(&descriptor)
        };
        let TileShape { contents, .. } = shape;
        let tile_bytes = shape.image_bytes();
        let image = |label, bytes| create(label, bytes, Usage::STORAGE | Usage::COPY_DST);
        let uniform = |label, bytes| create(label, bytes as u64, Usage::UNIFORM | Usage::COPY_DST);
        let color = image("color", shape.color_bytes());
        let albedo = contents.inputs.albedo.then(|| image("albedo", tile_bytes));
        let normal = contents.inputs.normal.then(|| image("normal", tile_bytes));
        let layer = contents.layers.then(|| image("layer", tile_bytes));
        let output = create("output", tile_bytes, Usage::STORAGE | Usage::COPY_SRC);
        let readback = create("readback", tile_bytes, Usage::MAP_READ | Usage::COPY_DST);
        let input_scale = image("input_scale", 4);
        let tile = uniform("tile", size_of::<Tile>());
        let band = uniform("band", size_of::<Band>());
        let sources = Sources {
            tiles: &tile,
            color: (&color).into(),
            albedo: albedo.as_ref().map(Into::into),
            normal: normal.as_ref().map(Into::into),
            unorm_normal: false,
            input_scale: &input_scale,
            encoding: network.encoding,
        };
        // New buffers are zero: no noisy color is blended in.
        let blend = uniform("blend", size_of::<f32>());
        let (output_image, blend) = ((&output).into(), &blend);
        let bind = |layer| {
            let (tiles, output) = (&tile, output_image);
            LIGHT.map(|light| BoundLayer { tiles, color: layer, output, light })
        };
        let layers: Vec<_> = layer.iter().flat_map(|layer| bind(layer.into())).collect();
        let bound = Bound {
            tile: shape.tile,
            sources,
            output: output_image,
            blend,
            skip_clean,
            layers: &layers,
        };
        let calls = TileCalls::new(context, network, &bound);
        Self {
            context: context.clone(),
            shape,
            calls,
            color,
            albedo,
            normal,
            layer,
            output,
            readback,
            input_scale,
            tile,
            band,
        }
    }

    /// Submits the whole network for the uploaded tile in parts and waits for all of them. Each
    /// part has its own timeout. After each part but the last, `progress` receives the number of
    /// finished calls. If it fails, the part that still runs is waited for.
    ///
    /// One part is queued behind the running one, so that the device is never idle and the queue's
    /// other users, such as a window, wait for no more than these two.
    pub(crate) fn run(&self, progress: &mut dyn FnMut(usize) -> Result<()>) -> Result<()> {
        let finish = |part| self.context.catch(|| wait_for(&self.context, part));
        let (mut done, mut running) = (0, None);
        for batch in self.calls.batches() {
            let submit =
                || self.submit(|pass| batch.iter().for_each(|call| call.record_at(pass, 0)));
            let part = self.context.catch(|| Ok(submit()))?;
            if let Some((calls, before)) = running.replace((batch.len(), part)) {
                finish(Some(before))?;
                done += calls;
                if let Err(error) = progress(done) {
                    finish(running.map(|(_, last)| last))?;
                    return Err(error);
                }
            }
        }
        finish(running.map(|(_, last)| last))
    }

    /// Uploads part of a layer and submits its calls, which read the network's tensors for the tile
    /// and overwrite its result.
    pub(crate) fn run_layer(&self, image: &Image, light: bool, rect: &Rect) -> Result<()> {
        let Some(buffer) = &self.layer else { return Ok(()) };
        self.upload(buffer, image, rect)?;
        let calls = self.calls.layers().iter().zip(LIGHT).filter(|(_, is)| *is == light);
        self.submit(|pass| {
            calls.flat_map(|(calls, _)| calls).for_each(|call| call.record_at(pass, 0));
        });
        Ok(())
    }

    /// The number of rows of an image this wide that fit in the color buffer.
    pub(crate) fn rows_of(&self, width: u32) -> u32 {
        let rows = self.color.size() / PIXEL_BYTES / u64::from(width);
        u32::try_from(rows).unwrap_or(u32::MAX)
    }

    /// Pairs the images of a frame with their buffers.
    pub(crate) fn images<'b>(
        &'b self,
        frame: &Frame<'b>,
    ) -> impl Iterator<Item = (&'b wgpu::Buffer, &'b Image)> {
        let auxiliary =
            [(self.albedo.as_ref(), frame.albedo), (self.normal.as_ref(), frame.normal)];
        let present = auxiliary.into_iter().filter_map(|(buffer, image)| buffer.zip(image));
        std::iter::once((&self.color, frame.color)).chain(present)
    }

    /// Uploads part of an image, packed, through a buffer created here. `Queue::write_buffer` would
    /// create one itself, and if that fails for lack of memory, wgpu loses the device.
    pub(crate) fn upload(&self, buffer: &wgpu::Buffer, image: &Image, rect: &Rect) -> Result<()> {
        let [width, height] = rect.size().map(u64::from);
        let device = &self.context.device;
        let staging = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("staging"),
            size: width * height * PIXEL_BYTES,
            usage: wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: true,
        });
        let refused = |error| Error::device("the upload failed", error);
        let mut bytes = staging.get_mapped_range_mut(..).map_err(refused)?;
        let columns = rect.begin[0] as usize..rect.end[0] as usize;
        let row_bytes = (width * PIXEL_BYTES) as usize;
        for (i, y) in (rect.begin[1]..rect.end[1]).enumerate() {
            let row = bytemuck::cast_slice(&image.row(y)[columns.clone()]);
            bytes.slice(i * row_bytes..(i + 1) * row_bytes).copy_from_slice(row);
        }
        drop(bytes);
        staging.unmap();
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&staging, 0, buffer, 0, staging.size());
        self.context.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Submits one compute pass.
    pub(crate) fn submit(
        &self,
        record: impl FnOnce(&mut wgpu::ComputePass<'_>),
    ) -> wgpu::SubmissionIndex {
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        record(&mut encoder.begin_compute_pass(&Default::default()));
        self.context.queue.submit([encoder.finish()])
    }

    /// Waits for the tile and copies the pixels it stores into the result.
    pub(crate) fn download(
        &self,
        tile: &Tile,
        result: &mut Image,
        placed: &PlacedTile,
    ) -> Result<()> {
        let [width, height] = tile.image_size.map(u64::from);
        let bytes = width * height * PIXEL_BYTES;
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&self.output, 0, &self.readback, 0, bytes);
        self.context.queue.submit([encoder.finish()]);
        read(&self.context, &self.readback, |window| {
            copy_rows(bytemuck::cast_slice(window), tile, result, placed);
        })
    }

    /// All kernel calls of a tile, in order.
    pub(crate) fn calls(&self) -> &[Call] {
        self.calls.calls()
    }
}

fn copy_rows(window: &[[f32; 3]], tile: &Tile, result: &mut Image, placed: &PlacedTile) {
    let [columns, rows] = placed.stores.size().map(|side| side as usize);
    let result_width = result.width() as usize;
    for row in 0..rows {
        let from =
            (tile.begin[1] as usize + row) * tile.image_size[0] as usize + tile.begin[0] as usize;
        let to = (placed.stores.begin[1] as usize + row) * result_width
            + placed.stores.begin[0] as usize;
        result.pixels_mut()[to..to + columns].copy_from_slice(&window[from..from + columns]);
    }
}
