//! The denoiser in a renderer: bound to a film once, then recorded after it in every frame.

use wgdenoise::{Denoiser, Options, Pass, PassDescriptor, PassImage, Quality, Weights};

use crate::renderer::Result;
use crate::renderer::film::{Film, texture};
use crate::renderer::motion::Motion;

/// A film's denoised image, and the pass that fills it.
pub struct Denoised {
    /// Record it after the commands that fill the film and the motion.
    pub pass: Pass,
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
    /// Binds the denoiser to a film and, to average frames, to the motion from one to the next. A
    /// window that changes its size makes another of all.
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

/// How many of the last frames a moving scene is averaged with at most.
const HISTORY: u32 = 8;

/// How many of the last frames to average with the film's picture after this many earlier frames
/// have added samples to it. The film replaces the history frame by frame, so all frames weigh the
/// same on the way, and then converges undisturbed.
#[must_use]
pub fn history(earlier: u32) -> f32 {
    HISTORY.saturating_sub(earlier) as f32
}
