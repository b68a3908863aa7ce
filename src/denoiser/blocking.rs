//! The blocking call: images on the CPU, tile by tile through the GPU.

use crate::denoiser::Denoiser;
use crate::denoiser::frame::Frame;
use crate::denoiser::tile_buffers::TileBuffers;
use crate::error::{Error, Result};
use crate::gpu::wait::wait;
use crate::image::Image;
use crate::network::compile::CompiledNetwork;
use crate::ops::autoexposure::{Band, autoexposure};
use crate::ops::tile::{Layout, Tile};
use crate::plan::tiles::{Placed, Rect, TilePlan};

impl Denoiser {
    /// Denoises a frame and waits for the result, which is linear and in the colour's exposure.
    /// Images that the weights were not trained with are ignored. After each tile `progress`
    /// is told how many are done, of how many.
    ///
    /// Where the adapter runs out of memory, tiles get half the pixels, for this frame, which begins
    /// anew, and all that follow, and [`notices`](Self::notices) says so: the result is the same.
    ///
    /// # Errors
    /// If the images do not fit together, the memory does not suffice for the smallest tile, or the
    /// device fails: is lost, or takes longer than [`Options::timeout`](crate::Options::timeout).
    pub fn denoise(
        &self,
        frame: &Frame<'_>,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Result<Image> {
        self.denoise_by(frame, progress, &mut |window| window.run())
    }

    /// The same, with the network run on each tile's window by `run`.
    pub(crate) fn denoise_by(
        &self,
        frame: &Frame<'_>,
        progress: &mut dyn FnMut(usize, usize),
        run: &mut dyn FnMut(&TileBuffers<'_>) -> Result<()>,
    ) -> Result<Image> {
        let frame = self.readable(frame)?;
        let (width, height) = frame.color.size();
        let inputs = frame.inputs();
        let mut plan = self.tile_plan(width, height, inputs)?;
        let model = self.model(inputs)?;
        let mut result = Image::filled(width, height, [0.0; 3])?;
        while let Err(error) = self.run_plan(&frame, &plan, &model, &mut result, progress, run) {
            let Error::Memory(_) = error else { return Err(error) };
            // What failed is freed first.
            self.context.catch(|| wait(&self.context))?;
            plan = self.halved(&plan, [width, height], inputs)?;
        }
        Ok(result)
    }

    /// The frame without the images that the weights cannot read.
    pub(crate) fn readable<'a>(&self, frame: &Frame<'a>) -> Result<Frame<'a>> {
        frame.check()?;
        let inputs = frame.inputs().intersection(self.weights().metadata().inputs);
        Ok(Frame {
            albedo: frame.albedo.filter(|_| inputs.albedo),
            normal: frame.normal.filter(|_| inputs.normal),
            ..*frame
        })
    }

    /// Fills the result tile by tile.
    fn run_plan(
        &self,
        frame: &Frame<'_>,
        plan: &TilePlan,
        model: &CompiledNetwork,
        result: &mut Image,
        progress: &mut dyn FnMut(usize, usize),
        run: &mut dyn FnMut(&TileBuffers<'_>) -> Result<()>,
    ) -> Result<()> {
        let (context, width, skip) = (&self.context, result.width(), self.options.skip_clean);
        let window = context
            .catch(|| Ok(TileBuffers::new(context, model, plan, width, frame.inputs(), skip)))?;
        context.catch(|| self.expose(frame, &window))?;
        for (done, placed) in (1..).zip(&plan.tiles) {
            context.catch(|| {
                let tile = self.upload(frame, placed, plan.tile, &window)?;
                run(&window)?;
                window.download(&tile, result, placed)
            })?;
            progress(done, plan.tiles.len());
        }
        Ok(())
    }

    /// What colour is multiplied by, unless it is measured.
    pub(crate) fn known_scale(&self, frame: &Frame<'_>) -> Option<f32> {
        let measured = self.weights().metadata().transfer_function.is_hdr();
        frame.input_scale.or((!measured).then_some(1.0))
    }

    /// Leaves the input scale in the window's buffer.
    fn expose(&self, frame: &Frame<'_>, window: &TileBuffers<'_>) -> Result<()> {
        if let Some(scale) = self.known_scale(frame) {
            self.context.queue.write_buffer(&window.input_scale, 0, bytemuck::bytes_of(&scale));
            return Ok(());
        }
        let (width, height) = frame.color.size();
        let bands = Band::split(width, height, window.rows_of(width));
        let [color, scale] = [&window.color, &window.input_scale];
        let calls = autoexposure(&self.context, &bands[0], &window.band, color.into(), scale);
        for band in &bands {
            let rows = band.rows();
            let rect = Rect { begin: [0, rows.start], end: [width, rows.end] };
            window.upload(&window.color, frame.color, &rect)?;
            self.context.queue.write_buffer(&window.band, 0, bytemuck::bytes_of(band));
            window.submit(|pass| calls.bins.record(pass));
            wait(&self.context)?;
        }
        window.submit(|pass| calls.reduce.record(pass));
        Ok(())
    }

    /// Fills the window with a tile of the frame.
    fn upload(
        &self,
        frame: &Frame<'_>,
        placed: &Placed,
        tile: [u32; 2],
        window: &TileBuffers<'_>,
    ) -> Result<Tile> {
        let (width, height) = frame.color.size();
        let rect = read_rect(placed, tile, [width, height]);
        for (buffer, image) in window.images(frame) {
            window.upload(buffer, image, &rect)?;
        }
        let tile = tile_in_window(placed, &rect);
        self.context.queue.write_buffer(&window.tile, 0, bytemuck::bytes_of(&tile));
        Ok(tile)
    }
}

