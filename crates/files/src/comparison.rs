//! What a user should know before comparing two pictures pixel by pixel.

use super::Picture;
use super::escape::escaped;
use super::primaries::{self, SRGB};

/// How the first views of a picture and its reference differ other than in their values, one
/// sentence each.
#[must_use]
pub fn differences(image: &Picture, reference: &Picture) -> Vec<String> {
    [views(image, reference), places(image, reference), colors(image, reference)]
        .into_iter()
        .flatten()
        .collect()
}

fn views(image: &Picture, reference: &Picture) -> Option<String> {
    let name = |picture: &Picture| match picture.first().name() {
        Some(name) => format!("`{}`", escaped(name)),
        None => "the only view".into(),
    };
    let several = [image, reference].iter().any(|picture| picture.views().len() > 1);
    several.then(|| {
        let (image, reference) = (name(image), name(reference));
        format!("only one view is compared: {image} with {reference}; --color names another")
    })
}

fn places(image: &Picture, reference: &Picture) -> Option<String> {
    let [a, b] = [image, reference].map(|picture| picture.first().corner());
    (a != b).then(|| {
        format!(
            "the first pixel is at ({}, {}) in the image and at ({}, {}) in the reference; they are \
             compared with each other",
            a[0], a[1], b[0], b[1]
        )
    })
}

fn colors(image: &Picture, reference: &Picture) -> Option<String> {
    let [a, b] = [image, reference].map(|picture| picture.primaries().unwrap_or(SRGB));
    let differ = !primaries::are_alike(&a, &b);
    differ.then(|| "the files have different primaries; values are compared as they are".into())
}
