//! Image files: reading color, albedo and normal, and writing the result.
//!
//! The format of an input is recognized by its content, that of an output by its extension. Colors
//! are linear in memory, with Rec. 709 primaries if the file does not say otherwise.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use wgdenoise::Image;

pub mod choice;
pub mod exr;
pub mod guard;
pub mod layers;

mod aux_file;
mod conventions;
mod describe;
mod draft;
mod error;
mod escape;
mod format;
mod identity;
mod jpeg;
mod ldr;
mod limits;
mod normals;
mod output;
mod preview;
mod selection;
mod srgb;
mod stream;
mod wanted;
mod window;

pub use describe::{Description, LayerInfo};
pub use draft::discard_drafts;
pub use error::{FileError, Problem};
pub use escape::{escaped, escaped_json, escaped_lines};
pub use format::{Format, open_file};
pub use identity::Identity;
pub use limits::Limits;
pub use output::Out;
pub use output::check as check_output;
pub use output::check_place;
pub use output::replace;
pub use preview::{Preview, exposed};
pub use selection::Selection;
pub use stream::{is_standard, is_stream};
pub use wanted::LayerChoice;

use self::choice::Choice;
use self::exr::ExrFile;
use self::ldr::LdrFile;
use self::wanted::wish;

/// An image file that has been read, with everything needed to write it with another color.
#[derive(Debug)]
pub struct Picture {
    source: Source,
    color: Image,
    albedo: Option<Image>,
    normal: Option<Image>,
    selection: Option<Selection>,
    notices: Vec<String>,
}

#[derive(Debug)]
enum Source {
    Exr { file: Box<ExrFile>, choice: Box<Choice> },
    Ldr(LdrFile),
}

impl Picture {
    /// Reads color, albedo and normal.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged or too large, or a layer is missing.
    pub fn open(path: &Path, wanted: &LayerChoice) -> Result<Self, FileError> {
        let mut picture = match Format::of_content(path).map_err(|p| p.at(path))? {
            Format::Exr => Self::open_exr(path, wanted)?,
            Format::Png | Format::Jpeg => Self::open_ldr(path, wanted)?,
        };
        picture.decode_normals();
        Ok(picture)
    }

    fn open_exr(path: &Path, wanted: &LayerChoice) -> Result<Self, FileError> {
        let at = |problem: Problem| problem.at(path);
        let file = ExrFile::open(path, wanted.limits).map_err(at)?;
        let parts = file.parts();
        let (albedo, albedo_file) = wish(&parts, wanted.albedo.as_deref(), wanted).map_err(at)?;
        let (normal, normal_file) = wish(&parts, wanted.normal.as_deref(), wanted).map_err(at)?;
        let mut choice =
            choice::choose(&parts, wanted.color.as_deref(), &albedo, &normal).map_err(at)?;
        if wanted.finished && wanted.color.is_none() {
            choice.color = choice.target.clone();
        }
        file.check(&choice.target).map_err(at)?;
        choice.leave_out_unusable(|pick| file.check(pick));
        let [albedo, normal] =
            [&albedo_file, &normal_file].map(|file| file.as_deref().map(Path::to_string_lossy));
        let selection = choice.selection(albedo.as_deref(), normal.as_deref());
        let mut picture = Self::read_layers(file, choice, selection).map_err(at)?;
        picture.add_files(albedo_file, normal_file, wanted.limits)?;
        Ok(picture)
    }

    fn read_layers(file: ExrFile, choice: Choice, selection: Selection) -> Result<Self, Problem> {
        let aux = [&choice.albedo, &choice.normal];
        let picks: Vec<_> = [&choice.color].into_iter().chain(aux.into_iter().flatten()).collect();
        let to = file.window(choice.color.part);
        let mut notices = selection.left_out.clone();
        let mut images = file.read(&picks)?.into_iter().zip(&picks).map(|(image, pick)| {
            let from = file.window(pick.part);
            if from != to {
                notices.push(window::notice(&pick.layer, from, to));
            }
            window::align(image, from, to)
        });
        let color = images.next().transpose()?.expect("the color is always picked");
        let albedo = choice.albedo.as_ref().and_then(|_| images.next()).transpose()?;
        let normal = choice.normal.as_ref().and_then(|_| images.next()).transpose()?;
        drop(images);
        let (file, choice) = (Box::new(file), Box::new(choice));
        let (source, selection) = (Source::Exr { file, choice }, Some(selection));
        Ok(Self { source, color, albedo, normal, selection, notices })
    }

    fn open_ldr(path: &Path, wanted: &LayerChoice) -> Result<Self, FileError> {
        if let Some(layer) = &wanted.color {
            return Err(no_layers(layer).at(path));
        }
        let (file, color) = LdrFile::read(path, wanted.limits).map_err(|p| p.at(path))?;
        let wish =
            |name: &Option<OsString>| name.clone().filter(|_| !wanted.no_aux).map(PathBuf::from);
        let (albedo_file, normal_file) = (wish(&wanted.albedo), wish(&wanted.normal));
        let from = |what, file: &Option<PathBuf>| {
            let shown = file.as_ref().map(|file| escaped(&file.to_string_lossy()));
            shown.map(|file| format!("{what} from the file {file}"))
        };
        let notices = [from("albedo", &albedo_file), from("normal", &normal_file)];
        let notices = notices.into_iter().flatten().collect();
        let source = Source::Ldr(file);
        let mut picture =
            Self { source, color, albedo: None, normal: None, selection: None, notices };
        picture.add_files(albedo_file, normal_file, wanted.limits)?;
        Ok(picture)
    }

