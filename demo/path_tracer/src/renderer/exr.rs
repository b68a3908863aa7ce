//! Images as one OpenEXR file, with channels named as renderers name them.

use std::path::Path;

use exr::prelude::*;

/// A layer's prefix, the names of its channels, and its pixels.
pub(crate) type Layer<'a> = (&'a str, &'a [&'a str], &'a [[f32; 4]]);

/// Colour and coverage: the plain layer.
pub(crate) const COLOR: (&str, &[&str]) = ("", &["R", "G", "B", "A"]);
/// Reflectance.
pub(crate) const ALBEDO: (&str, &[&str]) = ("albedo.", &["R", "G", "B"]);
/// Normals.
pub(crate) const NORMAL: (&str, &[&str]) = ("normal.", &["X", "Y", "Z"]);

/// Writes layers of 32-bit floats into one part.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn write(
    path: &Path,
    [width, height]: [u32; 2],
    layers: &[Layer<'_>],
) -> super::Result<()> {
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
    let failed = |error| format!("{} cannot be written: {error}", path.display());
    Ok(Image::from_layer(layer).write().to_file(path).map_err(failed)?)
}
