//! Averages a pass's frames over time: memory, calls and checks.

use super::PassDescriptor;
use super::held::{first_layer, texture};
use crate::error::{Error, Result};
use crate::gpu::kernel::{Context, Dispatch};
use crate::ops::accumulate::{Features, FrameImages, History, SOFTNESS_BYTES, accumulate};
use crate::ops::accumulate_layer::{self, LayerCalls, LayerHistory, LayerImages, accumulate_layer};

/// Bytes per pixel of the denoised frame.
const DENOISED_BYTES: u64 = 16;

/// The format of the denoised frame.
const DENOISED: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// The calls after a frame's last tile, and the histories they update.
#[derive(Debug)]
pub(super) struct Accumulation {
    call: Dispatch,
    pub(super) history: History,
    layers: Vec<(LayerCalls, LayerHistory)>,
}

impl Accumulation {
    /// `layers` holds the layers' images and histories, in order.
    pub(super) fn new(
        context: &Context,
        d: &PassDescriptor<'_>,
        images: &FrameImages<'_>,
        layers: Vec<(LayerImages<'_>, LayerHistory)>,
    ) -> Self {
        let has_layers = !layers.is_empty();
        let history = History::new(&context.device, d.pixels(), d.features(), has_layers);
        let calls = |(images, own): (LayerImages<'_>, LayerHistory)| {
            (accumulate_layer(context, d.size(), &images, &own, &history), own)
        };
        let layers = layers.into_iter().map(calls).collect();
        Self { call: accumulate(context, d.size(), images, &history), history, layers }
    }

    /// Records the calls, with the tile at byte `offset` of the uniform buffer. Call
    /// [`advance`](Self::advance) next.
    pub(super) fn record_at(&self, pass: &mut wgpu::ComputePass<'_>, offset: u32) {
        for (calls, _) in &self.layers {
            calls.soften.record_at(pass, offset);
        }
        self.call.record_at(pass, offset);
        for (calls, _) in &self.layers {
            calls.average.record_at(pass, offset);
        }
    }

    /// Records the copies that make this frame the last one.
    pub(super) fn advance(&self, encoder: &mut wgpu::CommandEncoder) {
        self.history.advance(encoder);
        for (_, history) in &self.layers {
            history.advance(encoder);
        }
    }
}

/// The image that receives the denoised frame, before it is averaged.
pub(super) fn denoised(device: &wgpu::Device, size: [u32; 2]) -> wgpu::TextureView {
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    first_layer(&texture(device, size, DENOISED, usage))
}

/// The layers' histories, which also receive the denoised layers; empty without motion.
pub(super) fn layer_histories(device: &wgpu::Device, d: &PassDescriptor<'_>) -> Vec<LayerHistory> {
    let averaged = if d.motion.is_some() { d.layers } else { &[] };
    averaged.iter().map(|_| LayerHistory::new(device, d.pixels())).collect()
}

impl PassDescriptor<'_> {
    /// GPU memory in bytes for averaging frames; 0 without motion.
    pub(super) fn accumulation_bytes(&self) -> u64 {
        let layers = self.layers.len() as u64 * accumulate_layer::BYTES;
        let color = DENOISED_BYTES + 2 * self.features().bytes() + self.softness_bytes();
        self.motion.map_or(0, |_| self.pixels() * (color + layers))
    }

    fn softness_bytes(&self) -> u64 {
        if self.layers.is_empty() { 0 } else { SOFTNESS_BYTES }
    }

    /// Rejects images whose history the device cannot hold in one piece. The color's history is
    /// larger than any layer's.
    pub(super) fn check_accumulation(&self, limits: &wgpu::Limits) -> Result<()> {
        let [width, height] = self.size();
        let bytes = self.pixels() * (self.features().bytes() + self.softness_bytes());
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let side = limits.max_texture_dimension_2d;
        let limit = if self.motion.is_none() {
            return Ok(());
        } else if width.max(height) > side {
            format!("its textures have at most {side} pixels a side")
        } else if bytes > most {
            format!(
                "it binds at most {most} bytes, and the history of {width}×{height} has {bytes}"
            )
        } else {
            return Ok(());
        };
        Err(Error::Budget(format!(
            "the device was created without room for motion: {limit}; ask the adapter for more (see \
             required_limits)"
        )))
    }

    fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    fn features(&self) -> Features {
        Features {
            albedo: self.albedo.is_some(),
            normal: self.normal.is_some(),
            depth: self.depth.is_some(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{PassImage, PassLayer};
    use super::*;
    use crate::{Element, Gpu, Layout};

    /// Checks a pass with color, the first `features` of motion, albedo, normal and depth, and this
    /// many layers.
    fn check(
        size: [u32; 2],
        [features, layers]: [usize; 2],
        limits: &wgpu::Limits,
    ) -> (u64, Result<()>) {
        let Gpu { device, .. } = Gpu::open(None).expect("the tests need an adapter");
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 4,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let layout = Layout::packed(size[0]);
        let image = PassImage::Buffer { buffer: &buffer, element: Element::F32, layout };
        let given = |i: usize| (i < features).then_some(image);
        let layers = vec![PassLayer::new(image, image); layers];
        let descriptor = PassDescriptor::new(size[0], size[1], image, image)
            .layers(&layers)
            .motion(given(0))
            .albedo(given(1))
            .normal(given(2))
            .depth(given(3));
        (descriptor.accumulation_bytes(), descriptor.check_accumulation(limits))
    }

    #[test]
    fn memory_is_taken_for_what_a_scene_has_and_for_nothing_without_motion() {
        let bytes = |images| check([10, 7], images, &wgpu::Limits::default()).0 / 70;
        assert_eq!([0, 1, 2, 3, 4].map(|features| bytes([features, 0])), [0, 48, 56, 64, 72]);
        assert_eq!([0, 1, 4].map(|features| bytes([features, 1])), [0, 84, 108]);
        assert_eq!(bytes([4, 3]), 172);
    }

    #[test]
    fn a_history_beyond_the_devices_limits_is_refused_with_what_to_raise() {
        let limits = wgpu::Limits::default();
        let refusal = |size, images| {
            check(size, images, &limits).1.err().map_or(String::new(), |e| e.to_string())
        };
        assert_eq!(refusal([2560, 1440], [4, 3]), "");
        assert_eq!(refusal([9000, 4000], [0, 3]), "");
        let text = refusal([3840, 2160], [4, 0]);
        assert!(text.contains("binds at most 134217728 bytes") && text.contains("232243200"));
        let text = refusal([3840, 2160], [4, 3]);
        assert!(text.contains("265420800"), "{text}");
        let text = refusal([9000, 10], [1, 0]);
        assert!(text.contains("at most 8192 pixels a side"), "{text}");
    }
}
