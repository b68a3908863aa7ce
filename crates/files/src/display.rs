//! Prepares EXR pictures for display: cropped to the display window, in sRGB's primaries.

use std::borrow::Cow;
use std::io::Write;

use ::exr::meta::attribute::Chromaticities;
use ::exr::meta::header::Header;
use image::{ColorType, DynamicImage};

use super::format::Format;
use super::ldr::curve::Curve;
use super::ldr::density::{self, Density};
use super::ldr::encode::{Encoded, paint};
use super::limits::Limits;
use super::window::{self, Place};
use super::{Problem, primaries};
use wgdenoise::Image;

/// How to show a file's pixels.
#[derive(Clone, Debug)]
pub(super) struct Display {
    place: Place,
    /// `None` for sRGB's, and for values that are not color.
    primaries: Option<Chromaticities>,
    /// Pixel width over height.
    aspect: f32,
}

impl Display {
    /// For the part of an EXR file with this header. Without an attribute, primaries are those of
    /// sRGB.
    pub(super) fn of(header: &Header) -> Self {
        let shared = &header.shared_attributes;
        let primaries =
            shared.chromaticities.filter(|p| !primaries::are_alike(p, &primaries::SRGB));
        Self { place: Place::of(header), primaries, aspect: shared.pixel_aspect }
    }

    /// For a picture that is shown whole.
    pub(super) fn whole(size: (u32, u32), primaries: Option<Chromaticities>, aspect: f32) -> Self {
        Self { place: Place::sized(size), primaries, aspect }
    }

    /// The same, for values that are not color.
    pub(super) fn of_data(self) -> Self {
        Self { primaries: None, ..self }
    }

    /// Returns the picture to write and what a user should know about it, one sentence each.
    /// `color` is linear and premultiplied by `alpha`.
    ///
    /// # Errors
    /// If the display window is larger than `limits` accept.
    pub(super) fn show<'a>(
        &self,
        color: &Image,
        alpha: Option<&'a [f32]>,
        limits: Limits,
    ) -> Result<(Shown<'a>, Vec<String>), Problem> {
        let (mut color, alpha) = self.within_window(color, alpha, limits)?;
        let (alpha, unmeant) = meant(&color, alpha);
        let has_shape = density::is_storable(self.aspect);
        let aspect = if has_shape { self.aspect } else { 1.0 };
        let mut notices = Vec::new();
        notices.extend(unmeant);
        notices.extend(self.place.is_cropped().then(|| self.place.cropping()));
        notices.extend(self.convert(&mut color));
        notices.extend((self.aspect != 1.0).then(|| self.shape(has_shape)));
        Ok((Shown { color, alpha, aspect }, notices))
    }

    /// Crops to the display window; pixels that are not covered are black, and transparent if there
    /// is alpha.
    fn within_window<'a>(
        &self,
        color: &Image,
        alpha: Option<&'a [f32]>,
        limits: Limits,
    ) -> Result<(Image, Alpha<'a>), Problem> {
        let Place { data, display, .. } = self.place;
        if data == display {
            return Ok((color.clone(), alpha.map(Cow::Borrowed)));
        }
        limits.check_size(display.size.width() as u64, display.size.height() as u64)?;
        let moved = |image| window::align(image, data, display);
        let covered = |alpha: &[f32]| {
            let gray = alpha.iter().map(|&a| [a; 3]).collect();
            let image = Image::new(color.width(), color.height(), gray);
            let image = moved(image.map_err(|e| Problem::Size(e.to_string()))?)?;
            Ok(Cow::Owned(image.pixels().iter().map(|pixel| pixel[0]).collect()))
        };
        Ok((moved(color.clone())?, alpha.map(covered).transpose()?))
    }

    fn convert(&self, color: &mut Image) -> Option<String> {
        let primaries = self.primaries.as_ref()?;
        Some(if primaries::convert_to_srgb(color, primaries) {
            "converted from the file's primaries to those of sRGB".into()
        } else {
            "the file's chromaticities make no color space and were ignored".into()
        })
    }

    fn shape(&self, is_written: bool) -> String {
        let aspect = self.aspect;
        if is_written {
            format!("pixels are {aspect} times as wide as high, which is written as pixel density")
        } else {
            format!("the file's pixel aspect ratio of {aspect} cannot be written and was left out")
        }
    }
}

/// Alpha per pixel, row by row, if there is any.
type Alpha<'a> = Option<Cow<'a, [f32]>>;

/// A picture ready for display.
#[derive(Debug)]
pub(super) struct Shown<'a> {
    color: Image,
    /// `None` if the picture is opaque.
    alpha: Alpha<'a>,
    aspect: f32,
}

impl Shown<'_> {
    /// Writes a new 8-bit PNG or JPEG; returns notices on what it holds and what it cannot show.
    pub(super) fn write(
        &self,
        out: &mut impl Write,
        format: Format,
    ) -> Result<Vec<String>, Problem> {
        let (color, alpha) = (&self.color, self.alpha.as_deref());
        let straight = alpha.filter(|_| format.has_alpha());
        let kind = if straight.is_some() { ColorType::Rgba8 } else { ColorType::Rgb8 };
        let blank = DynamicImage::new_rgba8(color.width(), color.height());
        let pixels = paint(&blank, color, alpha, Curve::Srgb, kind);
        let density = Density::of_aspect(self.aspect);
        Encoded { density, ..Encoded::new(pixels) }.write(out, format)?;
        let what = match (straight, alpha) {
            (Some(_), _) => "only the color, divided by its alpha,",
            (None, Some(_)) => "only the color, over black since JPEG has no alpha,",
            (None, None) => "only the color,",
        };
        let mut notices = vec![format!("wrote {what} clipped to [0, 1], sRGB-encoded, in 8 bits")];
        match straight.map_or(0, |alpha| hidden(color, alpha)) {
            0 => {}
            hidden => notices.push(format!(
                "pixels with light but no alpha, such as glows, cannot be shown by PNG: {hidden}"
            )),
        }
        Ok(notices)
    }
}

/// Drops alpha of 1 everywhere, and alpha of 0 everywhere if it would hide a picture: some
/// renderers write that for want of another. Returns a notice about the latter.
fn meant<'a>(color: &Image, alpha: Alpha<'a>) -> (Alpha<'a>, Option<String>) {
    let hides_all = |alpha: &mut Cow<'_, [f32]>| {
        alpha.iter().all(|&a| covers_nothing(a)) && hidden(color, alpha) > 0
    };
    let mut alpha = alpha.filter(|alpha| alpha.iter().any(|&a| a != 1.0));
    let unmeant = alpha.take_if(hides_all);
    (alpha, unmeant.map(|_| "alpha is 0 everywhere and was left out".into()))
}

/// Whether alpha is 0, negative or NaN.
fn covers_nothing(alpha: f32) -> bool {
    alpha.is_nan() || alpha <= 0.0
}

/// Counts pixels with light that 8 bits can show, but no alpha.
fn hidden(color: &Image, alpha: &[f32]) -> usize {
    let is_light = |v: &f32| Curve::Srgb.encoded(*v) * 255.0 >= 0.5;
    let pixels = color.pixels().iter().zip(alpha);
    pixels.filter(|(pixel, a)| covers_nothing(**a) && pixel.iter().any(is_light)).count()
}

#[cfg(test)]
#[path = "display_test.rs"]
mod tests;
