//! The denoiser in a renderer: bound to a film once, then recorded after it in every frame.

use wgdenoise::{Denoiser, Options, Pass, PassDescriptor, PassImage, Quality, Weights};

use crate::renderer::Result;
use crate::renderer::film::{Film, texture};

/// A film's denoised image, and the pass that fills it.
pub struct Denoised {
    pass: Pass,
    /// Linear color with the film's alpha, `rgba16float`.
    pub output: wgpu::Texture,
}

/// A denoiser that serves films of any size, on the renderer's own device.
///
/// # Errors
/// If the weights are not built in, or the device cannot hold them or compile the kernels.
pub fn denoiser(device: &wgpu::Device, queue: &wgpu::Queue, quality: Quality) -> Result<Denoiser> {
    Ok(Denoiser::new(device, queue, &Weights::builtin(quality)?, &Options::default())?)
}

impl Denoised {
    /// Binds the denoiser to a film. A window that changes its size makes another of both.
    ///
    /// # Errors
    /// If the device cannot hold the output or the network's tensors.
    pub fn new(denoiser: &Denoiser, device: &wgpu::Device, film: &Film) -> Result<Self> {
        let [width, height] = film.size;
        let output = texture(device, "denoised", film.size, wgpu::TextureFormat::Rgba16Float);
        let [color, albedo, normal, target] =
            [&film.color, &film.albedo, &film.normal, &output].map(PassImage::Texture);
        let pass = denoiser.pass(
            &PassDescriptor::new(width, height, color, target).albedo(albedo).normal(normal),
        )?;
        Ok(Self { pass, output })
    }

    /// Records the denoising of the film, after the commands that fill it.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        self.pass.encode(encoder);
    }

    /// The same, with this share of the noisy color blended in.
    pub fn encode_blended(&self, share: f32, encoder: &mut wgpu::CommandEncoder) {
        self.pass.set_blend(share);
        self.pass.encode(encoder);
    }
}
