//! Encodes pixels of 8 or 16 bits as a PNG or JPEG file.

use std::borrow::Cow;
use std::io::Write;

use image::codecs::jpeg::JpegEncoder;
use image::{ColorType, DynamicImage, ImageEncoder, ImageError};
use png::chunk::ChunkType;
use png::{BitDepth, Compression, EncodingError, Filter};

use super::chunks::Chunk;
use super::curve::Curve;
use super::density::Density;
use super::jpeg::{self, Segment};
use crate::Problem;
use crate::format::Format;
use wgdenoise::Image;

/// Out of 100; the loss is invisible.
const JPEG_QUALITY: u8 = 95;

/// A picture ready to be encoded, and its metadata.
#[derive(Debug)]
pub(crate) struct Encoded {
    /// The pixels, in an 8- or 16-bit kind that the format has.
    pub(crate) pixels: DynamicImage,
    pub(crate) icc: Option<Vec<u8>>,
    pub(crate) exif: Option<Vec<u8>>,
    /// Further chunks of a PNG, without the profile or EXIF data above.
    pub(crate) chunks: Vec<Chunk>,
    /// Further segments of a JPEG.
    pub(crate) segments: Vec<Segment>,
    /// The pixel density, unless the chunks tell it.
    pub(crate) density: Option<Density>,
}

impl Encoded {
    pub(crate) fn new(pixels: DynamicImage) -> Self {
        let (chunks, segments) = (Vec::new(), Vec::new());
        Self { pixels, icc: None, exif: None, chunks, segments, density: None }
    }

    /// Writes a JPEG or a PNG.
    pub(crate) fn write(self, out: &mut impl Write, format: Format) -> Result<(), Problem> {
        match format {
            Format::Jpeg => self.write_jpeg(out),
            _ => self.write_png(out),
        }
    }

    fn write_jpeg(self, out: &mut impl Write) -> Result<(), Problem> {
        let mut bytes = Vec::new();
        let mut encoder = JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY);
        if let Some(density) = self.density {
            encoder.set_pixel_density(density.jfif());
        }
        let unsupported = |e| Problem::Unsupported(format!("cannot keep the color profile: {e}"));
        self.icc.map_or(Ok(()), |icc| encoder.set_icc_profile(icc)).map_err(unsupported)?;
        // Data too long for a JPEG is listed among what was lost.
        let _ =
            self.exif.filter(|exif| jpeg::fits(exif)).map(|exif| encoder.set_exif_metadata(exif));
        let failed =
            |error: ImageError| Problem::Unsupported(format!("cannot be encoded: {error}"));
        self.pixels.write_with_encoder(encoder).map_err(failed)?;
        out.write_all(&jpeg::with_segments(&bytes, &self.segments)).map_err(Problem::Write)
    }

    fn write_png(self, out: &mut impl Write) -> Result<(), Problem> {
        let mut info = png::Info::with_size(self.pixels.width(), self.pixels.height());
        (info.color_type, info.bit_depth) = png_kind(self.pixels.color());
        info.icc_profile = self.icc.map(Cow::Owned);
        info.exif_metadata = self.exif.map(Cow::Owned);
        let mut encoder = png::Encoder::with_info(out, info).map_err(encoding)?;
        encoder.set_compression(Compression::Fast);
        encoder.set_filter(Filter::Adaptive);
        let mut writer = encoder.write_header().map_err(encoding)?;
        let put = |writer: &mut png::Writer<_>, after_pixels| {
            let mut chunks = self.chunks.iter().filter(|chunk| chunk.after_pixels == after_pixels);
            chunks.try_for_each(|chunk| writer.write_chunk(ChunkType(chunk.kind), &chunk.data))
        };
        if let Some(density) = self.density {
            writer.write_chunk(png::chunk::pHYs, &density.png()).map_err(encoding)?;
        }
        put(&mut writer, false).map_err(encoding)?;
        writer.write_image_data(&big_endian(&self.pixels)).map_err(encoding)?;
        put(&mut writer, true).map_err(encoding)?;
        writer.finish().map_err(encoding)
    }
}

