//! The denoiser in the renderer: bound to a film once, recorded after it in every frame.

use wgdenoise::{Denoiser, Options, Pass, PassDescriptor, PassImage, Quality, Weights};

use crate::renderer::Result;
use crate::renderer::film::{Film, texture};

/// A film's denoised image.
pub(crate) struct Denoised {
    pass: Pass,
    /// Linear colour, `rgba16float`, with the film's alpha.
    pub(crate) output: wgpu::Texture,
}

/// The denoiser for all films, on the renderer's own device.
pub(crate) fn denoiser(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    quality: Quality,
) -> Result<Denoiser> {
    Ok(Denoiser::new(device, queue, &Weights::builtin(quality)?, &Options::default())?)
}

impl Denoised {
    /// Binds a film. Another size is another film.
    pub(crate) fn new(denoiser: &Denoiser, device: &wgpu::Device, film: &Film) -> Result<Self> {
        let [width, height] = film.size;
        let output = texture(device, "denoised", film.size, wgpu::TextureFormat::Rgba16Float);
        let [color, albedo, normal, target] =
            [&film.color, &film.albedo, &film.normal, &output].map(PassImage::Texture);
        let pass = denoiser.pass(
            &PassDescriptor::new(width, height, color, target).albedo(albedo).normal(normal),
        )?;
        Ok(Self { pass, output })
    }

    /// Records the denoising of what the film holds by then.
    pub(crate) fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        self.pass.encode(encoder);
    }

    /// The same with a share of the noisy colour in it, which grows as samples accumulate.
    pub(crate) fn encode_blended(&self, share: f32, encoder: &mut wgpu::CommandEncoder) {
        self.pass.set_blend(share);
        self.pass.encode(encoder);
    }
}
