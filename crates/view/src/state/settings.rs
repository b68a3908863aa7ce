//! How an image is denoised, and the command line that does the same.

use std::path::Path;

use wgdenoise::{Precision, Quality};

/// What happens to the alpha, as `--alpha` has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Alpha {
    /// It is denoised if it is fractional anywhere.
    Auto,
    Keep,
    Denoise,
}

impl Alpha {
    pub(crate) const ALL: [(Self, &'static str); 3] =
        [(Self::Auto, "Auto"), (Self::Keep, "Keep"), (Self::Denoise, "Denoise")];
}

/// What can be chosen while looking at the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Settings {
    pub(crate) quality: Quality,
    pub(crate) precision: Precision,
    pub(crate) albedo: bool,
    pub(crate) normal: bool,
    pub(crate) alpha: Alpha,
    /// Whether constant areas skip the network.
    pub(crate) skip_clean: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            quality: Quality::Balanced,
            precision: Precision::F16,
            albedo: true,
            normal: true,
            alpha: Alpha::Auto,
            skip_clean: true,
        }
    }
}

impl Settings {
    /// The command line that denoises a file with these settings, and with a layer as its color if
    /// one was chosen.
    ///
    /// # Errors
    /// If it has no flag for one of them.
    pub(crate) fn command(
        self,
        input: &Path,
        output: &Path,
        color: Option<&str>,
    ) -> Result<String, &'static str> {
        let mut words = vec!["wgdenoise".to_string(), path_word(input), path_word(output)];
        if let Some(color) = color {
            words.push(format!("--color={}", quoted(color)));
        }
        if self.quality != Quality::Balanced {
            words.push(format!("--quality {}", self.quality.name()));
        }
        if self.precision == Precision::F32 {
            words.push("--precision f32".into());
        }
        match (self.albedo, self.normal) {
            (true, true) => {}
            (false, false) => words.push("--no-aux".into()),
            _ => return Err(ONE_OF_TWO),
        }
        match self.alpha {
            Alpha::Auto => {}
            Alpha::Keep => words.push("--alpha keep".into()),
            Alpha::Denoise => words.push("--alpha denoise".into()),
        }
        if !self.skip_clean {
            words.push("--no-skip".into());
        }
        Ok(words.join(" "))
    }
}

const ONE_OF_TWO: &str = "the command line uses both albedo and normal or neither; switch both on or \
    off to copy a command";

/// A path that is taken for no flag.
fn path_word(path: &Path) -> String {
    let text = path.to_string_lossy();
    if text.starts_with('-') { quoted(&format!("./{text}")) } else { quoted(&text) }
}

/// A text as a shell takes it for one word.
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

    fn command(settings: Settings) -> Result<String, &'static str> {
        settings.command(Path::new("in.exr"), Path::new("out.exr"), None)
    }

    #[test]
    fn defaults_need_no_flag() {
        assert_eq!(command(Settings::default()), Ok("wgdenoise in.exr out.exr".into()));
    }

    #[test]
    fn every_other_choice_has_its_flag() {
        let settings = Settings {
            quality: Quality::High,
            precision: Precision::F32,
            albedo: false,
            normal: false,
            alpha: Alpha::Keep,
            skip_clean: false,
        };
        let flags = "--quality high --precision f32 --no-aux --alpha keep --no-skip";
        assert_eq!(command(settings), Ok(format!("wgdenoise in.exr out.exr {flags}")));
    }

    #[test]
    fn a_chosen_layer_is_named() {
        let (input, output) = (Path::new("in.exr"), Path::new("out.exr"));
        let found = Settings::default().command(input, output, Some("Noisy Image"));
        assert_eq!(found, Ok("wgdenoise in.exr out.exr --color='Noisy Image'".into()));
    }

    #[test]
    fn what_no_flag_can_say_is_not_pretended() {
        let settings = Settings { albedo: false, ..Settings::default() };
        assert_eq!(command(settings), Err(ONE_OF_TWO));
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
