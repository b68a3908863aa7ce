//! Cuts an image into tiles within the memory budget and the device's limits.

use std::sync::atomic::Ordering;

use super::Denoiser;
use super::frame::{Contents, Frame};
use super::tile_buffers::PIXEL_BYTES;
use crate::error::{Error, Result};
use crate::model::macs::largest_layer_macs_per_pixel;
use crate::network::compile::CompiledNetwork;
use crate::ops::autoexposure::BIN;
use crate::plan::memory::Footprint;
use crate::plan::tiles::{Constraints, MAX_SIDE, TilePlan};

/// Bytes per pixel that the blocking call needs for an image: once on the GPU, and once more while
/// a copy waits to be uploaded or read.
const IMAGE_BYTES: u64 = 2 * PIXEL_BYTES;

/// The blocking call's memory for images. The color buffer must also hold the narrowest band of
/// rows for the exposure measurement.
fn images(width: u32, contents: Contents) -> Footprint {
    let Contents { inputs, layers } = contents;
    let count = 2 + [inputs.albedo, inputs.normal, layers].into_iter().map(u64::from).sum::<u64>();
    Footprint {
        per_pixel: count * IMAGE_BYTES,
        buffer_per_pixel: IMAGE_BYTES,
        buffer_least: u64::from(BIN) * u64::from(width) * IMAGE_BYTES,
        picture: 0,
    }
}

/// The largest buffer that the device creates and binds.
fn bindable(limits: &wgpu::Limits) -> u64 {
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
}

impl Denoiser {
    /// How the blocking call would tile an image of this size.
    ///
    /// # Errors
    /// Fails if even the smallest tile exceeds the budget or the device's limits, if a side is
    /// longer than 65536 pixels, or if the weights were not trained with an input.
    pub fn tile_plan(
        &self,
        width: u32,
        height: u32,
        contents: impl Into<Contents>,
    ) -> Result<TilePlan> {
        let contents = contents.into();
        let network = self.network(contents.inputs)?;
        self.plan([width, height], &network, images(width, contents), contents.layers)
    }

    /// GPU memory in bytes for the tensors and images of [`tile_plan`](Self::tile_plan). The
    /// weights add a few megabytes.
    ///
    /// # Errors
    /// Fails like [`tile_plan`](Self::tile_plan).
    pub fn memory_bytes(
        &self,
        width: u32,
        height: u32,
        contents: impl Into<Contents>,
    ) -> Result<u64> {
        let contents = contents.into();
        let [w, h] = self.tile_plan(width, height, contents)?.tile;
        let texel = self.options.precision.texel_bytes();
        let tensors = self.network(contents.inputs)?.bytes([w, h], texel, contents.layers);
        Ok(tensors + images(width, contents).bytes(u64::from(w) * u64::from(h)))
    }

    /// How the blocking call cuts this frame into tiles, and the GPU memory in bytes they take.
    /// Images that the weights do not read do not count.
    ///
    /// # Errors
    /// Fails like [`tile_plan`](Self::tile_plan), and if the frame's images do not match.
    pub fn frame_plan(&self, frame: &Frame<'_>) -> Result<(TilePlan, u64)> {
        let (width, height) = self.size_with_columns(frame)?;
        let contents = self.readable(frame)?.contents();
        let plan = self.tile_plan(width, height, contents)?;
        Ok((plan, self.memory_bytes(width, height, contents)?))
    }

