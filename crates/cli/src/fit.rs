//! Whether the weights suit the image.

use crate::failure::Failure;
use crate::plan::Job;
use wgdenoise::{Image, Inputs, MainImage, Metadata, Topology, TransferFunction};
use wgdenoise_files::{Picture, View};

/// Refuses files that cannot hold what the weights are for.
pub(crate) fn check(metadata: &Metadata, job: &Job, picture: &Picture) -> Result<(), Failure> {
    if metadata.transfer_function != TransferFunction::Signed {
        return Ok(());
    }
    let file = match (picture.is_display_referred(), job.format.is_display_referred()) {
        (true, _) => &job.input,
        (_, true) => &job.output,
        _ => return Ok(()),
    };
    Err(Failure::of(
        file,
        format_args!(
            "PNG and JPEG hold values from 0 to 1, but the weights `{}` are for values from −1 to \
             1, half of which would be lost; use EXR",
            metadata.name
        ),
    ))
}

/// What a user should know about how the weights and the image differ.
pub(crate) fn notices(metadata: &Metadata, named: bool, view: &View, hdr: bool) -> Vec<String> {
    let meant = [meant_for(metadata), other_light(metadata, hdr)];
    let meant = meant.into_iter().flatten().filter(|_| named);
    let given = Inputs { albedo: view.albedo().is_some(), normal: view.normal().is_some() };
    meant.chain(unread_inputs(metadata, given)).collect()
}

/// Weights that take the color for something else.
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

/// Weights for scene-referred light on a display-referred image, or the reverse.
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

/// Images that the weights cannot use.
fn unread_inputs(metadata: &Metadata, given: Inputs) -> Option<String> {
    let unread = given.intersection(metadata.inputs) != given;
    unread.then(|| {
        format!("the weights `{}` read {} and nothing else", metadata.name, metadata.inputs)
    })
}

/// How many pixels hold no light that can be denoised as it is.
pub(crate) fn unusable_pixels(metadata: &Metadata, color: &Image) -> Vec<String> {
    let signed = metadata.transfer_function == TransferFunction::Signed;
    let has = |pixel: &[f32; 3], is_bad: fn(f32) -> bool| pixel.iter().any(|&v| is_bad(v));
    let is_missing = |p: &[f32; 3]| has(p, |v| v.is_nan() || v == f32::NEG_INFINITY);
    let is_infinite = |p: &[f32; 3]| has(p, |v| v == f32::INFINITY);
    let count =
        |is_bad: &dyn Fn(&[f32; 3]) -> bool| color.pixels().iter().filter(|p| is_bad(p)).count();
    let missing = count(&|p| is_missing(p) || signed && is_infinite(p));
    let infinite = count(&|p| !signed && is_infinite(p) && !is_missing(p));
    let clips = !signed && metadata.topology != Topology::KernelPyramid;
    let negative = count(&|p| clips && has(p, |v| v.is_finite() && v < 0.0));
    let pixels = |n: usize| if n == 1 { "1 pixel is".into() } else { format!("{n} pixels are") };
    let missing = (missing, "NaN or −∞; each is filled from its neighbors");
    let infinite =
        (infinite, "infinite; four or more together count as very bright, fewer are filled");
    let negative = (negative, "negative; negative values count as 0");
    let found = [missing, infinite, negative].into_iter().filter(|(n, _)| *n > 0);
    found.map(|(n, what)| format!("{} {what}", pixels(n))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgdenoise::{Quality, Weights};

    #[test]
    fn pixels_that_are_no_light_are_counted_by_what_becomes_of_them() {
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        let pixels = [[nan, inf, 1.0], [-inf, 0.0, 0.0], [inf, -1.0, 2.0], [1.0; 3]];
        let image = Image::new(4, 1, pixels.to_vec()).expect("the count is right");
        let weights = Weights::builtin(Quality::Fast).expect("they are built in");
        let mut expected = vec![
            "2 pixels are NaN or −∞; each is filled from its neighbors",
            "1 pixel is infinite; four or more together count as very bright, fewer are filled",
        ];
        let mut metadata = weights.metadata().clone();
        metadata.topology = Topology::KernelPyramid;
        assert_eq!(unusable_pixels(&metadata, &image), expected, "wide gamuts stay");
        metadata.topology = Topology::Unet;
        expected.push("1 pixel is negative; negative values count as 0");
        assert_eq!(unusable_pixels(&metadata, &image), expected);
    }
}
