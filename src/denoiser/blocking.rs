//! The blocking call: images on the CPU, tile by tile through the GPU.

use std::time::{Duration, Instant};

use crate::denoiser::Denoiser;
use crate::denoiser::alpha::with_alpha;
use crate::denoiser::frame::{Denoised, Frame};
use crate::denoiser::panorama::Wrapped;
use crate::denoiser::progress::{FinishedTile, Progress};
use crate::denoiser::tile_buffers::{TileBuffers, TileShape};
use crate::error::{Error, Result};
use crate::gpu::wait::wait;
use crate::image::Image;
use crate::image::Rect;
use crate::network::compile::CompiledNetwork;
use crate::ops::autoexposure::{Band, autoexposure};
use crate::ops::tile::{Layout, Tile};
use crate::plan::tiles::{PlacedTile, TilePlan};

/// Runs the network on a tile's buffers. The second argument receives the number of finished calls;
/// its error ends the run.
pub(crate) type RunTile<'r> =
    &'r mut dyn FnMut(&TileBuffers, &mut dyn FnMut(usize) -> Result<()>) -> Result<()>;

/// Receives each step.
type OnProgress<'p> = &'p mut dyn FnMut(Progress<'_>);

impl Denoiser {
    /// Denoises a frame's color and blocks until the result is ready: linear color at the input's
    /// exposure. Images that the weights were not trained with are ignored, and so are the frame's
    /// layers and alpha.
    ///
    /// If the adapter runs out of memory, the frame starts over with tiles of at most half the
    /// pixels, and later frames keep that size. The result does not change;
    /// [`take_notices`](Self::take_notices) reports it.
    ///
    /// # Errors
    /// Fails if the images do not match, if even the smallest tile does not fit in memory, or if
    /// the device is lost, fails, or takes longer than
    /// [`Options::timeout`](crate::Options::timeout).
    pub fn denoise(&self, frame: &Frame<'_>) -> Result<Image> {
        self.denoise_with_progress(frame, &mut |_, _| {})
    }

    /// [`denoise`](Self::denoise) with progress: calls `progress(done, total)` as the network's
    /// calls finish. Both count the calls of all tiles and are equal at the end. If tiles shrink,
    /// the count starts over.
    ///
    /// # Errors
    /// Fails like [`denoise`](Self::denoise).
    pub fn denoise_with_progress(
        &self,
        frame: &Frame<'_>,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Result<Image> {
        let frame = frame.layers(&[]).alpha(None);
        let mut progress = |step: Progress<'_>| progress(step.done, step.total);
        Ok(self.denoise_by(&frame, &mut progress, &mut |tile, done| tile.run(done))?.color)
    }

    /// [`denoise_with_progress`](Self::denoise_with_progress) that also filters the frame's layers
    /// with the color's kernels: each pixel of a layer is a weighted mean of the same pixels, with
    /// the same weights, as in the color. The result is linear in the layers, so layers that add up
    /// to the noisy color add up to the denoised one, within a rounding error of 10⁻⁵ of the
    /// brightest pixels around. Weights that demodulate multiply the layers' means, and this bound,
    /// by the color's texture, which is at most 21.
    ///
    /// Alpha is filtered like a layer, which keeps premultiplied edges consistent over any
    /// background. It is not light, so it is not multiplied by the texture. Where alpha is constant
    /// within three pixels, it keeps its value and the color is scaled to match; where alpha and
    /// color are 0, the result is 0.
    ///
    /// Bad pixels of a layer are filled. Where the color has bad pixels or outliers, the layers are
    /// repaired with it. Where the color is constant and the network is skipped, layers keep their
    /// pixels.
    ///
    /// `progress` also receives each finished tile of the color on the GPU, and all of them again
    /// if tiles shrink.
    ///
    /// # Errors
    /// Fails like [`denoise`](Self::denoise), and if there are layers but the weights predict color
    /// rather than a kernel pyramid.
    pub fn denoise_layers(&self, frame: &Frame<'_>, progress: OnProgress<'_>) -> Result<Denoised> {
        frame.check()?;
        if frame.contents().layers {
            self.check_layers()?;
        }
        let mut denoise =
            |frame: &Frame<'_>| self.denoise_by(frame, progress, &mut |tile, done| tile.run(done));
        match frame.alpha {
            Some(alpha) => with_alpha(&frame.alpha(None), alpha, denoise),
            None => denoise(frame),
        }
    }

    /// Rejects weights that cannot denoise further layers.
    pub(crate) fn check_layers(&self) -> Result<()> {
        if self.weights().network().has_pyramid() {
            return Ok(());
        }
        Err(Error::weights(
            "they predict color and not a kernel pyramid, so they cannot denoise further layers \
             along with it; use the built-in weights",
        ))
    }

    /// [`denoise`](Self::denoise), with `run` running the network on each tile's buffers.
    pub(crate) fn denoise_by(
        &self,
        frame: &Frame<'_>,
        progress: OnProgress<'_>,
        run: RunTile<'_>,
    ) -> Result<Denoised> {
        let frame = self.readable(frame)?;
        if frame.panorama {
            let wrapped = Wrapped::new(self, &frame)?;
            let layers = wrapped.layers();
            let flat = wrapped.frame().layers(&layers).stop(frame.stop);
            let flat = Frame { ends_in_alpha: frame.ends_in_alpha, ..flat };
            let mut progress = |step: Progress<'_>| progress(wrapped.unwrap_step(step));
            return wrapped.unwrap(&self.denoise_flat(&flat, frame.color, &mut progress, run)?);
        }
        self.denoise_flat(&frame, frame.color, progress, run)
    }

    /// Denoises a frame whose edges do not touch, with the exposure of `measured`.
    fn denoise_flat(
        &self,
        frame: &Frame<'_>,
        measured: &Image,
        progress: OnProgress<'_>,
        run: RunTile<'_>,
    ) -> Result<Denoised> {
        let (width, height) = frame.color.size();
        let contents = frame.contents();
        let mut plan = self.tile_plan(width, height, contents)?;
        let network = self.network(contents.inputs)?;
        let empty = || Image::filled(width, height, [0.0; 3]);
        let layers = frame.layers.iter().map(|_| empty()).collect::<Result<_>>()?;
        let mut result = Denoised { color: empty()?, layers, alpha: None };
        let images = (frame, measured);
        while let Err(error) = self.run_plan(images, &plan, &network, &mut result, progress, run) {
            let Error::OutOfMemory(_) = error else { return Err(error) };
            // Waiting frees what the failed run allocated.
            self.context.catch(|| wait(&self.context))?;
            plan = self.halved(&plan, [width, height], contents)?;
        }
        Ok(result)
    }

    /// The frame reduced to the images that the weights read.
    pub(crate) fn readable<'a>(&self, frame: &Frame<'a>) -> Result<Frame<'a>> {
        frame.check()?;
        let inputs = frame.inputs().intersection(self.weights().metadata().inputs);
        Ok(frame
            .albedo(frame.albedo.filter(|_| inputs.albedo))
            .normal(frame.normal.filter(|_| inputs.normal)))
    }

    /// Fills the result tile by tile.
    fn run_plan(
        &self,
        (frame, measured): (&Frame<'_>, &Image),
        plan: &TilePlan,
        network: &CompiledNetwork,
        result: &mut Denoised,
        progress: OnProgress<'_>,
        run: RunTile<'_>,
    ) -> Result<()> {
        let (tile, image_width) = (plan.tile, frame.color.width());
        let shape = TileShape { tile, image_width, contents: frame.contents() };
        let buffers = self.tile_buffers(network, shape)?;
        let finished = self.run_tiles((frame, measured), plan, &buffers, result, progress, run);
        // Any other failure may be for lack of memory.
        if matches!(finished, Ok(()) | Err(Error::Stopped)) {
            self.keep(buffers);
        }
        finished
    }

    /// Fills the result with these buffers. Error scopes do not span `progress`, whose caller may
    /// use the device as well.
    fn run_tiles(
        &self,
        (frame, measured): (&Frame<'_>, &Image),
        plan: &TilePlan,
        buffers: &TileBuffers,
        result: &mut Denoised,
        progress: OnProgress<'_>,
        run: RunTile<'_>,
    ) -> Result<()> {
        let context = &self.context;
        self.expose(frame, measured, buffers)?;
        let calls = buffers.calls().len() + frame.layers.len();
        let total = calls * plan.tiles.len();
        let mut network_time = Duration::ZERO;
        for (i, placed) in plan.tiles.iter().enumerate() {
            frame.check_stop()?;
            let mut report = |done, network_time, tile| {
                progress(Progress { done: i * calls + done, total, network_time, tile });
                frame.check_stop()
            };
            let (rect, tile) = context.catch(|| self.upload(frame, placed, plan.tile, buffers))?;
            let (before, begin) = (network_time, Instant::now());
            run(buffers, &mut |done| report(done, before + begin.elapsed(), None))?;
            network_time = before + begin.elapsed();
            let finished = FinishedTile::new(&buffers.output, &tile, placed);
            report(buffers.calls().len(), network_time, Some(finished))?;
            context.catch(|| buffers.download(&tile, &mut result.color, placed))?;
            let mut done = buffers.calls().len();
            for ((image, light), layer) in frame.kinds().zip(&mut result.layers) {
                context.catch(|| {
                    buffers.run_layer(image, light, &rect)?;
                    buffers.download(&tile, layer, placed)
                })?;
                done += 1;
                report(done, network_time, None)?;
            }
        }
        Ok(())
    }

    /// The input scale, or `None` if it has to be measured.
    pub(crate) fn known_scale(&self, frame: &Frame<'_>) -> Option<f32> {
        let measured = self.weights().metadata().transfer_function.is_hdr();
        frame.input_scale.or((!measured).then_some(1.0))
    }

    /// Stores the frame's input scale, or the one measured from `measured`, in the tile's buffers.
    fn expose(&self, frame: &Frame<'_>, measured: &Image, buffers: &TileBuffers) -> Result<()> {
        if let Some(scale) = self.known_scale(frame) {
            let bytes = bytemuck::bytes_of(&scale);
            return self.context.catch(|| {
                self.context.queue.write_buffer(&buffers.input_scale, 0, bytes);
                Ok(())
            });
        }
        let context = &self.context;
        let (width, height) = measured.size();
        let bands = Band::split(width, height, buffers.rows_of(width));
        let [color, scale] = [&buffers.color, &buffers.input_scale];
        let compile = || autoexposure(context, &bands[0], &buffers.band, color.into(), scale);
        let calls = context.catch(|| Ok(compile()))?;
        for band in &bands {
            frame.check_stop()?;
            let rows = band.rows();
            let rect = Rect { begin: [0, rows.start], end: [width, rows.end] };
            context.catch(|| {
                buffers.upload(&buffers.color, measured, &rect)?;
                context.queue.write_buffer(&buffers.band, 0, bytemuck::bytes_of(band));
                buffers.submit(|pass| calls.bins.record(pass));
                wait(context)
            })?;
        }
        context.catch(|| {
            buffers.submit(|pass| calls.reduce.record(pass));
            Ok(())
        })
    }

    /// Uploads one tile of the frame; returns the uploaded pixels and the tile in them.
    fn upload(
        &self,
        frame: &Frame<'_>,
        placed: &PlacedTile,
        tile: [u32; 2],
        buffers: &TileBuffers,
    ) -> Result<(Rect, Tile)> {
        let (width, height) = frame.color.size();
        let rect = read_rect(placed, tile, [width, height]);
        for (buffer, image) in buffers.images(frame) {
            buffers.upload(buffer, image, &rect)?;
        }
        let tile = tile_in_window(placed, &rect);
        self.context.queue.write_buffer(&buffers.tile, 0, bytemuck::bytes_of(&tile));
        Ok((rect, tile))
    }
}

/// The part of a tile that lies inside the image.
fn read_rect(placed: &PlacedTile, tile: [u32; 2], size: [u32; 2]) -> Rect {
    let end = std::array::from_fn(|axis| (placed.origin[axis] + tile[axis]).min(size[axis]));
    Rect { begin: placed.origin, end }
}

/// The tile in the coordinates of `rect`, the only part of the image that is bound.
fn tile_in_window(placed: &PlacedTile, rect: &Rect) -> Tile {
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
        beauty: layout,
        ..Tile::default()
    }
}

#[cfg(test)]
#[path = "blocking_test.rs"]
mod tests;
