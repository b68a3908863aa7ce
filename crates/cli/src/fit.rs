//! Whether the weights are for what the picture holds.

use super::engine::Engine;
use super::failure::Failure;
use super::jobs::Job;
use super::weights::Source;
use wgdenoise::{Image, Inputs};
use wgdenoise::{MainImage, Metadata, TransferFunction};
use wgdenoise_files::{Format, Picture};

/// Refuses files that cannot hold what the weights are for.
pub(super) fn check(engine: &Engine, job: &Job, picture: &Picture) -> Result<(), Failure> {
    if engine.metadata().transfer_function != TransferFunction::Signed {
        return Ok(());
    }
    let output = Format::of_extension(&job.output).is_ok_and(Format::is_display_referred);
    let file = match (picture.is_display_referred(), output) {
        (true, _) => &job.input,
        (_, true) => &job.output,
        _ => return Ok(()),
    };
    Err(Failure::Work(format!(
        "{}: PNG and JPEG hold colour from 0 to 1, but the weights `{}` are for values from −1 to \
         1, half of which would be lost; use EXR",
        file.display(),
        engine.metadata().name
    )))
}

/// What a user should know of how the weights and the picture differ.
pub(super) fn notices(engine: &Engine, picture: &Picture) -> Vec<String> {
    let metadata = engine.metadata();
    let named = matches!(engine.source, Some(Source::Named(_)));
    let meant = [meant_for(metadata), other_light(metadata, !picture.is_display_referred())];
    let meant = meant.into_iter().flatten().filter(|_| named);
    let given = Inputs { albedo: picture.albedo().is_some(), normal: picture.normal().is_some() };
    meant.chain(unread_inputs(metadata, given)).collect()
}

/// Says what the colour is taken as, if as anything else.
fn meant_for(metadata: &Metadata) -> Option<String> {
    let what = match (metadata.main, metadata.transfer_function) {
        (MainImage::Albedo, _) => "albedo",
        (MainImage::Normal, _) => "normals",
        (MainImage::Color, TransferFunction::Signed) => "directions",
        (MainImage::Color, _) => return None,
    };
    Some(format!(
        "the colour is taken as {what}, which the weights `{}` are for; if another layer holds \
         them, name it by --color",
        metadata.name
    ))
}

/// Says that the weights are for light and the picture is of a display, or the other way round.
fn other_light(metadata: &Metadata, hdr: bool) -> Option<String> {
    let name = &metadata.name;
    match (metadata.main, metadata.transfer_function) {
        (MainImage::Color, TransferFunction::Srgb) if hdr => Some(format!(
            "the weights `{name}` are for what a display shows: light above 1 is cut to 1"
        )),
        (MainImage::Color, curve) if curve.is_hdr() && !hdr => Some(format!(
            "the weights `{name}` are for light of any brightness, but PNG and JPEG hold what a \
             display shows"
        )),
        _ => None,
    }
}

/// Says which images the weights cannot use.
fn unread_inputs(metadata: &Metadata, given: Inputs) -> Option<String> {
    let unread = given.intersection(metadata.inputs) != given;
    unread.then(|| {
        format!("the weights `{}` read {} and nothing else", metadata.name, metadata.inputs)
    })
}

/// Says how many pixels hold no light that can be denoised.
pub(super) fn unusable_pixels(engine: &Engine, color: &Image) -> Vec<String> {
    let signed = engine.metadata().transfer_function == TransferFunction::Signed;
    let count = |is_bad: fn(&[f32; 3]) -> bool| color.pixels().iter().filter(|p| is_bad(p)).count();
    let bad = count(|pixel| pixel.iter().any(|v| !v.is_finite()));
    let negative = count(|pixel| pixel.iter().any(|&v| v.is_finite() && v < 0.0));
    let negative = if signed { 0 } else { negative };
    let pixels = |n: usize| if n == 1 { "1 pixel is".into() } else { format!("{n} pixels are") };
    let filled = format!("{} NaN or infinite and filled from good ones beside them", pixels(bad));
    let black = format!("{} negative; negative values count as 0", pixels(negative));
    [(bad, filled), (negative, black)].into_iter().filter(|(n, _)| *n > 0).map(|(_, s)| s).collect()
}
