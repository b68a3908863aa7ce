//! PNG and JPEG: integers with straight alpha in the file, linear premultiplied floats in memory.

pub(crate) mod chunks;
mod color_space;
pub(crate) mod curve;
pub(crate) mod density;
pub(crate) mod encode;
mod jpeg;

use std::io::{BufReader, ErrorKind, Seek, Write};
use std::path::Path;

use image::metadata::Orientation;
use image::{ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageError, ImageReader};

use self::chunks::Chunks;
use self::color_space::ColorSpace;
use self::curve::Curve;
use self::density::Density;
use self::encode::{Encoded, paint};
use self::jpeg::Segments;
use crate::display::Display;
use crate::format::{Format, open};
use crate::limits::Limits;
use crate::{Problem, exr, normals, primaries};
use wgdenoise::Image;

/// A PNG or JPEG file: its pixels and what it holds besides.
#[derive(Debug)]
pub(super) struct LdrFile {
    format: Format,
    /// The file's pixels, turned upright.
    pixels: DynamicImage,
    /// The orientation in the EXIF data, which was applied to them.
    orientation: Orientation,
    space: ColorSpace,
    icc: Option<Vec<u8>>,
    exif: Option<Vec<u8>>,
    /// A PNG's chunks.
    chunks: Chunks,
    /// A JPEG's segments.
    segments: Segments,
}

impl LdrFile {
    /// Reads a file and its color: upright, linear, and premultiplied by alpha.
    ///
    /// Hidden color, where alpha is 0, becomes black and cannot bleed into visible pixels.
    pub(super) fn read(path: &Path, limits: Limits) -> Result<(Self, Image), Problem> {
        let file = Self::load(path, limits)?;
        let color = to_image(&file.pixels, |v| file.space.curve.linear(v))?;
        Ok((file, color))
    }

    fn load(path: &Path, limits: Limits) -> Result<Self, Problem> {
        let format = Format::of_content(path)?;
        let (chunks, segments) = beside(path, format, limits)?;
        let space = ColorSpace::of(&chunks)?;
        let mut decoder = decoder(path, limits)?;
        let icc = decoder.icc_profile().unwrap_or_default();
        let exif = chunks.get(*b"eXIf").map(<[u8]>::to_vec);
        let exif = exif.or_else(|| decoder.exif_metadata().unwrap_or_default());
        let orientation = upright(exif.as_deref());
        let mut pixels = DynamicImage::from_decoder(decoder).map_err(reading)?;
        pixels.apply_orientation(orientation);
        Ok(Self { format, pixels, orientation, space, icc, exif, chunks, segments })
    }

    /// The alpha from 0 to 1, row by row, if there is any.
    pub(super) fn alpha(&self) -> Option<Vec<f32>> {
        let values = self.pixels.color().has_alpha().then(|| self.pixels.to_rgba32f());
        values.map(|values| values.pixels().map(|p| p.0[3]).collect())
    }

    /// How to show the picture.
    pub(super) fn display(&self) -> Display {
        let size = (self.pixels.width(), self.pixels.height());
        Display::whole(size, self.space.primaries, self.pixel_aspect())
    }

    /// The pixel density of the upright picture.
    fn density(&self) -> Option<Density> {
        let density = self.chunks.density().or(self.segments.density());
        density.map(|d| if is_sideways(self.orientation) { d.turned() } else { d })
    }

    /// Pixel width over height.
    fn pixel_aspect(&self) -> f32 {
        self.density().map_or(1.0, Density::aspect)
    }

    /// What a user should know about how the file was read, one sentence each.
    pub(super) fn notices(&self) -> Vec<String> {
        let animated =
            "the PNG is animated: only its first image is denoised, and the others are left out";
        let cmyk = "the JPEG is CMYK: its colors are read, and written, as RGB";
        let notices = [(self.chunks.is_animated(), animated), (self.segments.is_cmyk(), cmyk)];
        notices.into_iter().filter(|(holds, _)| *holds).map(|(_, notice)| notice.into()).collect()
    }

    /// Writes `color`, premultiplied by `alpha` or else by this file's own, in any format; returns
    /// what was lost.
    ///
    /// In this file's own format, depth, curve and everything else stay. Alpha is ignored where
    /// this file or the format has none.
    pub(super) fn write(
        &self,
        out: &mut (impl Write + Seek),
        format: Format,
        color: &Image,
        alpha: Option<&[f32]>,
    ) -> Result<Vec<String>, Problem> {
        match format {
            Format::Exr => self.write_exr(out, color, alpha),
            format if format == self.format => self.write_alike(out, color, alpha),
            format => self.write_converted(out, format, color, alpha),
        }
    }

