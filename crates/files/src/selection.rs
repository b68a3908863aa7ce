//! Which layers are used, in words for a user.

use std::path::Path;

use std::fmt::Write as _;

use super::choice::Choice;
use super::escape::escaped;
use super::pick::Pick;
use super::wanted::Files;

/// The layers of an EXR file that are used, or the files that stand in for them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    /// The view, if the file has several.
    pub view: Option<String>,
    /// The layer read as color.
    pub color: String,
    /// The layer that the result is written to.
    pub target: String,
    /// Whether albedo is used.
    pub albedo: bool,
    /// Whether normals are used.
    pub normal: bool,
    /// Further light layers to denoise.
    pub layers: Vec<String>,
    /// All layers that can be denoised along with the color, by the names that
    /// [`LayersWish`](crate::LayersWish) takes, and whether each is denoised.
    pub possible_layers: Vec<(String, bool)>,
    /// Names of color and target, without the view.
    pub(super) passes: [String; 2],
    /// Why color, albedo and normal were chosen, one line each; then alpha and further layers, if
    /// there are any.
    pub explanation: Vec<String>,
    /// Other layers that could be the color; they stay as they are.
    pub other_colors: Vec<String>,
    /// Why layers that were found are not used, one sentence each.
    pub left_out: Vec<String>,
}

impl Selection {
    /// Words a choice for a user. Albedo and normal may come from files instead.
    pub(super) fn of(choice: &Choice, files: &Files) -> Self {
        Self {
            view: choice.view.clone(),
            color: choice.color.layer.clone(),
            target: choice.target.layer.clone(),
            albedo: choice.albedo.is_some() || files.albedo.is_some(),
            normal: choice.normal.is_some() || files.normal.is_some(),
            layers: choice.layers.iter().map(|pick| pick.layer.clone()).collect(),
            possible_layers: possible_layers(choice),
            passes: [&choice.color, &choice.target].map(|pick| pick.pass.clone()),
            explanation: explain(choice, files),
            other_colors: choice.other_colors.clone(),
            left_out: choice.left_out.clone(),
        }
    }

    /// Summarizes it in one line of at most `width` characters, unless that leaves fewer than four
    /// for each name.
    #[must_use]
    pub fn summary(&self, width: usize) -> String {
        let [color, target] = self.passes.each_ref().map(|name| escaped(last_word(name)));
        let full = self.sentence(&color, &target);
        let excess = full.chars().count().saturating_sub(width);
        if excess == 0 {
            return full;
        }
        let names = if self.writes_elsewhere() { vec![&color, &target] } else { vec![&color] };
        let length: usize = names.iter().map(|name| name.chars().count()).sum();
        let most = length.saturating_sub(excess) / names.len();
        self.sentence(&cut(&color, most), &cut(&target, most))
    }

    fn writes_elsewhere(&self) -> bool {
        self.color != self.target
    }

    fn sentence(&self, color: &str, target: &str) -> String {
        let mut text = format!("denoising `{color}`");
        if self.writes_elsewhere() {
            let _ = write!(text, " into `{target}`");
        }
        if let Some(view) = &self.view {
            let _ = write!(text, " of `{}`", escaped(view));
        }
        text += match (self.albedo, self.normal) {
            (true, true) => " with albedo and normal",
            (true, false) => " with albedo, no normal",
            (false, true) => " with normal, no albedo",
            (false, false) => " without albedo and normal",
        };
        match self.layers.len() {
            0 => text,
            1 => text + ", and 1 layer",
            n => text + &format!(", and {n} layers"),
        }
    }
}

fn possible_layers(choice: &Choice) -> Vec<(String, bool)> {
    let is_chosen = |name: &String| choice.layers.iter().any(|pick| pick.pass == *name);
    choice.possible_layers.iter().map(|name| (name.clone(), is_chosen(name))).collect()
}

fn explain(choice: &Choice, files: &Files) -> Vec<String> {
    let [color, target] = [&choice.color, &choice.target].map(|pick| escaped(&pick.layer));
    let reason = &choice.color.reason;
    let [no_albedo, no_normal] = &choice.missing;
    let mut lines = vec![
        format!("color from `{color}` ({reason}), written to `{target}`"),
        explain_one(
            "albedo",
            choice.albedo.as_ref(),
            files.albedo.as_deref().map(Path::to_string_lossy).as_deref(),
            no_albedo.as_deref(),
        ),
        explain_one(
            "normal",
            choice.normal.as_ref(),
            files.normal.as_deref().map(Path::to_string_lossy).as_deref(),
            no_normal.as_deref(),
        ),
    ];
    if choice.alpha.is_some() {
        lines.push(format!("alpha from `{color}`"));
    }
    for pick in &choice.layers {
        lines.push(format!("further layer: `{}` ({})", escaped(&pick.layer), pick.reason));
    }
    lines
}

fn explain_one(
    what: &str,
    pick: Option<&Pick>,
    file: Option<&str>,
    missing: Option<&str>,
) -> String {
    match (pick, file, missing) {
        (_, Some(file), _) => format!("{what} from the file {}", escaped(file)),
        (Some(pick), None, _) => {
            format!("{what} from `{}` ({})", escaped(&pick.layer), pick.reason)
        }
        (None, None, Some(why)) => format!("no {what}: {why}"),
        (None, None, None) => format!("no {what}"),
    }
}

/// The last word of a layer's name: `Noisy Image` of `ViewLayer.Noisy Image`.
fn last_word(layer: &str) -> &str {
    layer.rsplit('.').find(|word| !word.is_empty()).unwrap_or(layer)
}

fn cut(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.into();
    }
    name.chars().take(most.saturating_sub(1).max(3)).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn selection(color: &str, target: &str) -> Selection {
        Selection {
            view: None,
            color: color.into(),
            target: target.into(),
            albedo: true,
            normal: true,
            layers: Vec::new(),
            possible_layers: Vec::new(),
            passes: [color.into(), target.into()],
            explanation: Vec::new(),
            other_colors: Vec::new(),
            left_out: Vec::new(),
        }
    }

    #[test]
    fn names_of_renderers_fit_and_long_names_are_cut() {
        let blender = selection("ViewLayer.Noisy Image", "ViewLayer.Combined").summary(69);
        assert_eq!(blender, "denoising `Noisy Image` into `Combined` with albedo and normal");
        let alone = Selection { albedo: false, normal: false, ..selection("C", "C") };
        assert_eq!(alone.summary(69), "denoising `C` without albedo and normal");
        let left = Selection { view: Some("left".into()), ..selection("RGB", "RGB") };
        assert_eq!(left.summary(69), "denoising `RGB` of `left` with albedo and normal");
        let groups = Selection { layers: vec!["a".into(); 12], ..selection("C", "C") };
        assert_eq!(groups.summary(69), "denoising `C` with albedo and normal, and 12 layers");
        for (color, target) in [
            (&*"c".repeat(255), &*"t".repeat(255)),
            (&*"c".repeat(255), "t"),
            ("c", &*"t".repeat(99)),
            ("\u{1b}".repeat(9).as_str(), "t"),
            (&*"画".repeat(64), &*"画".repeat(64)),
        ] {
            let line = selection(color, target).summary(69);
            assert!(line.chars().count() <= 69 && line.contains('…'), "{line}");
        }
    }
}
