//! Whether the weights are for what the picture holds.

use super::engine::Engine;
use crate::files::Picture;
use crate::model::{Metadata, TransferFunction};
use crate::{Image, Inputs};

/// What a user should know of how the weights and the picture differ.
pub(super) fn notices(engine: &Engine, picture: &Picture) -> Vec<String> {
    let metadata = engine.metadata();
    let given = Inputs { albedo: picture.albedo().is_some(), normal: picture.normal().is_some() };
    unread_inputs(metadata, given).into_iter().collect()
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