    fn write_exr(
        &self,
        out: &mut (impl Write + Seek),
        color: &Image,
        alpha: Option<&[f32]>,
    ) -> Result<Vec<String>, Problem> {
        let own = self.alpha();
        let alpha = own.map(|own| alpha.map_or(own, <[f32]>::to_vec));
        let with = if alpha.is_some() { ", premultiplied by alpha," } else { "" };
        let mut notices = vec![format!("written as linear R, G, B{with} in 32-bit float")];
        exr::write_rgb(out, color, alpha, self.space.primaries, self.pixel_aspect())?;
        if self.icc.is_some() {
            notices.push("the color profile was not applied: colors were taken as sRGB".into());
        }
        notices.extend(self.lost(Format::Exr));
        Ok(notices)
    }

    /// Writes this file's format, in this file's orientation.
    fn write_alike(
        &self,
        out: &mut impl Write,
        color: &Image,
        alpha: Option<&[f32]>,
    ) -> Result<Vec<String>, Problem> {
        let kind = self.pixels.color();
        let mut encoded = Encoded::new(paint(&self.pixels, color, alpha, self.space.curve, kind));
        encoded.pixels.apply_orientation(inverse(self.orientation));
        let (icc, mut notices) = self.profile_for(kind);
        if self.format == Format::Png {
            let keeps_profile = icc.is_some() || self.icc.is_none();
            let chunks = self.chunks.kept().iter();
            let chunks = chunks.filter(|chunk| keeps_profile || &chunk.kind != b"iCCP");
            encoded.chunks = chunks.cloned().collect();
            notices.extend(self.chunks.left_out());
        } else {
            (encoded.icc, encoded.exif) = (icc, self.exif.clone());
            encoded.segments = self.segments.kept().to_vec();
            encoded.density = self.segments.density();
            notices.extend(self.segments.left_out());
        }
        encoded.write(out, self.format)?;
        Ok(notices)
    }

    /// Writes a PNG as a JPEG or a JPEG as a PNG: upright, and in sRGB or the profile's space.
    fn write_converted(
        &self,
        out: &mut impl Write,
        format: Format,
        color: &Image,
        alpha: Option<&[f32]>,
    ) -> Result<Vec<String>, Problem> {
        let has_color = self.pixels.color().has_color();
        let kind = if has_color { ColorType::Rgb8 } else { ColorType::L8 };
        let (icc, mut notices) = self.profile_for(kind);
        if self.pixels.color().has_alpha() {
            notices.push("JPEG has no alpha channel: the picture was written over black".into());
        }
        let mut color = color.clone();
        if let Some(primaries) = &self.space.primaries {
            primaries::convert_to_srgb(&mut color, primaries);
        }
        let mut encoded = Encoded::new(paint(&self.pixels, &color, alpha, Curve::Srgb, kind));
        (encoded.icc, encoded.exif) = (icc, self.exif.clone());
        // The pixels are upright now; EXIF must not turn them again.
        let _ = encoded.exif.as_mut().and_then(|exif| Orientation::remove_from_exif_chunk(exif));
        encoded.density = self.density();
        encoded.write(out, format)?;
        notices.extend(self.lost(format));
        Ok(notices)
    }

    /// The color profile if it fits the channels written, and a notice if it does not.
    fn profile_for(&self, kind: ColorType) -> (Option<Vec<u8>>, Vec<String>) {
        let icc = self.icc.clone().filter(|icc| is_profile_of(icc, kind));
        let lost = icc.is_none() && self.icc.is_some();
        let notice =
            "the color profile does not apply to the channels written and was left out".to_string();
        (icc, lost.then_some(notice).into_iter().collect())
    }

    /// Lists the metadata that another format cannot store.
    fn lost(&self, format: Format) -> Option<String> {
        let mut used: Vec<&[u8; 4]> = vec![b"gAMA", b"cHRM", b"sRGB", b"cICP", b"iCCP"];
        if format == Format::Jpeg && self.exif.as_ref().is_some_and(|exif| jpeg::fits(exif)) {
            used.push(b"eXIf");
        }
        if self.density().is_some() {
            used.push(b"pHYs");
        }
        let segments = self.segments.lost(format == Format::Exr);
        self.chunks.lost_except(&used).or(segments)
    }
}

/// Whether an ICC profile's color space (ICC.1, 7.2.6) matches the pixels; CMYK is read as RGB.
fn is_profile_of(icc: &[u8], kind: ColorType) -> bool {
    let space = if kind.has_color() { b"RGB " } else { b"GRAY" };
    icc.get(16..20) == Some(space)
}

/// What a file stores.
pub(super) struct Kind {
    /// A description such as `8-bit RGB`.
    pub(super) text: String,
    /// Width and height of the upright picture.
    pub(super) size: (u32, u32),
    pub(super) has_alpha: bool,
}