/// Gives `base` the color of `color`, which is linear and premultiplied by `alpha`, or else by the
/// alpha of `base`.
///
/// PNG has straight alpha, so colors are divided by the alpha that is stored. Where that is 0, no
/// color shows, and `base` keeps its own. Kinds without alpha show the picture over black.
pub(crate) fn paint(
    base: &DynamicImage,
    color: &Image,
    alpha: Option<&[f32]>,
    curve: Curve,
    kind: ColorType,
) -> DynamicImage {
    let mut values = base.to_rgba32f();
    let levels = if kind.bytes_per_pixel() / kind.channel_count() == 2 { 65535.0 } else { 255.0 };
    let covers = |i: usize, own: f32| match alpha {
        _ if !kind.has_alpha() => 1.0,
        Some(alpha) => (alpha[i].clamp(0.0, 1.0) * levels).round().max(0.0) / levels,
        None => own,
    };
    for (i, (value, pixel)) in values.pixels_mut().zip(color.pixels()).enumerate() {
        let covered = covers(i, value.0[3]);
        if covered > 0.0 {
            value.0[..3].copy_from_slice(&pixel.map(|light| curve.encoded(light / covered)));
        }
        value.0[3] = covered;
    }
    convert(&DynamicImage::ImageRgba32F(values), kind)
}

/// Converts pixels to another kind of 8 or 16 bits.
pub(crate) fn convert(image: &DynamicImage, kind: ColorType) -> DynamicImage {
    match kind {
        ColorType::L8 => image.to_luma8().into(),
        ColorType::La8 => image.to_luma_alpha8().into(),
        ColorType::Rgb8 => image.to_rgb8().into(),
        ColorType::L16 => image.to_luma16().into(),
        ColorType::La16 => image.to_luma_alpha16().into(),
        ColorType::Rgb16 => image.to_rgb16().into(),
        ColorType::Rgba16 => image.to_rgba16().into(),
        _ => image.to_rgba8().into(),
    }
}

fn png_kind(kind: ColorType) -> (png::ColorType, BitDepth) {
    let color = match (kind.has_color(), kind.has_alpha()) {
        (false, false) => png::ColorType::Grayscale,
        (false, true) => png::ColorType::GrayscaleAlpha,
        (true, false) => png::ColorType::Rgb,
        (true, true) => png::ColorType::Rgba,
    };
    let is_deep = kind.bytes_per_pixel() == 2 * kind.channel_count();
    (color, if is_deep { BitDepth::Sixteen } else { BitDepth::Eight })
}

/// Samples in PNG's byte order.
fn big_endian(image: &DynamicImage) -> Cow<'_, [u8]> {
    let bytes = image.as_bytes();
    if png_kind(image.color()).1 == BitDepth::Eight {
        return Cow::Borrowed(bytes);
    }
    let pairs = bytes.as_chunks().0.iter();
    pairs.flat_map(|&pair| u16::from_ne_bytes(pair).to_be_bytes()).collect()
}

fn encoding(error: EncodingError) -> Problem {
    match error {
        EncodingError::IoError(error) => Problem::Write(error),
        error => Problem::Unsupported(format!("cannot be encoded: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pixels whose written alpha is 0 keep what the file had; others show the new color.
    #[test]
    fn colors_are_divided_by_the_alpha_that_is_written() {
        let base =
            DynamicImage::from(image::RgbaImage::from_pixel(5, 1, image::Rgba([9, 8, 7, 0])));
        let color = Image::filled(5, 1, [0.25, 0.125, 0.0]).unwrap();
        let alpha = [0.0, 0.001, 0.5, 1.0, f32::NAN];
        let written = paint(&base, &color, Some(&alpha), Curve::Power(1.0), ColorType::Rgba8);
        let (hidden, half) = ([9, 8, 7, 0], [127, 64, 0, 128]);
        let pixels: Vec<_> = written.to_rgba8().pixels().map(|pixel| pixel.0).collect();
        assert_eq!(pixels, [hidden, hidden, half, [64, 32, 0, 255], hidden]);
        let flat = paint(&base, &color, Some(&alpha), Curve::Power(1.0), ColorType::Rgb8);
        assert!(flat.to_rgb8().pixels().all(|pixel| pixel.0 == [64, 32, 0]), "over black");
    }

    #[test]
    fn pixels_that_are_not_square_are_told_to_both_formats() {
        let encoded = |format, aspect| {
            let mut bytes = Vec::new();
            let density = Density::of_aspect(aspect);
            let encoded = Encoded { density, ..Encoded::new(DynamicImage::new_rgb8(2, 2)) };
            encoded.write(&mut bytes, format).unwrap();
            bytes
        };
        let contains = |bytes: &[u8], part: &[u8]| bytes.windows(part.len()).any(|w| w == part);
        let [png, jpeg] = [Format::Png, Format::Jpeg].map(|format| encoded(format, 1.5));
        assert!(contains(&png, b"pHYs\0\0\x03\xe8\0\0\x05\xdc\0"), "1000:1500, no unit");
        assert!(contains(&jpeg, b"JFIF\0\x01\x02\0\x03\xe8\x05\xdc"), "{:?}", &jpeg[..24]);
        assert!(!contains(&encoded(Format::Png, 1.0), b"pHYs"));
    }
}