    /// The tile plan within the budget, with `images` allocated next to the tensors. `layers` adds
    /// room for further layers.
    pub(crate) fn plan(
        &self,
        size: [u32; 2],
        network: &CompiledNetwork,
        images: Footprint,
        layers: bool,
    ) -> Result<TilePlan> {
        let [width, height] = size;
        if width.max(height) > MAX_SIDE {
            return Err(Error::Image(format!(
                "{width}×{height} is too large: a side may have at most {MAX_SIDE} pixels"
            )));
        }
        let device = &self.context.device;
        let limits = device.limits();
        let alignment = network.alignment;
        let texel = self.options.precision.texel_bytes();
        let block = network.bytes([alignment; 2], texel, layers);
        let tensors = block.div_ceil(u64::from(alignment).pow(2));
        let footprint = Footprint { per_pixel: images.per_pixel + tensors, ..images };
        let constraints = Constraints {
            alignment,
            halo: network.halo,
            max_side: self.options.tile.unwrap_or(u32::MAX).min(limits.max_texture_dimension_2d),
            max_pixels: footprint
                .most_pixels(self.options.memory_bytes)
                .min(bindable(&limits) / PIXEL_BYTES),
        };
        // A CPU driver has no display or watchdog to keep waiting, so smaller tiles would only add
        // cost.
        let constraints = match device.adapter_info().device_type {
            wgpu::DeviceType::Cpu => constraints,
            _ => constraints.with_short_dispatches(largest_layer_macs_per_pixel(&network.body)),
        };
        // A limit learned from an image of another shape may be below every tile of this one.
        let max_pixels = constraints.max_pixels.min(self.most_pixels.load(Ordering::Relaxed));
        TilePlan::new(size, &Constraints { max_pixels, ..constraints })
            .or_else(|| TilePlan::new(size, &constraints))
            .ok_or_else(|| self.too_small(size, &constraints, &footprint))
    }

    /// The plan to use after the adapter ran out of memory with `plan`: tiles of at most half the
    /// pixels or, if none is that small, of fewer pixels than before.
    /// [`tile_plan`](Self::tile_plan) returns it from now on.
    ///
    /// # Errors
    /// Fails if no tile is smaller.
    pub(crate) fn halved(&self, plan: &TilePlan, size: [u32; 2], of: Contents) -> Result<TilePlan> {
        let [width, height] = plan.tile;
        let pixels = u64::from(width) * u64::from(height);
        let is_smaller =
            |plan: &TilePlan| plan.tile.map(u64::from).iter().product::<u64>() < pixels;
        let within = |most| {
            self.most_pixels.store(most, Ordering::Relaxed);
            self.tile_plan(size[0], size[1], of).ok().filter(is_smaller)
        };
        let Some(smaller) = [pixels / 2, pixels - 1].into_iter().find_map(within) else {
            self.most_pixels.store(pixels, Ordering::Relaxed);
            return Err(Error::OutOfMemory(format!(
                "the adapter is out of memory even with tiles of {width}×{height} pixels, the \
                 smallest for these weights; free some, or use cheaper weights, 16-bit tensors or \
                 another adapter"
            )));
        };
        let [w, h] = smaller.tile;
        let notice = format!(
            "the adapter ran out of memory with tiles of {width}×{height} pixels; continuing with \
             {w}×{h}, which takes longer and gives the same result"
        );
        self.notices.lock().expect("no thread panicked here").push(notice);
        Ok(smaller)
    }

    /// The error for a smallest tile that does not fit: what it needs and which limit it exceeds.
    fn too_small(&self, size: [u32; 2], constraints: &Constraints, footprint: &Footprint) -> Error {
        let Constraints { alignment, halo, max_side, .. } = *constraints;
        let smallest = |side: u32| side.next_multiple_of(alignment).min(2 * halo + alignment);
        let [width, height] = size.map(smallest);
        let bytes = footprint.bytes(u64::from(width) * u64::from(height));
        let limit = if width.max(height) > max_side {
            format!("tiles are limited to {max_side} pixels a side")
        } else if bytes > self.options.memory_bytes {
            format!("the memory budget is {} MiB", self.options.memory_bytes >> 20)
        } else {
            let bindable = bindable(&self.context.device.limits());
            format!("the device was created to bind at most {} MiB at once", bindable >> 20)
        };
        let history = match footprint.picture.div_ceil(1 << 20) {
            0 => String::new(),
            size => format!(", {size} of them for the last frames"),
        };
        Error::Budget(format!(
            "a tile needs at least {width}×{height} pixels and {} MiB{history}, but {limit}; raise \
             that limit",
            bytes.div_ceil(1 << 20)
        ))
    }
}

#[cfg(test)]
#[path = "tiling_test.rs"]
mod tests;
