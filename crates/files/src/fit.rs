//! Whether weights suit an image, and whether to denoise its alpha.

use std::path::Path;

use super::{FileError, Format, Picture, Problem, View};
use wgdenoise::{Image, Inputs, MainImage, Metadata, Topology, TransferFunction};

/// Refuses an input or an output that cannot hold the values that the weights are for.
///
/// # Errors
/// If the weights are for values from −1 to 1 and the picture or the output, given with its format,
/// holds values from 0 to 1.
pub fn check(
    metadata: &Metadata,
    picture: &Picture,
    input: &Path,
    output: Option<(&Path, Format)>,
) -> Result<(), FileError> {
    let output = output.filter(|(_, format)| format.is_display_referred());
    let file = match (picture.is_display_referred(), output) {
        _ if metadata.transfer_function != TransferFunction::Signed => return Ok(()),
        (true, _) => input,
        (_, Some((output, _))) => output,
        _ => return Ok(()),
    };
    let what = format!(
        "PNG and JPEG hold values from 0 to 1, but the weights `{}` are for values from −1 to 1, \
         half of which would be lost; use EXR",
        metadata.name
    );
    Err(Problem::Format(what).at(file))
}

/// What to do with the alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Alpha {
    /// Denoise it if it is fractional anywhere and the weights can do it.
    #[default]
    Auto,
    /// Leave it as it is.
    Keep,
    /// Denoise it.
    Denoise,
}

/// Whether to denoise a view's alpha, and what a user should know about that. `format` is the
/// output's, if known.
#[must_use]
pub fn alpha(
    wish: Alpha,
    view: &View,
    format: Option<Format>,
    metadata: &Metadata,
) -> (bool, Option<&'static str>) {
    let has_place = format.is_none_or(Format::has_alpha);
    let takes_alpha = metadata.topology == Topology::KernelPyramid;
    match wish {
        Alpha::Denoise if view.alpha().is_none() => (false, Some("found no alpha to denoise")),
        Alpha::Denoise if !has_place => (false, Some("JPEG has no alpha to denoise")),
        Alpha::Denoise => (true, None),
        Alpha::Keep => (false, None),
        Alpha::Auto if !has_place || !view.has_fractional_alpha() => (false, None),
        Alpha::Auto if takes_alpha => (true, Some("alpha is denoised by the color's weights")),
        Alpha::Auto => (false, Some("alpha stays noisy: only a kernel pyramid can denoise it")),
    }
}

/// Says how the weights and the image differ, one sentence each. Whether they suit each other is
/// only reported for weights that the user `named`; `hdr` means that the image is scene-referred.
#[must_use]
pub fn notices(metadata: &Metadata, named: bool, view: &View, hdr: bool) -> Vec<String> {
    let meant = [meant_for(metadata), other_light(metadata, hdr)];
    let meant = meant.into_iter().flatten().filter(|_| named);
    let given = Inputs { albedo: view.albedo().is_some(), normal: view.normal().is_some() };
    meant.chain(unread_inputs(metadata, given)).collect()
}

/// Reports weights that take the color for something else.
fn meant_for(metadata: &Metadata) -> Option<String> {
    let what = match (metadata.main, metadata.transfer_function) {
        (MainImage::Albedo, _) => "albedo",
        (MainImage::Normal, _) => "normals",
        (MainImage::Color, TransferFunction::Signed) => "directions",
        (MainImage::Color, _) => return None,
    };
    Some(format!(
        "the color is taken as {what}, which the weights `{}` are for; if another layer holds \
         them, name it with --color",
        metadata.name
    ))
}

/// Reports weights for scene-referred light on a display-referred image, or the reverse.
fn other_light(metadata: &Metadata, hdr: bool) -> Option<String> {
    let name = &metadata.name;
    match (metadata.main, metadata.transfer_function) {
        (MainImage::Color, TransferFunction::Srgb) if hdr => Some(format!(
            "the weights `{name}` are for display colors: light above 1 is clipped to 1"
        )),
        (MainImage::Color, curve) if curve.is_hdr() && !hdr => Some(format!(
            "the weights `{name}` are for light of any brightness, but PNG and JPEG hold display \
             colors"
        )),
        _ => None,
    }
}

/// Reports images that the weights do not read.
fn unread_inputs(metadata: &Metadata, given: Inputs) -> Option<String> {
    let unread = given.intersection(metadata.inputs) != given;
    unread.then(|| {
        format!("the weights `{}` read {} and nothing else", metadata.name, metadata.inputs)
    })
}

