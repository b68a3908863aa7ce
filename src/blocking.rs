//! The blocking call: images on the CPU, tile by tile through the GPU.

use crate::denoiser::Denoiser;
use crate::error::Result;
use crate::frame::Frame;
use crate::image::Image;
use crate::ops::autoexposure::{Band, autoexposure};
use crate::ops::tile::{Layout, Tile};
use crate::plan::tiles::{Placed, Rect};
use crate::window::{Window, wait};

impl Denoiser {
    /// Denoises a frame and waits for the result, which is linear and in the colour's exposure.
    /// Images that the weights were not trained with are ignored. After each tile `progress`
    /// is told how many are done, of how many.
    ///
    /// # Errors
    /// If the images do not fit together, the memory budget is too small, or the device fails.
    pub fn denoise(
        &self,
        frame: &Frame<'_>,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Result<Image> {
        self.denoise_by(frame, progress, &mut |window| {
            window.run();
            Ok(())
        })
    }

    /// The same, with the network run on each tile's window by `run`.
    pub(crate) fn denoise_by(
        &self,
        frame: &Frame<'_>,
        progress: &mut dyn FnMut(usize, usize),
        run: &mut dyn FnMut(&Window<'_>) -> Result<()>,
    ) -> Result<Image> {
        frame.check()?;
        let inputs = frame.inputs().intersection(self.weights().metadata().inputs);
        let frame = Frame {
            albedo: frame.albedo.filter(|_| inputs.albedo),
            normal: frame.normal.filter(|_| inputs.normal),
            ..*frame
        };
        let (width, height) = frame.color.size();
        let plan = self.tile_plan(width, height, inputs)?;
        let model = self.model(inputs)?;
        let window = self.context.catch(|| {
            Ok(Window::new(&self.context, &model, &plan, width, inputs, self.options.skip_clean))
        })?;
        self.context.catch(|| self.expose(&frame, &window))?;
        let mut result = Image::filled(width, height, [0.0; 3])?;
        for (done, placed) in (1..).zip(&plan.tiles) {
            let tile = || {
                let tile = self.upload(&frame, placed, plan.tile, &window);
                run(&window)?;
                window.download(&tile, &mut result, placed)
            };
            self.context.catch(tile)?;
            progress(done, plan.tiles.len());
        }
        Ok(result)
    }

    /// Leaves the input scale in the window's buffer.
    fn expose(&self, frame: &Frame<'_>, window: &Window<'_>) -> Result<()> {
        let measured = self.weights().metadata().transfer_function.is_hdr();
        if let Some(scale) = frame.input_scale.or((!measured).then_some(1.0)) {
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
            window.upload(&window.color, frame.color, &rect);
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
        window: &Window<'_>,
    ) -> Tile {
        let (width, height) = frame.color.size();
        let rect = read_rect(placed, tile, [width, height]);
        for (buffer, image) in window.images(frame) {
            window.upload(buffer, image, &rect);
        }
        let tile = tile_in_window(placed, &rect);
        self.context.queue.write_buffer(&window.tile, 0, bytemuck::bytes_of(&tile));
        tile
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
