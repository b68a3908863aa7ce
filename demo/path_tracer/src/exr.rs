//! Writes layers into one OpenEXR file, with the channel names that renderers use.

use std::io;
use std::path::Path;

use exr::prelude::*;
use wgdenoise_files::{Problem, replace};

/// A layer's prefix, its channel names, and its pixels, row by row from the top left.
pub type Layer<'a> = (&'a str, &'a [&'a str], &'a [[f32; 4]]);

/// Prefix and channels of linear color and coverage.
pub const COLOR: (&str, &[&str]) = ("", &["R", "G", "B", "A"]);
/// Prefix and channels of the reflectance.
pub const ALBEDO: (&str, &[&str]) = ("albedo.", &["R", "G", "B"]);
/// Prefix and channels of world-space normals.
pub const NORMAL: (&str, &[&str]) = ("normal.", &["X", "Y", "Z"]);
/// Prefix and channels of motion vectors.
pub const MOTION: (&str, &[&str]) = ("motion.", &["X", "Y"]);
/// Prefix and channel of depth.
pub const DEPTH: (&str, &[&str]) = ("", &["Z"]);

/// Writes the layers as 32-bit floats into a single part. A file at `path` is replaced only once
/// the new one is complete.
///
/// # Errors
/// If the file cannot be written.
pub fn write(
    path: &Path,
    [width, height]: [u32; 2],
    layers: &[Layer<'_>],
) -> crate::renderer::Result<()> {
    let channels = layers.iter().flat_map(|(prefix, names, pixels)| {
        names.iter().enumerate().map(move |(index, name)| {
            let samples = pixels.iter().map(|pixel| pixel[index]).collect();
            AnyChannel::new(format!("{prefix}{name}").as_str(), FlatSamples::F32(samples))
        })
    });
    let layer = exr::image::Layer::new(
        (width as usize, height as usize),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(channels.collect()),
    );
    let image = Image::from_layer(layer);
    let failed = |error| Problem::Write(io::Error::other(error));
    Ok(replace(path, true, |out| image.write().to_buffered(out).map_err(failed))?)
}
