//! PNG and JPEG: sRGB-encoded integers outside, linear float inside.

use std::io::{BufReader, Write};
use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{
    ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError, ImageReader,
};

use super::format::{Format, open};
use super::limits::Limits;
use super::srgb::{encoded, linear};
use super::{Problem, jpeg, normals};
use wgdenoise::Image;

/// Out of 100; the loss is invisible.
const JPEG_QUALITY: u8 = 95;

/// What a PNG or JPEG file holds next to its color.
#[derive(Debug)]
pub(super) struct LdrFile {
    /// The file's pixels; alpha is taken from them.
    pixels: DynamicImage,
    icc: Option<Vec<u8>>,
    exif: Option<Vec<u8>>,
}

impl LdrFile {
    /// Reads a file and its color, decoded by the sRGB curve.
    pub(super) fn read(path: &Path, limits: Limits) -> Result<(Self, Image), Problem> {
        let mut decoder = decoder(path, limits)?;
        let (icc, exif) = (
            decoder.icc_profile().unwrap_or_default(),
            decoder.exif_metadata().unwrap_or_default(),
        );
        let pixels = DynamicImage::from_decoder(decoder).map_err(reading)?;
        let color = to_image(&pixels, linear)?;
        Ok((Self { pixels, icc, exif }, color))
    }

    /// The alpha from 0 to 1, row by row, if there is one.
    pub(super) fn alpha(&self) -> Option<Vec<f32>> {
        let values = self.pixels.color().has_alpha().then(|| self.pixels.to_rgba32f());
        values.map(|values| values.pixels().map(|p| p.0[3]).collect())
    }

    /// Writes `color` in this file's depth and with its alpha; returns what was lost.
    pub(super) fn write(
        &self,
        out: &mut impl Write,
        format: Format,
        color: &Image,
    ) -> Result<Vec<String>, Problem> {
        let mut kind = self.pixels.color();
        let mut notices = Vec::new();
        if format == Format::Jpeg {
            if kind.has_alpha() {
                notices.push("JPEG has no alpha channel: alpha was left out".into());
            }
            kind = if kind.has_color() { ColorType::Rgb8 } else { ColorType::L8 };
        }
        let encoded = convert(&with_color(&self.pixels, color), kind);
        let icc = self.icc.clone().filter(|icc| is_profile_of(icc, kind));
        if icc.is_none() && self.icc.is_some() {
            notices.push(
                "the color profile does not apply to the channels written and was left out".into(),
            );
        }
        write(out, format, &encoded, icc, self.exif.clone())?;
        Ok(notices)
    }
}

/// Whether an ICC profile's color space (ICC.1, 7.2.6) is that of the pixels; CMYK is read as RGB.
fn is_profile_of(icc: &[u8], kind: ColorType) -> bool {
    let space = if kind.has_color() { b"RGB " } else { b"GRAY" };
    icc.get(16..20) == Some(space)
}

/// Writes linear color as a new 8-bit file.
pub(super) fn write_new(
    out: &mut impl Write,
    format: Format,
    color: &Image,
) -> Result<Vec<String>, Problem> {
    let blank = DynamicImage::new_rgb8(color.width(), color.height());
    let encoded = convert(&with_color(&blank, color), ColorType::Rgb8);
    write(out, format, &encoded, None, None)?;
    Ok(vec!["wrote only the color, clipped to [0, 1], sRGB-encoded, in 8 bits".into()])
}

/// What the file stores, such as `8-bit RGB`, and its width and height.
pub(super) fn describe(path: &Path, limits: Limits) -> Result<(String, (u32, u32)), Problem> {
    let decoder = decoder(path, limits)?;
    Ok((kind(decoder.original_color_type()), decoder.dimensions()))
}

fn kind(color: ExtendedColorType) -> String {
    let channels = color.channel_count();
    let name = match (color, channels) {
        (ExtendedColorType::Cmyk8 | ExtendedColorType::Cmyk16, _) => "CMYK",
        (_, 1) => "gray",
        (_, 2) => "gray with alpha",
        (_, 3) => "RGB",
        _ => "RGBA",
    };
    format!("{}-bit {name}", color.bits_per_pixel() / u16::from(channels))
}

/// Reads normals, which are stored as `n·0.5+0.5` without a curve.
pub(super) fn read_normals(path: &Path, limits: Limits) -> Result<Image, Problem> {
    let pixels = DynamicImage::from_decoder(decoder(path, limits)?).map_err(reading)?;
    let mut image = to_image(&pixels, |v| v)?;
    normals::decode(&mut image);
    Ok(image)
}