    /// Reads albedo and normal from files of their own.
    fn add_files(
        &mut self,
        albedo: Option<PathBuf>,
        normal: Option<PathBuf>,
        limits: Limits,
    ) -> Result<(), FileError> {
        let size = self.color.size();
        if let Some(path) = albedo {
            self.albedo = Some(aux_file::albedo(&path, size, limits)?);
        }
        if let Some(path) = normal {
            self.normal = Some(aux_file::normal(&path, size, limits)?);
        }
        Ok(())
    }

    fn decode_normals(&mut self) {
        if self.normal.as_mut().is_some_and(normals::decode_if_encoded) {
            self.notices.push("the normals were stored as n·0.5+0.5 and have been decoded".into());
        }
    }

    /// The noisy color: linear, and scene-referred unless the file is PNG or JPEG.
    #[must_use]
    pub fn color(&self) -> &Image {
        &self.color
    }

    /// Whether the left and the right edge of the picture touch: it is an EXR file whose attribute
    /// `envmap` says latlong.
    #[must_use]
    pub fn is_panorama(&self) -> bool {
        match &self.source {
            Source::Exr { file, choice } => file.is_panorama(choice.color.part),
            Source::Ldr(_) => false,
        }
    }

    /// Whether the file is display-referred, as PNG and JPEG are: color from 0 to 1.
    #[must_use]
    pub fn is_display_referred(&self) -> bool {
        matches!(self.source, Source::Ldr(_))
    }

    /// The albedo in [0, 1], of the color's size.
    #[must_use]
    pub fn albedo(&self) -> Option<&Image> {
        self.albedo.as_ref()
    }

    /// The normals in [−1, 1], of the color's size.
    #[must_use]
    pub fn normal(&self) -> Option<&Image> {
        self.normal.as_ref()
    }

    /// The layers that were read; `None` for PNG and JPEG, which have none.
    #[must_use]
    pub fn selection(&self) -> Option<&Selection> {
        self.selection.as_ref()
    }

    /// What a user should know about how the file was read, a sentence each.
    #[must_use]
    pub fn notices(&self) -> &[String] {
        &self.notices
    }

    /// Writes the picture with `denoised` in place of its color, in the format of `path`'s
    /// extension. Returns what a user should know about it, a sentence each.
    ///
    /// # Errors
    /// If `path` exists and `force` is not given, or it cannot be written. A file that was there
    /// stays as it was.
    pub fn save(
        &self,
        path: &Path,
        denoised: &Image,
        force: bool,
    ) -> Result<Vec<String>, FileError> {
        let format = Format::of_extension(path).map_err(|p| p.at(path))?;
        self.save_as(path, format, denoised, force)
    }

    /// Writes the picture like [`save`](Self::save), in a format of its own. `-` is standard output.
    ///
    /// # Errors
    /// Those of [`save`](Self::save).
    pub fn save_as(
        &self,
        path: &Path,
        format: Format,
        denoised: &Image,
        force: bool,
    ) -> Result<Vec<String>, FileError> {
        check_place(path, force)?;
        if denoised.size() != self.color.size() {
            return Err(window::other_size(denoised.size(), self.color.size()).at(path));
        }
        replace(path, force, |out| match (&self.source, format) {
            (Source::Exr { file, choice }, Format::Exr) => save_exr(file, choice, denoised, out),
            (Source::Ldr(file), Format::Exr) => {
                let alpha = file.alpha();
                let with = if alpha.is_some() { ", and alpha as it is," } else { "" };
                exr::write_rgb(out, denoised, alpha)?;
                Ok(vec![format!("written as linear R, G, B{with} in 32-bit float")])
            }
            (Source::Exr { .. }, format) => ldr::write_new(out, format, denoised),
            (Source::Ldr(file), format) => file.write(out, format, denoised),
        })
    }
}

/// PNG and JPEG files have no layers.
fn no_layers(wanted: &str) -> Problem {
    Problem::Layers(format!("has no layers, so no layer `{}`", escaped(wanted)))
}

fn save_exr(
    file: &ExrFile,
    choice: &Choice,
    denoised: &Image,
    out: &mut Out<'_>,
) -> Result<Vec<String>, Problem> {
    let target = &choice.target;
    let clamped = file.write(out, target, file.window(choice.color.part), denoised)?;
    let mut notices = Vec::new();
    if clamped > 0 {
        notices.push(format!(
            "{clamped} values exceed 65504, the largest half float, and were clamped"
        ));
    }
    if file.rewrites_others_lossily(target) {
        notices.push(format!(
            "other channels in the part of `{}` went through its lossy compression again and \
             may have changed slightly",
            escaped(&target.layer)
        ));
    }
    if file.has_levels(target.part) {
        notices.push("only the largest mip level was denoised".into());
    }
    Ok(notices)
}

#[cfg(test)]
mod tests;
