//! Which tiles an image is cut into, under the memory budget and the device's limits.

use std::sync::atomic::Ordering;

use super::Denoiser;
use crate::error::{Error, Result};
use crate::model::Inputs;
use crate::model::macs::largest_layer_macs_per_pixel;
use crate::network::compile::CompiledNetwork;
use crate::ops::autoexposure::BIN;
use crate::plan::memory::Footprint;
use crate::plan::tiles::{Constraints, MAX_SIDE, TilePlan};

/// Bytes of a pixel of an image.
const PIXEL_BYTES: u64 = size_of::<[f32; 3]>() as u64;

/// Bytes per pixel that the blocking call needs for an image: on the GPU, and while a copy of
/// it waits to be uploaded or read.
const IMAGE_BYTES: u64 = 2 * PIXEL_BYTES;

/// What the blocking call needs for images. The colour's buffer also takes the narrowest band of
/// rows in which the exposure is measured.
fn images(width: u32, inputs: Inputs) -> Footprint {
    let count = 2 + u64::from(inputs.albedo) + u64::from(inputs.normal);
    Footprint {
        per_pixel: count * IMAGE_BYTES,
        buffer_per_pixel: IMAGE_BYTES,
        buffer_least: u64::from(BIN) * u64::from(width) * IMAGE_BYTES,
    }
}

impl Denoiser {
    /// How an image of this size would be cut into tiles by the blocking call.
    ///
    /// # Errors
    /// If even the smallest tile does not fit the budget or the device's limits, a side is over
    /// 65536, or the weights were not trained with an input.
    pub fn tile_plan(&self, width: u32, height: u32, inputs: Inputs) -> Result<TilePlan> {
        let network = self.network(inputs)?;
        self.plan([width, height], &network, images(width, inputs))
    }

    /// GPU memory for tensors and images that [`tile_plan`](Self::tile_plan) for the same image
    /// comes to, in bytes. The weights, a few megabytes, come on top.
    ///
    /// # Errors
    /// As for [`tile_plan`](Self::tile_plan).
    pub fn memory_bytes(&self, width: u32, height: u32, inputs: Inputs) -> Result<u64> {
        let [w, h] = self.tile_plan(width, height, inputs)?.tile;
        let tensors = self.network(inputs)?.bytes([w, h], self.options.precision.texel_bytes());
        Ok(tensors + images(width, inputs).bytes(u64::from(w) * u64::from(h)))
    }

    /// The tile plan under the budget, when `images` stand beside the tensors.
    pub(crate) fn plan(
        &self,
        size: [u32; 2],
        network: &CompiledNetwork,
        images: Footprint,
    ) -> Result<TilePlan> {
        let [width, height] = size;
        if width.max(height) > MAX_SIDE {
            return Err(Error::Image(format!(
                "{width}×{height}: sides of at most {MAX_SIDE} pixels are accepted"
            )));
        }
        let device = &self.context.device;
        let limits = device.limits();
        let alignment = network.alignment;
        let texel = self.options.precision.texel_bytes();
        let block = network.bytes([alignment; 2], texel);
        let tensors = block.div_ceil(u64::from(alignment).pow(2));
        let footprint = Footprint { per_pixel: images.per_pixel + tensors, ..images };
        let constraints = Constraints {
            alignment,
            halo: network.halo,
            max_side: self.options.tile.unwrap_or(u32::MAX).min(limits.max_texture_dimension_2d),
            max_pixels: footprint
                .most_pixels(self.options.memory_bytes)
                .min(limits.max_storage_buffer_binding_size / PIXEL_BYTES),
        };
        // Behind a CPU driver no display waits, and no watchdog: there, tiles would cost for nothing.
        let constraints = match device.adapter_info().device_type {
            wgpu::DeviceType::Cpu => constraints,
            _ => constraints.with_short_dispatches(largest_layer_macs_per_pixel(&network.body)),
        };
        // What failed for an image of another shape may be too little for any tile of this one.
        let max_pixels = constraints.max_pixels.min(self.most_pixels.load(Ordering::Relaxed));
        TilePlan::new(size, &Constraints { max_pixels, ..constraints })
            .or_else(|| TilePlan::new(size, &constraints))
            .ok_or_else(|| self.too_small(size, &constraints, &footprint))
    }

    /// The plan that [`tile_plan`](Self::tile_plan) makes once the adapter ran out of memory with
    /// this one, from now on: with tiles of at most half the pixels, or of fewer if none are so small.
    ///
    /// # Errors
    /// If there are no smaller tiles.
    pub(crate) fn halved(&self, plan: &TilePlan, size: [u32; 2], of: Inputs) -> Result<TilePlan> {
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
                 smallest for these weights; free some, or take cheaper weights, 16-bit tensors or \
                 another adapter"
            )));
        };
        let [w, h] = smaller.tile;
        let notice = format!(
            "the adapter ran out of memory with tiles of {width}×{height} pixels; goes on with {w}×{h}, \
             which takes longer and gives the same result"
        );
        self.notices.lock().expect("nobody panics with it").push(notice);
        Ok(smaller)
    }

    /// Says what the smallest tile needs and which limit it breaks.
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
            let bindable = self.context.device.limits().max_storage_buffer_binding_size;
            format!("the device was created to bind at most {} MiB at once", bindable >> 20)
        };
        Error::Budget(format!(
            "a tile needs at least {width}×{height} pixels and {} MiB, but {limit}; raise that limit",
            bytes.div_ceil(1 << 20)
        ))
    }
}

#[cfg(test)]
#[path = "tiling_test.rs"]
mod tests;