/// The part of a tile that is in the image.
fn read_rect(placed: &Placed, tile: [u32; 2], size: [u32; 2]) -> Rect {
    let end = std::array::from_fn(|axis| (placed.origin[axis] + tile[axis]).min(size[axis]));
    Rect { begin: placed.origin, end }
}

/// The tile as the kernels see it when only `rect` of the image is bound.
fn tile_in_window(placed: &Placed, rect: &Rect) -> Tile {
    let image_size = rect.size();
    let relative = |p: [u32; 2]| [p[0] - rect.begin[0], p[1] - rect.begin[1]];
    let layout = Layout::packed(image_size[0]);
    Tile {
        image_size,
        origin: [0, 0],
        begin: relative(placed.stores.begin),
        end: relative(placed.stores.end),
        color: layout,
        albedo: layout,
        normal: layout,
        output: layout,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gpu, Inputs, Options, Weights};

    fn denoiser() -> Denoiser {
        let Gpu { device, queue, .. } = Gpu::open(None).expect("the tests need an adapter");
        let weights = include_bytes!("../../tests/fixtures/unet_tiny.safetensors");
        let weights = Weights::from_bytes(weights).expect("the fixture follows the format");
        Denoiser::new(&device, &queue, &weights, &Options::default()).expect("the device works")
    }

    /// Denoises where tiles of more than `most` pixels find no memory, half-way through.
    fn denoise(denoiser: &Denoiser, most: u32) -> Result<Image> {
        let pixel = |i: u32| [0, 1, 2].map(|c| ((i * 7919 + c * 31) % 256) as f32 / 256.0);
        let color = Image::new(300, 200, (0..300 * 200).map(pixel).collect())?;
        let frame = Frame { color: &color, albedo: None, normal: None, input_scale: None };
        denoiser.denoise_by(&frame, &mut |_, _| {}, &mut |window| {
            window.run()?;
            if window.rows_of(1) > most { Err(Error::Memory("none".into())) } else { Ok(()) }
        })
    }

    #[test]
    fn tiles_are_halved_until_they_fit_and_stay_so() {
        let denoiser = denoiser();
        let whole = denoise(&denoiser, u32::MAX).unwrap();
        assert_eq!(denoiser.notices(), [""; 0]);
        assert_eq!(denoise(&denoiser, 20_000).unwrap(), whole);
        let notices = denoiser.notices();
        assert!(
            notices.len() == 2 && notices[0].contains("tiles of 304×208 pixels"),
            "{notices:?}"
        );
        let [width, height] = denoiser.tile_plan(300, 200, Inputs::default()).unwrap().tile;
        assert!(width * height <= 20_000, "{width}×{height}");
        assert_eq!(denoise(&denoiser, 20_000).unwrap(), whole);
        assert_eq!(denoiser.notices(), [""; 0]);
    }

    #[test]
    fn the_smallest_tile_is_the_end_and_the_next_frame_is_tried_again() {
        let denoiser = denoiser();
        let error = denoise(&denoiser, 0).unwrap_err().to_string();
        let model = denoiser.model(Inputs::default()).unwrap();
        let side = 2 * model.halo + model.alignment;
        assert!(error.contains(&format!("even with tiles of {side}×{side} pixels")), "{error}");
        assert!(denoiser.notices().len() > 2);
        denoise(&denoiser, u32::MAX).unwrap();
    }
}
