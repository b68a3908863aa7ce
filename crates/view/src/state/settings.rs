//! The denoising settings, and the command line that matches them.

use std::path::{Path, PathBuf};

use wgdenoise::{Precision, Quality};
use wgdenoise_files::fit::Alpha;
use wgdenoise_files::{LayersWish, escaped};

/// The display names of the alpha modes.
pub(crate) const ALPHAS: [(Alpha, &str); 3] =
    [(Alpha::Auto, "Auto"), (Alpha::Keep, "Keep"), (Alpha::Denoise, "Denoise")];

/// The source of the weights.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// Weights in the program; the quality selects them.
    BuiltIn,
    File(PathBuf),
    /// A folder of Open Image Denoise's weights; the image and the quality select from it.
    Folder(PathBuf),
}

impl Source {
    /// The source at a path: a file, or a folder with all its files.
    pub(crate) fn of(path: &Path) -> Self {
        if path.is_dir() { Self::Folder(path.into()) } else { Self::File(path.into()) }
    }

    pub(crate) fn path(&self) -> Option<&Path> {
        match self {
            Self::BuiltIn => None,
            Self::File(path) | Self::Folder(path) => Some(path),
        }
    }

    /// Whether an opened or dropped path holds weights rather than an image.
    pub(crate) fn is_weights(path: &Path) -> bool {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        extension == "safetensors" || extension == "tza" || path.is_dir()
    }
}

/// The settings that can be changed while looking at the result.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(clippy::struct_excessive_bools, reason = "each is a box to tick")]
pub(crate) struct Settings {
    pub(crate) weights: Source,
    pub(crate) quality: Quality,
    pub(crate) precision: Precision,
    pub(crate) albedo: bool,
    pub(crate) normal: bool,
    /// Whether to prefilter albedo and normal with the folder's weights.
    pub(crate) prefilter: bool,
    pub(crate) alpha: Alpha,
    /// Whether constant areas skip the network.
    pub(crate) skip_clean: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            weights: Source::BuiltIn,
            quality: Quality::Balanced,
            precision: Precision::F16,
            albedo: true,
            normal: true,
            prefilter: false,
            alpha: Alpha::Auto,
            skip_clean: true,
        }
    }
}

/// The chosen layers of a file.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Layers<'a> {
    pub(crate) color: Option<&'a str>,
    pub(crate) further: Option<&'a LayersWish>,
}

impl Settings {
    /// Whether albedo and normal are prefiltered; only a folder has weights for that.
    pub(crate) fn prefilters(&self) -> bool {
        self.prefilter && matches!(self.weights, Source::Folder(_))
    }

    /// The command line that denoises a file with these settings and layers.
    ///
    /// # Errors
    /// If one of them has no flag.
    pub(crate) fn command(
        &self,
        input: &Path,
        output: &Path,
        layers: Layers<'_>,
    ) -> Result<String, String> {
        let words = ["wgdenoise".to_string(), path_word(input), path_word(output)];
        let words = [words.to_vec(), layers.words()?, self.weights_words(), self.words()?];
        Ok(words.concat().join(" "))
    }

    fn weights_words(&self) -> Vec<String> {
        let path = self.weights.path().map(|path| format!("--weights {}", path_word(path)));
        let is_free = matches!(self.weights, Source::File(_)) || self.quality == Quality::Balanced;
        let quality = (!is_free).then(|| format!("--quality {}", self.quality.name()));
        let prefilter = self.prefilters().then(|| "--prefilter".to_string());
        path.into_iter().chain(quality).chain(prefilter).collect()
    }

    fn words(&self) -> Result<Vec<String>, String> {
        let precision = (self.precision == Precision::F32).then_some("--precision f32");
        let aux = match (self.albedo, self.normal) {
            (true, true) => None,
            (false, false) => Some("--no-aux"),
            _ => return Err(ONE_OF_TWO.into()),
        };
        let alpha = match self.alpha {
            Alpha::Auto => None,
            Alpha::Keep => Some("--alpha keep"),
            Alpha::Denoise => Some("--alpha denoise"),
        };
        let skip = (!self.skip_clean).then_some("--no-skip");
        Ok([precision, aux, alpha, skip].into_iter().flatten().map(Into::into).collect())
    }
}

const ONE_OF_TWO: &str = "the command line uses both albedo and normal or neither; switch both on or \
    off to copy a command";

impl Layers<'_> {
    fn words(self) -> Result<Vec<String>, String> {
        let color = self.color.map(|color| format!("--color={}", quoted(color)));
        let further = self.further.map(further).transpose()?;
        let further = further.map(|further| format!("--layers={}", quoted(&further)));
        Ok(color.into_iter().chain(further).collect())
    }
}

