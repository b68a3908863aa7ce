//! Pixels as stored in a renderer's image formats: [`encode`], [`decode`], [`blend`].

use half::f16;

use wgdenoise::{Element, ImageFormat, wgpu};

/// Encodes a pixel: all channels of a texture's format, or for a buffer the first four, of which
/// the buffer holds as many as its layout has.
///
/// # Panics
/// Panics if no pass accepts the format.
#[must_use]
pub fn encode(format: ImageFormat, pixel: [f32; 4]) -> Vec<u8> {
    use wgpu::TextureFormat as Texture;
    let unorm = |v: f32, most: f32| (v.clamp(0.0, 1.0) * most).round() as u32;
    match format {
        ImageFormat::Buffer(Element::F16) | ImageFormat::Texture(Texture::Rgba16Float) => {
            pixel.iter().flat_map(|&v| f16::from_f32(v).to_le_bytes()).collect()
        }
        ImageFormat::Buffer(Element::F32) | ImageFormat::Texture(Texture::Rgba32Float) => {
            pixel.iter().flat_map(|v| v.to_le_bytes()).collect()
        }
        ImageFormat::Texture(Texture::Rg16Float | Texture::R16Float) => {
            encode(ImageFormat::Buffer(Element::F16), pixel)[..pixel_bytes(format)].into()
        }
        ImageFormat::Texture(Texture::Rg32Float | Texture::R32Float) => {
            encode(ImageFormat::Buffer(Element::F32), pixel)[..pixel_bytes(format)].into()
        }
        ImageFormat::Texture(Texture::Rgba8Unorm) => {
            pixel.iter().map(|&v| unorm(v, 255.0) as u8).collect()
        }
        ImageFormat::Texture(Texture::Rgba8UnormSrgb) => {
            let [r, g, b, a] = pixel;
            [r, g, b].map(to_srgb).into_iter().chain([a]).map(|v| unorm(v, 255.0) as u8).collect()
        }
        ImageFormat::Texture(Texture::Rgba8Snorm) => pixel
            .iter()
            .flat_map(|v| ((v.clamp(-1.0, 1.0) * 127.0).round() as i8).to_le_bytes())
            .collect(),
        ImageFormat::Texture(Texture::Rgb10a2Unorm) => {
            let [r, g, b] = [0, 1, 2].map(|c| unorm(pixel[c], 1023.0));
            (r | g << 10 | b << 20 | unorm(pixel[3], 3.0) << 30).to_le_bytes().into()
        }
        ImageFormat::Texture(other) => panic!("no pass takes {other:?}"),
    }
}

fn pixel_bytes(format: ImageFormat) -> usize {
    let ImageFormat::Texture(format) = format else { unreachable!("only asked of textures") };
    format.block_copy_size(None).expect("a color format") as usize
}

/// Decodes what [`encode`] produces; channels that the format lacks are 0.
///
/// # Panics
/// Panics if no pass accepts the format, or if `bytes` are not those of one pixel.
#[must_use]
pub fn decode(format: ImageFormat, bytes: &[u8]) -> [f32; 4] {
    use wgpu::TextureFormat as Texture;
    let byte = |c: usize| f32::from(bytes[c]) / 255.0;
    match format {
        ImageFormat::Buffer(Element::F16) | ImageFormat::Texture(Texture::Rgba16Float) => {
            [0, 1, 2, 3].map(|c| f16::from_le_bytes([bytes[2 * c], bytes[2 * c + 1]]).to_f32())
        }
        ImageFormat::Buffer(Element::F32) | ImageFormat::Texture(Texture::Rgba32Float) => {
            bytemuck::pod_read_unaligned(bytes)
        }
        ImageFormat::Texture(Texture::Rg16Float | Texture::R16Float) => {
            decode(ImageFormat::Buffer(Element::F16), &padded(bytes, 8))
        }
        ImageFormat::Texture(Texture::Rg32Float | Texture::R32Float) => {
            decode(ImageFormat::Buffer(Element::F32), &padded(bytes, 16))
        }
        ImageFormat::Texture(Texture::Rgba8Unorm) => [0, 1, 2, 3].map(byte),
        ImageFormat::Texture(Texture::Rgba8UnormSrgb) => {
            let [r, g, b] = [0, 1, 2].map(|c| from_srgb(byte(c)));
            [r, g, b, byte(3)]
        }
        ImageFormat::Texture(Texture::Rgba8Snorm) => {
            [0, 1, 2, 3].map(|c| (f32::from(bytes[c] as i8) / 127.0).max(-1.0))
        }
        ImageFormat::Texture(Texture::Rgb10a2Unorm) => {
            let word: u32 = bytemuck::pod_read_unaligned(bytes);
            let [r, g, b] = [0, 10, 20].map(|shift| (word >> shift & 1023) as f32 / 1023.0);
            [r, g, b, (word >> 30) as f32 / 3.0]
        }
        ImageFormat::Texture(other) => panic!("no pass takes {other:?}"),
    }
}

fn padded(bytes: &[u8], length: usize) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes.resize(length, 0);
    bytes
}

/// Blends a denoised value with a share `share` of the noisy one; a noisy value that is not finite
/// is ignored.
#[must_use]
pub fn blend(denoised: f32, noisy: f32, share: f32) -> f32 {
    if noisy.is_finite() { denoised * (1.0 - share) + noisy * share } else { denoised }
}

/// Encodes sRGB (IEC 61966-2-1).
fn to_srgb(linear: f32) -> f32 {
    if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

fn from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::TextureFormat as Texture;

    #[test]
    fn formats_hold_the_bytes_that_their_definitions_say() {
        let texture = |format, pixel| encode(ImageFormat::Texture(format), pixel);
        assert_eq!(texture(Texture::Rgba8Unorm, [0.0, 0.5, 1.0, 2.0]), [0, 128, 255, 255]);
        assert_eq!(texture(Texture::Rgba8Snorm, [-1.0, 0.0, 1.0, 0.5]), [129, 0, 127, 64]);
        // 18 % gray is 118 of 255 in sRGB.
        assert_eq!(texture(Texture::Rgba8UnormSrgb, [0.18, 0.0, 1.0, 0.5]), [118, 0, 255, 128]);
        assert_eq!(texture(Texture::Rgb10a2Unorm, [1.0, 0.0, 0.0, 1.0]), [255, 3, 0, 192]);
        assert_eq!(texture(Texture::Rgba16Float, [1.0; 4]), [0, 0x3c].repeat(4));
        assert_eq!(texture(Texture::Rg16Float, [1.0; 4]), [0, 0x3c].repeat(2));
        assert_eq!(texture(Texture::R32Float, [1.0; 4]), [0, 0, 0x80, 0x3f]);
    }

    #[test]
    fn decoding_gives_back_what_the_format_can_hold() {
        for format in [Texture::Rgba8Unorm, Texture::Rgba8UnormSrgb, Texture::Rgb10a2Unorm] {
            let format = ImageFormat::Texture(format);
            let pixel = decode(format, &encode(format, [0.2, 0.5, 0.9, 1.0]));
            assert_eq!(encode(format, pixel), encode(format, [0.2, 0.5, 0.9, 1.0]));
            assert!((pixel[1] - 0.5).abs() < 1.0 / 200.0 && pixel[3] == 1.0, "{pixel:?}");
        }
        let half = ImageFormat::Buffer(Element::F16);
        assert_eq!(
            decode(half, &encode(half, [-2.0, 0.25, 70_000.0, 0.0])),
            [-2.0, 0.25, f32::INFINITY, 0.0]
        );
    }
}