/// Counts pixels whose light cannot be denoised as it is, one sentence for each reason.
#[must_use]
pub fn unusable_pixels(metadata: &Metadata, color: &Image) -> Vec<String> {
    let signed = metadata.transfer_function == TransferFunction::Signed;
    let pyramid = metadata.topology == Topology::KernelPyramid;
    let has = |pixel: &[f32; 3], is_bad: fn(f32) -> bool| pixel.iter().any(|&v| is_bad(v));
    let is_missing = |p: &[f32; 3]| has(p, |v| v.is_nan() || v == f32::NEG_INFINITY);
    let is_infinite = |p: &[f32; 3]| has(p, |v| v == f32::INFINITY);
    let is_finite = |p: &[f32; 3]| !is_missing(p) && !is_infinite(p);
    let count = |applies: bool, is_bad: &dyn Fn(&[f32; 3]) -> bool| {
        if applies { color.pixels().iter().filter(|p| is_bad(p)).count() } else { 0 }
    };
    let found = [
        (
            count(true, &|p| is_missing(p) || signed && is_infinite(p)),
            "NaN or −∞; each is filled from its neighbors",
        ),
        (
            count(!signed, &|p| is_infinite(p) && !is_missing(p)),
            "infinite; four or more together count as very bright, fewer are filled",
        ),
        (
            count(!signed && !pyramid, &|p| has(p, |v| v.is_finite() && v < 0.0)),
            "negative; negative values count as 0",
        ),
        (
            count(!signed && pyramid, &|p| is_finite(p) && luminance(p) < 0.0),
            "of negative luminance; negative values there count as 0",
        ),
        (count(!signed, &|p| has(p, is_beyond)), "beyond ±1e30; such values count as ±1e30"),
    ];
    let pixels = |n: usize| if n == 1 { "1 pixel is".into() } else { format!("{n} pixels are") };
    let found = found.into_iter().filter(|(n, _)| *n > 0);
    found.map(|(n, what)| format!("{} {what}", pixels(n))).collect()
}

/// The luminance of linear color with Rec. 709 primaries.
fn luminance(pixel: &[f32; 3]) -> f32 {
    LUMINANCE.iter().zip(pixel).map(|(share, v)| share * v).sum()
}

fn is_beyond(value: f32) -> bool {
    value.is_finite() && value.abs() > 1e30
}

/// The luminance weights of the channels, as in `weights-format.md`.
const LUMINANCE: [f32; 3] = [0.212_671, 0.715_160, 0.072_169];

#[cfg(test)]
mod tests {
    use super::*;

    /// The metadata of weights for scene-referred color, albedo and normals.
    fn metadata() -> Metadata {
        let fixture = "../../tests/fixtures/oidn/rt_hdr_alb_nrm.tza";
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(fixture);
        crate::weights::load(&path).expect("a weights file").metadata().clone()
    }

    #[test]
    fn alpha_is_denoised_if_it_is_asked_for_or_fractional_and_has_a_place() {
        let image = Image::filled(2, 1, [0.5; 3]).expect("a valid image");
        let view = |alpha: Option<[f32; 2]>| View::of_color(image.clone(), alpha.map(Vec::from));
        let mut metadata = metadata();
        metadata.topology = Topology::KernelPyramid;
        let [fractional, solid] = [[0.5, 1.0], [0.0, 1.0]].map(Some);
        let denoises = |wish, given, format| alpha(wish, &view(given), format, &metadata).0;
        assert!(denoises(Alpha::Auto, fractional, None));
        assert!(denoises(Alpha::Auto, fractional, Some(Format::Png)));
        assert!(!denoises(Alpha::Auto, fractional, Some(Format::Jpeg)));
        assert!(!denoises(Alpha::Auto, solid, None) && denoises(Alpha::Denoise, solid, None));
        assert!(!denoises(Alpha::Keep, fractional, None) && !denoises(Alpha::Denoise, None, None));
        metadata.topology = Topology::Unet;
        let (denoises, why) = alpha(Alpha::Auto, &view(fractional), None, &metadata);
        assert!(!denoises && why.is_some_and(|why| why.contains("stays noisy")));
    }

    #[test]
    fn pixels_that_are_no_light_are_counted_by_what_becomes_of_them() {
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        let broken = [[nan, inf, 1.0], [-inf, 0.0, 0.0], [inf, -1.0, 2.0], [1.0; 3]];
        let of_wide_gamut = [-0.1, 1.0, -0.1];
        let dark = [0.1, -0.1, 0.1];
        let pixels = [broken.as_slice(), &[of_wide_gamut, dark, [1e31, 0.0, 0.0]]].concat();
        let image = Image::new(7, 1, pixels).expect("the count is right");
        let of_topology = |topology| {
            let mut metadata = metadata();
            metadata.topology = topology;
            unusable_pixels(&metadata, &image)
        };
        let missing = "2 pixels are NaN or −∞; each is filled from its neighbors";
        let infinite =
            "1 pixel is infinite; four or more together count as very bright, fewer are filled";
        let dark = "1 pixel is of negative luminance; negative values there count as 0";
        let negative = "3 pixels are negative; negative values count as 0";
        let beyond = "1 pixel is beyond ±1e30; such values count as ±1e30";
        assert_eq!(of_topology(Topology::KernelPyramid), [missing, infinite, dark, beyond]);
        assert_eq!(of_topology(Topology::Unet), [missing, infinite, negative, beyond]);
    }
}
