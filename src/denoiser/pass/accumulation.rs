//! The mean of a pass's frames: its memory, its call and its checks.

use super::PassDescriptor;
use super::held::{first_layer, texture};
use crate::error::{Error, Result};
use crate::gpu::kernel::{Context, Dispatch};
use crate::ops::accumulate::{Features, FrameImages, History, accumulate};

/// Bytes of a pixel of the denoised frame.
const DENOISED_BYTES: u64 = 16;

/// The format of the denoised frame.
const DENOISED: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// The call after a frame's last tile, and the history that it continues.
#[derive(Debug)]
pub(super) struct Accumulation {
    pub(super) call: Dispatch,
    pub(super) history: History,
}

impl Accumulation {
    pub(super) fn new(context: &Context, size: [u32; 2], images: &FrameImages<'_>) -> Self {
        let pixels = size.into_iter().map(u64::from).product();
        let history = History::new(&context.device, pixels, images.features());
        Self { call: accumulate(context, size, images, &history), history }
    }
}

/// The image that receives the denoised frame, before it is averaged.
pub(super) fn denoised(device: &wgpu::Device, size: [u32; 2]) -> wgpu::TextureView {
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    first_layer(&texture(device, size, DENOISED, usage))
}

impl PassDescriptor<'_> {
    /// Bytes that averaging frames takes; 0 without motion.
    pub(super) fn accumulation_bytes(&self) -> u64 {
        let pixels = u64::from(self.width) * u64::from(self.height);
        self.motion.map_or(0, |_| pixels * (DENOISED_BYTES + 2 * self.features().bytes()))
    }

    /// Rejects pictures whose history the device cannot hold in one piece.
    pub(super) fn check_accumulation(&self, limits: &wgpu::Limits) -> Result<()> {
        let [width, height] = self.size();
        let bytes = u64::from(width) * u64::from(height) * self.features().bytes();
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
    use super::super::PassImage;
    use super::*;
    use crate::{Element, Gpu, Layout};

    /// With color, motion, and the features given.
    fn check(size: [u32; 2], features: usize, limits: &wgpu::Limits) -> (u64, Result<()>) {
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
        let descriptor = PassDescriptor::new(size[0], size[1], image, image)
            .motion(given(0))
            .albedo(given(1))
            .normal(given(2))
            .depth(given(3));
        (descriptor.accumulation_bytes(), descriptor.check_accumulation(limits))
    }

    #[test]
    fn memory_is_taken_for_what_a_scene_has_and_for_nothing_without_motion() {
        let bytes = |features| check([10, 7], features, &wgpu::Limits::default()).0 / 70;
        assert_eq!([0, 1, 2, 3, 4].map(bytes), [0, 48, 56, 64, 72]);
    }

    #[test]
    fn a_history_beyond_the_devices_limits_is_refused_with_what_to_raise() {
        let limits = wgpu::Limits::default();
        let refusal = |size, features| {
            check(size, features, &limits).1.err().map_or(String::new(), |e| e.to_string())
        };
        assert_eq!(refusal([2560, 1440], 4), "");
        assert_eq!(refusal([9000, 4000], 0), "");
        let text = refusal([3840, 2160], 4);
        assert!(text.contains("binds at most 134217728 bytes") && text.contains("232243200"));
        let text = refusal([9000, 10], 1);
        assert!(text.contains("at most 8192 pixels a side"), "{text}");
    }
}