fn decoder(path: &Path, limits: Limits) -> Result<impl ImageDecoder, Problem> {
    let memory = limits.pixels.saturating_mul(8).saturating_add(64 << 20);
    // The decoder fills in gray where a JPEG ends early.
    if Format::of_content(path)? == Format::Jpeg && !jpeg::is_whole(path, memory)? {
        return Err(Problem::Damaged("is cut off: a JPEG must have an end marker".into()));
    }
    let reader = ImageReader::new(BufReader::new(open(path)?)).with_guessed_format();
    let mut reader = reader.map_err(Problem::Read)?;
    let mut most = image::Limits::default();
    most.max_alloc = Some(memory);
    reader.limits(most);
    let decoder = reader.into_decoder().map_err(reading)?;
    let (width, height) = decoder.dimensions();
    limits.check_size(width.into(), height.into())?;
    Ok(decoder)
}

fn to_image(pixels: &DynamicImage, decode: fn(f32) -> f32) -> Result<Image, Problem> {
    let (width, height) = (pixels.width(), pixels.height());
    let values = pixels.to_rgb32f();
    let pixels = values.pixels().map(|p| p.0.map(decode)).collect();
    Image::new(width, height, pixels).map_err(|e| Problem::Damaged(e.to_string()))
}

/// `original` with another color, in float.
fn with_color(original: &DynamicImage, color: &Image) -> DynamicImage {
    let mut values = original.to_rgba32f();
    for (value, pixel) in values.pixels_mut().zip(color.pixels()) {
        value.0[..3].copy_from_slice(&pixel.map(encoded));
    }
    DynamicImage::ImageRgba32F(values)
}

fn convert(image: &DynamicImage, kind: ColorType) -> DynamicImage {
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

fn write(
    out: &mut impl Write,
    format: Format,
    image: &DynamicImage,
    icc: Option<Vec<u8>>,
    exif: Option<Vec<u8>>,
) -> Result<(), Problem> {
    match format {
        Format::Jpeg => encode(JpegEncoder::new_with_quality(out, JPEG_QUALITY), image, icc, exif),
        _ => encode(PngEncoder::new(out), image, icc, exif),
    }
}

fn encode(
    mut encoder: impl ImageEncoder,
    image: &DynamicImage,
    icc: Option<Vec<u8>>,
    exif: Option<Vec<u8>>,
) -> Result<(), Problem> {
    let unsupported = |e| Problem::Unsupported(format!("cannot keep the color profile: {e}"));
    icc.map_or(Ok(()), |icc| encoder.set_icc_profile(icc)).map_err(unsupported)?;
    // Camera data is a courtesy: a format without a place for it does without.
    let _ = exif.map(|exif| encoder.set_exif_metadata(exif));
    image.write_with_encoder(encoder).map_err(|error| match error {
        ImageError::IoError(error) => Problem::Write(error),
        error => Problem::Unsupported(format!("cannot be encoded: {error}")),
    })
}

fn reading(error: ImageError) -> Problem {
    match error {
        ImageError::IoError(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
            Problem::Read(error)
        }
        ImageError::Limits(error) => Problem::TooLarge(format!("is too large: {error}")),
        ImageError::Unsupported(error) => {
            Problem::Unsupported(format!("is not supported: {error}"))
        }
        error => Problem::Damaged(format!("is cut off or damaged: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    #[test]
    fn every_value_of_every_depth_and_alpha_survives_decoding_and_encoding() {
        let values = |i: u32| {
            image::Rgba([i as u16, (i * 7 % 65536) as u16, 65535 - i as u16, (i * 3) as u16])
        };
        let original =
            DynamicImage::from(image::ImageBuffer::from_fn(256, 256, |x, y| values(256 * y + x)));
        for kind in [
            ColorType::L8,
            ColorType::La8,
            ColorType::Rgb8,
            ColorType::Rgba8,
            ColorType::L16,
            ColorType::La16,
            ColorType::Rgb16,
            ColorType::Rgba16,
        ] {
            let stored = convert(&original, kind);
            let color = to_image(&stored, linear).unwrap();
            let again = convert(&with_color(&stored, &color), kind);
            assert_eq!(again.as_bytes(), stored.as_bytes(), "{kind:?}");
        }
    }

    #[test]
    fn a_profile_stays_only_with_the_channels_it_is_for() {
        let color = Image::filled(4, 4, [0.5; 3]).unwrap();
        for (space, pixels, notices) in [
            (b"RGB ", DynamicImage::new_rgb8(4, 4), 0),
            (b"CMYK", DynamicImage::new_rgb8(4, 4), 1),
            (b"GRAY", DynamicImage::new_luma16(4, 4), 0),
            (b"RGB ", DynamicImage::new_luma8(4, 4), 1),
        ] {
            let icc = [&[0; 16][..], space, &[0; 108]].concat();
            let file = LdrFile { pixels, icc: Some(icc.clone()), exif: None };
            let mut png = Vec::new();
            assert_eq!(file.write(&mut png, Format::Png, &color).unwrap().len(), notices);
            let mut decoder = image::codecs::png::PngDecoder::new(Cursor::new(png)).unwrap();
            assert_eq!(decoder.icc_profile().unwrap(), (notices == 0).then_some(icc));
        }
    }
}
