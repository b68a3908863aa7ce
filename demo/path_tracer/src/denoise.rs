//! The denoiser in a renderer: bound to a film once, then recorded after it every frame.

use wgdenoise::{Denoiser, Options, Pass, PassDescriptor, PassImage, Quality, Weights};

use crate::renderer::Result;
use crate::renderer::film::{Film, texture};
use crate::renderer::motion::Motion;

/// A film's denoised image, and the pass that fills it.
pub struct Denoised {
    /// Record this after the commands that fill the film and the motion.
    pub pass: Pass,
    /// Linear color with the film's alpha, `rgba16float`.
    pub output: wgpu::Texture,
}

/// Creates a denoiser for films of any size, on the renderer's own device.
///
/// # Errors
/// If the weights are not built in, or the device cannot hold them or compile the kernels.
pub fn denoiser(device: &wgpu::Device, queue: &wgpu::Queue, quality: Quality) -> Result<Denoiser> {
    Ok(Denoiser::new(device, queue, &Weights::builtin(quality)?, &Options::default())?)
}

impl Denoised {
    /// Binds the denoiser to a film and, to average frames, to the motion between them. A resized
    /// window needs new images and a new binding.
    ///
    /// # Errors
    /// If the device cannot hold the output or the network's tensors.
    pub fn new(
        denoiser: &Denoiser,
        device: &wgpu::Device,
        film: &Film,
        motion: Option<&Motion>,
    ) -> Result<Self> {
        let [width, height] = film.size;
        let output = texture(device, "denoised", film.size, wgpu::TextureFormat::Rgba16Float);
        let [color, albedo, normal, target] =
            [&film.color, &film.albedo, &film.normal, &output].map(PassImage::Texture);
        let pass = denoiser.pass(
            &PassDescriptor::new(width, height, color, target)
                .albedo(albedo)
                .normal(normal)
                .motion(motion.map(|motion| PassImage::Texture(&motion.vectors)))
                .depth(motion.map(|motion| PassImage::Texture(&motion.depth))),
        )?;
        Ok(Self { pass, output })
    }
}

/// Maximum number of earlier frames that a moving scene is averaged with.
const HISTORY: u32 = 8;

/// The number of past frames to average with a film to which `earlier` frames have already added
/// samples. The film replaces the history frame by frame, so that all frames weigh the same in the
/// meantime, and then converges undisturbed.
#[must_use]
pub fn history(earlier: u32) -> f32 {
    HISTORY.saturating_sub(earlier) as f32
}
