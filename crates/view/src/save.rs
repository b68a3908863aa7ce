//! Saves the result, and a picture of the comparison.

use std::path::{Path, PathBuf};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _};
use wgdenoise_files::{Denoised, FileError, Format, Identity, Out, Problem, escaped, replace};

use crate::open::{Opened, sentence};
use crate::picture::Pixels;
use crate::state::settling::Stamp;

/// The suggested name for a result, such as `render.denoised.exr`.
pub(crate) fn suggested(input: &Path, what: &str, extension: Option<&str>) -> PathBuf {
    let stem = input.file_stem().unwrap_or_default().to_string_lossy();
    let own = || input.extension().map_or("exr".into(), |e| e.to_string_lossy().to_lowercase());
    let extension = extension.map_or_else(own, str::to_string);
    input.with_file_name(format!("{stem}.{what}.{extension}"))
}

/// Saves the result as the command line would, over a file that the user agreed to replace. Returns
/// a message for the user.
///
/// # Errors
/// If the file is the input, has an unknown extension, or cannot be written, or if the input has
/// changed since it was read.
pub(crate) fn result(opened: &Opened, results: &[Denoised], path: &Path) -> Result<String, String> {
    refuse_input(opened, path)?;
    refuse_changed(opened)?;
    let saved = || -> Result<Vec<String>, FileError> {
        let format = Format::of_extension(path).map_err(|problem| problem.at(path))?;
        opened.picture.save_as(path, format, results, true)
    };
    let notices = saved().map_err(|error| sentence(&error))?;
    Ok(told(path, &notices))
}

/// Writes a picture as 8-bit PNG.
///
/// # Errors
/// If the file is the input, is not called `.png`, or cannot be written.
pub(crate) fn picture(opened: &Opened, pixels: &Pixels, path: &Path) -> Result<String, String> {
    refuse_input(opened, path)?;
    if !matches!(Format::of_extension(path), Ok(Format::Png)) {
        let name = escaped(&path.to_string_lossy());
        return Err(format!("{name}: comparisons are PNG files; give a name that ends in .png"));
    }
    let [width, height] = pixels.size;
    let bytes = pixels.rgb.as_flattened();
    let write = |out: &mut Out<'_>| {
        let encoder = PngEncoder::new(out);
        let written = encoder.write_image(bytes, width, height, ExtendedColorType::Rgb8);
        written.map_err(|error| Problem::Write(std::io::Error::other(error)))
    };
    replace(path, true, write).map_err(|error| sentence(&error))?;
    Ok(told(path, &[]))
}

fn refuse_input(opened: &Opened, path: &Path) -> Result<(), String> {
    if Identity::of(path) != Identity::of(&opened.path) {
        return Ok(());
    }
    Err(format!("{}: is the noisy image; give another name", escaped(&path.to_string_lossy())))
}

/// Refuses a changed input, because everything but the light is copied from it. A deleted one stays
/// readable.
fn refuse_changed(opened: &Opened) -> Result<(), String> {
    match Stamp::of(&opened.path) {
        now @ Some(_) if now != opened.stamp => {
            Err(format!("{}: has changed since it was opened; open it again", opened.name()))
        }
        _ => Ok(()),
    }
}

fn told(path: &Path, notices: &[String]) -> String {
    let saved = format!("saved {}", escaped(&path.to_string_lossy()));
    [std::slice::from_ref(&saved), notices].concat().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggested_names_stand_next_to_the_input() {
        let name = |input: &str, extension| suggested(Path::new(input), "denoised", extension);
        assert_eq!(name("a/b.0001.EXR", None), Path::new("a/b.0001.denoised.exr"));
        assert_eq!(name("b", None), Path::new("b.denoised.exr"));
        assert_eq!(name("b.exr", Some("png")), Path::new("b.denoised.png"));
    }
}