/// Reads what the file stores, without its pixels.
pub(super) fn describe(path: &Path, limits: Limits) -> Result<Kind, Problem> {
    let format = Format::of_content(path)?;
    let (chunks, segments) = beside(path, format, limits)?;
    let mut decoder = decoder(path, limits)?;
    let color = decoder.original_color_type();
    let mut text = if segments.is_cmyk() { "8-bit CMYK".into() } else { kind(color) };
    text += match ColorSpace::of(&chunks)?.curve {
        Curve::Srgb => "",
        Curve::Power(1.0) => ", linear",
        Curve::Power(_) => ", with a gamma",
        Curve::Bt709 => ", with the curve of BT.709",
    };
    if chunks.is_animated() {
        text += ", animated";
    }
    let exif = chunks.get(*b"eXIf").map(<[u8]>::to_vec);
    let exif = exif.or_else(|| decoder.exif_metadata().unwrap_or_default());
    let (width, height) = decoder.dimensions();
    let size =
        if is_sideways(upright(exif.as_deref())) { (height, width) } else { (width, height) };
    Ok(Kind { text, size, has_alpha: decoder.color_type().has_alpha() })
}

fn kind(color: ExtendedColorType) -> String {
    let channels = color.channel_count();
    let name = match channels {
        1 => "gray",
        2 => "gray with alpha",
        3 => "RGB",
        _ => "RGBA",
    };
    format!("{}-bit {name}", color.bits_per_pixel() / u16::from(channels))
}

/// Reads normals, which are stored as `n·0.5+0.5` without a curve.
pub(super) fn read_normals(path: &Path, limits: Limits) -> Result<Image, Problem> {
    let file = LdrFile::load(path, limits)?;
    let opaque = DynamicImage::ImageRgb32F(file.pixels.to_rgb32f());
    let mut image = to_image(&opaque, |v| v)?;
    normals::decode(&mut image);
    Ok(image)
}

/// Most bytes that decoding may take, or a JPEG file may have.
fn most_bytes(limits: Limits) -> u64 {
    limits.pixels.saturating_mul(8).saturating_add(64 << 20)
}

fn decoder(path: &Path, limits: Limits) -> Result<impl ImageDecoder, Problem> {
    let reader = ImageReader::new(BufReader::new(open(path)?)).with_guessed_format();
    let mut reader = reader.map_err(Problem::Read)?;
    let mut most = image::Limits::default();
    most.max_alloc = Some(most_bytes(limits));
    reader.limits(most);
    let decoder = reader.into_decoder().map_err(reading)?;
    let (width, height) = decoder.dimensions();
    limits.check_size(width.into(), height.into())?;
    Ok(decoder)
}

/// Reads the chunks of a PNG or the segments of a JPEG.
fn beside(path: &Path, format: Format, limits: Limits) -> Result<(Chunks, Segments), Problem> {
    if format == Format::Jpeg {
        return Ok((Chunks::default(), Segments::read(path, most_bytes(limits))?));
    }
    let chunks = Chunks::read(BufReader::new(open(path)?)).map_err(Problem::Read)?;
    Ok((chunks, Segments::default()))
}

/// The orientation that turns a picture upright.
fn upright(exif: Option<&[u8]>) -> Orientation {
    exif.and_then(Orientation::from_exif_chunk).unwrap_or(Orientation::NoTransforms)
}

/// The orientation that turns a picture back.
fn inverse(orientation: Orientation) -> Orientation {
    match orientation {
        Orientation::Rotate90 => Orientation::Rotate270,
        Orientation::Rotate270 => Orientation::Rotate90,
        same => same,
    }
}

/// Whether an orientation swaps width and height.
fn is_sideways(orientation: Orientation) -> bool {
    orientation.to_exif() >= 5
}

/// Linear color, premultiplied by alpha if there is one.
fn to_image(pixels: &DynamicImage, linear: impl Fn(f32) -> f32) -> Result<Image, Problem> {
    let size = (pixels.width(), pixels.height());
    let pixels: Vec<_> = if pixels.color().has_alpha() {
        let premultiplied = |[r, g, b, a]: [f32; 4]| [r, g, b].map(|v| linear(v) * a);
        pixels.to_rgba32f().pixels().map(|p| premultiplied(p.0)).collect()
    } else {
        pixels.to_rgb32f().pixels().map(|p| p.0.map(&linear)).collect()
    };
    Image::new(size.0, size.1, pixels).map_err(|e| Problem::Damaged(e.to_string()))
}

fn reading(error: ImageError) -> Problem {
    match error {
        ImageError::IoError(error) if !is_damage(error.kind()) => Problem::Read(error),
        ImageError::Limits(error) => Problem::TooLarge(format!("is too large: {error}")),
        ImageError::Unsupported(error) => {
            Problem::Unsupported(format!("is not supported: {error}"))
        }
        error => Problem::Damaged(format!("is cut off or damaged: {error}")),
    }
}

/// Whether the file is at fault, not the system.
fn is_damage(error: ErrorKind) -> bool {
    matches!(error, ErrorKind::UnexpectedEof | ErrorKind::InvalidData)
}

#[cfg(test)]
mod tests;