/// The value of `--layers`, which takes names separated by commas and trims them.
fn further(wish: &LayersWish) -> Result<String, String> {
    let LayersWish::Matching(names) = wish else { return Ok("auto".into()) };
    let is_lost = |name: &&String| name.contains(',') || name.trim() != *name;
    match (names.as_slice(), names.iter().find(is_lost)) {
        (_, Some(name)) => {
            Err(format!("the command line cannot name the layer `{}`", escaped(name)))
        }
        // Given twice, `auto` is a layer's name.
        ([only], None) if only == "auto" => Ok("auto,auto".into()),
        (names, None) => Ok(names.join(",")),
    }
}

/// A wish's layers as editable text; empty if it cannot name them.
pub(crate) fn listed(wish: &LayersWish) -> String {
    further(wish).unwrap_or_default()
}

/// A path written so that it cannot be mistaken for a flag.
fn path_word(path: &Path) -> String {
    let text = path.to_string_lossy();
    if text.starts_with('-') { quoted(&format!("./{text}")) } else { quoted(&text) }
}

/// Quotes text as one word for a shell.
fn quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+:@%=,".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.into();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command(settings: &Settings) -> Result<String, String> {
        command_with(settings, Layers::default())
    }

    fn command_with(settings: &Settings, layers: Layers<'_>) -> Result<String, String> {
        settings.command(Path::new("in.exr"), Path::new("out.exr"), layers)
    }

    #[test]
    fn defaults_need_no_flag() {
        assert_eq!(command(&Settings::default()), Ok("wgdenoise in.exr out.exr".into()));
    }

    #[test]
    fn every_other_choice_has_its_flag() {
        let settings = Settings {
            weights: Source::BuiltIn,
            quality: Quality::High,
            precision: Precision::F32,
            albedo: false,
            normal: false,
            prefilter: true,
            alpha: Alpha::Keep,
            skip_clean: false,
        };
        let flags = "--quality high --precision f32 --no-aux --alpha keep --no-skip";
        assert_eq!(command(&settings), Ok(format!("wgdenoise in.exr out.exr {flags}")));
    }

    #[test]
    fn a_weights_file_has_no_quality_and_a_folder_may_have_one() {
        let settings = Settings {
            weights: Source::File("my weights.tza".into()),
            quality: Quality::Fast,
            prefilter: true,
            ..Settings::default()
        };
        let found = command(&settings).unwrap();
        assert_eq!(found, "wgdenoise in.exr out.exr --weights 'my weights.tza'");
        let settings = Settings { weights: Source::Folder("oidn".into()), ..settings };
        let found = command(&settings).unwrap();
        assert_eq!(found, "wgdenoise in.exr out.exr --weights oidn --quality fast --prefilter");
    }

    #[test]
    fn chosen_layers_are_named() {
        let named = |names: &[&str]| {
            let further = LayersWish::Matching(names.iter().map(ToString::to_string).collect());
            let layers = Layers { color: Some("Noisy Image"), further: Some(&further) };
            command_with(&Settings::default(), layers)
        };
        let start = "wgdenoise in.exr out.exr --color='Noisy Image' --layers=";
        assert_eq!(named(&["key", "fill"]), Ok(format!("{start}key,fill")));
        assert_eq!(named(&["auto"]), Ok(format!("{start}auto,auto")));
        let auto = Layers { further: Some(&LayersWish::Auto), ..Layers::default() };
        let found = command_with(&Settings::default(), auto);
        assert_eq!(found, Ok("wgdenoise in.exr out.exr --layers=auto".into()));
        for lost in ["a,b", " a"] {
            assert!(named(&[lost]).unwrap_err().contains(&format!("`{lost}`")));
        }
    }

    #[test]
    fn what_no_flag_can_say_is_not_pretended() {
        let settings = Settings { albedo: false, ..Settings::default() };
        assert_eq!(command(&settings), Err(ONE_OF_TWO.into()));
    }

    #[test]
    fn weights_are_told_from_images_by_their_names() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Source::is_weights(folder.path()));
        let is_weights = |name: &str| Source::is_weights(Path::new(name));
        assert!(is_weights("a.TZA") && is_weights("b/a.safetensors"));
        assert!(!is_weights("a.exr") && !is_weights("tza") && !is_weights(""));
    }

    #[test]
    fn a_shell_takes_any_name_for_one_word() {
        for (name, shown) in [
            ("a/b-1.exr", "a/b-1.exr"),
            ("my render.exr", "'my render.exr'"),
            ("it's $1.exr", r"'it'\''s $1.exr'"),
            ("-rf", "./-rf"),
            ("", "''"),
        ] {
            assert_eq!(path_word(Path::new(name)), shown);
        }
    }
}
