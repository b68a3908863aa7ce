//! Compiles kernels ahead of time.

use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{ImageFormat, NormalEncoding, Options, PassFormats};

use crate::support::denoiser;

fn formats() -> PassFormats {
    let half = ImageFormat::Texture(Texture::Rgba16Float);
    PassFormats::new(half, half)
        .albedo(ImageFormat::Texture(Texture::Rgba8Unorm))
        .normal(ImageFormat::Texture(Texture::Rgba8Snorm))
        .normal_encoding(NormalEncoding::Signed)
}

#[test]
fn formats_that_a_pass_takes_can_be_compiled_ahead() {
    let denoiser = denoiser(&Options::default());
    denoiser.warm_up(&formats()).unwrap();
    let buffers = formats().color(super::F32).albedo(None).normal(None);
    denoiser.warm_up(&buffers).unwrap();
}

#[test]
fn formats_that_no_pass_takes_are_refused() {
    let depth = ImageFormat::Texture(Texture::Depth32Float);
    let block = ImageFormat::Texture(Texture::Bc1RgbaUnorm);
    let byte = ImageFormat::Texture(Texture::Rgba8Unorm);
    let moved = ImageFormat::Texture(Texture::Rg16Float);
    let denoiser = denoiser(&Options::default());
    for refused in [
        formats().color(depth),
        formats().albedo(block),
        formats().normal(byte),
        formats().output(byte),
        formats().motion(byte),
        formats().motion(moved).depth(byte),
        formats().depth(ImageFormat::Texture(Texture::R32Float)),
    ] {
        denoiser.warm_up(&refused).unwrap_err();
    }
}
