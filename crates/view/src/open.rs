//! Opens files, with the command line's checks and messages.

use std::path::{Path, PathBuf};

use wgdenoise_files::{FileError, LayerChoice, LayersWish, Picture, Problem, View, escaped};

use crate::state::settling::Stamp;

/// An open file.
#[derive(Debug)]
pub(crate) struct Opened {
    pub(crate) path: PathBuf,
    pub(crate) picture: Picture,
    /// Index of the shown view; all views are denoised and saved.
    pub(crate) shown: usize,
    /// The choices it was read with.
    pub(crate) wish: Wish,
    /// The file's stamp from before it was read; later versions differ.
    pub(crate) stamp: Option<Stamp>,
}

/// The user's choices of what to read from a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wish {
    /// The layer to denoise; `None` finds it.
    pub(crate) color: Option<String>,
    /// The further layers of light to denoise as well.
    pub(crate) layers: Option<LayersWish>,
    /// Index of the view to show; beyond the end, the last one.
    pub(crate) view: usize,
}

impl Opened {
    /// Reads an image with its albedo and normals.
    ///
    /// # Errors
    /// A sentence that names the file and what is wrong with it.
    pub(crate) fn noisy(path: &Path, wish: Wish) -> Result<Self, String> {
        let Wish { color, layers, view } = wish.clone();
        let opened = Self::read(path, &LayerChoice { color, layers, ..LayerChoice::default() })?;
        let last = opened.picture.views().len() - 1;
        Ok(Self { shown: view.min(last), wish, ..opened })
    }

    /// Reads a reference. From an EXR file, it takes the layer that results are written to.
    ///
    /// # Errors
    /// Same as [`noisy`](Self::noisy).
    pub(crate) fn reference(path: &Path) -> Result<Self, String> {
        Self::read(path, &LayerChoice { finished: true, no_aux: true, ..LayerChoice::default() })
    }

    fn read(path: &Path, wanted: &LayerChoice) -> Result<Self, String> {
        let stamp = Stamp::of(path);
        let picture = Picture::open(path, wanted).map_err(|error| sentence(&error))?;
        Ok(Self { path: path.to_path_buf(), picture, shown: 0, wish: Wish::default(), stamp })
    }

    pub(crate) fn view(&self) -> &View {
        &self.picture.views()[self.shown]
    }

    /// The views' names; a single view may have an empty one.
    pub(crate) fn views(&self) -> Vec<String> {
        let name = |view: &View| escaped(view.name().unwrap_or_default());
        self.picture.views().iter().map(name).collect()
    }

    pub(crate) fn size(&self) -> [u32; 2] {
        self.view().color().size().into()
    }

    /// The file name as shown in the window.
    pub(crate) fn name(&self) -> String {
        escaped(&self.path.file_name().unwrap_or_default().to_string_lossy())
    }

    /// The layers that could be the color, the selected one first; empty for PNG and JPEG.
    pub(crate) fn colors(&self) -> Vec<String> {
        let listed = self.view().selection().map(|selection| {
            [std::slice::from_ref(&selection.color), &selection.other_colors].concat()
        });
        listed.unwrap_or_default()
    }

    /// Which layers were found and why, and other remarks on the file.
    pub(crate) fn explanation(&self) -> Vec<String> {
        let found = self.view().selection().map(|selection| selection.explanation.clone());
        let mut lines = found.unwrap_or_default();
        lines.extend(self.picture.notices().iter().cloned());
        if self.view().is_panorama() {
            lines.push(
                "a panorama: denoised without a seam between its left and right edges".into(),
            );
        }
        if let more @ 2.. = self.picture.views().len() {
            lines.push(format!("all {more} views are denoised and saved"));
        }
        lines
    }
}

/// An error message, with advice for the window's users.
pub(crate) fn sentence(error: &FileError) -> String {
    let advice = match error.problem {
        Problem::TooManyPixels { .. } => "; the command line accepts more with --max-pixels",
        Problem::AmbiguousColor(_) => "; name one with --color of the command line",
        _ => "",
    };
    format!("{error}{advice}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_image_is_one_sentence_with_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("text.exr");
        std::fs::write(&file, "no image").unwrap();
        for path in [file.as_path(), folder.path(), Path::new("/nowhere/a.exr")] {
            let error = Opened::noisy(path, Wish::default()).unwrap_err();
            assert!(error.starts_with(&path.display().to_string()), "{error}");
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
