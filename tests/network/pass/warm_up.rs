//! Compiling ahead.

use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{ImageFormat, NormalEncoding, Options, PassFormats};

use crate::support::denoiser;

const FORMATS: PassFormats = PassFormats {
    color: ImageFormat::Texture(Texture::Rgba16Float),
    albedo: Some(ImageFormat::Texture(Texture::Rgba8Unorm)),
    normal: Some(ImageFormat::Texture(Texture::Rgba8Snorm)),
    normal_encoding: NormalEncoding::Signed,
    output: ImageFormat::Texture(Texture::Rgba16Float),
};

#[test]
fn formats_that_a_pass_takes_can_be_compiled_ahead() {
    let denoiser = denoiser(&Options::default());
    denoiser.warm_up(&FORMATS).unwrap();
    let buffers = PassFormats { color: super::F32, albedo: None, normal: None, ..FORMATS };
    denoiser.warm_up(&buffers).unwrap();
}

#[test]
fn formats_that_no_pass_takes_are_refused() {
    let depth = ImageFormat::Texture(Texture::Depth32Float);
    let block = ImageFormat::Texture(Texture::Bc1RgbaUnorm);
    let byte = ImageFormat::Texture(Texture::Rgba8Unorm);
    let denoiser = denoiser(&Options::default());
    for formats in [
        PassFormats { color: depth, ..FORMATS },
        PassFormats { albedo: Some(block), ..FORMATS },
        PassFormats { normal: Some(byte), ..FORMATS },
        PassFormats { output: byte, ..FORMATS },
    ] {
        denoiser.warm_up(&formats).unwrap_err();
    }
}
