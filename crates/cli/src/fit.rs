//! Whether the weights suit the image.

use crate::failure::Failure;
use crate::plan::Job;
use wgdenoise::{Image, Inputs, MainImage, Metadata, TransferFunction};
use wgdenoise_files::{Format, Picture};

/// Refuses files that cannot hold what the weights are for.
pub(crate) fn check(metadata: &Metadata, job: &Job, picture: &Picture) -> Result<(), Failure> {
    if metadata.transfer_function != TransferFunction::Signed {
        return Ok(());
    }
    let output = Format::of_extension(&job.output).is_ok_and(Format::is_display_referred);
    let file = match (picture.is_display_referred(), output) {
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
pub(crate) fn notices(metadata: &Metadata, named: bool, picture: &Picture) -> Vec<String> {
    let meant = [meant_for(metadata), other_light(metadata, !picture.is_display_referred())];
    let meant = meant.into_iter().flatten().filter(|_| named);
    let given = Inputs { albedo: picture.albedo().is_some(), normal: picture.normal().is_some() };
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

/// How many pixels hold no light that can be denoised.
pub(crate) fn unusable_pixels(metadata: &Metadata, color: &Image) -> Vec<String> {
    let signed = metadata.transfer_function == TransferFunction::Signed;
    let count = |is_bad: fn(&[f32; 3]) -> bool| color.pixels().iter().filter(|p| is_bad(p)).count();
    let bad = count(|pixel| pixel.iter().any(|v| !v.is_finite()));
    let negative = count(|pixel| pixel.iter().any(|&v| v.is_finite() && v < 0.0));
    let negative = if signed { 0 } else { negative };
    let pixels = |n: usize| if n == 1 { "1 pixel is".into() } else { format!("{n} pixels are") };
    let filled = format!("{} NaN or infinite; each is filled from its neighbors", pixels(bad));
    let black = format!("{} negative; negative values count as 0", pixels(negative));
    [(bad, filled), (negative, black)].into_iter().filter(|(n, _)| *n > 0).map(|(_, s)| s).collect()
}
