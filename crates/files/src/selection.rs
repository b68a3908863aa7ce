//! Which layers are used, in words for a user.

use std::fmt::Write as _;

use crate::escape::escaped;

/// The layers of an EXR file that are used, or the files that stand in for them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    /// The layer read as color.
    pub color: String,
    /// The layer that the result is written to.
    pub target: String,
    /// Whether albedo is used.
    pub albedo: bool,
    /// Whether normals are used.
    pub normal: bool,
    /// Color, albedo and normal with the reasons they were chosen, a line each.
    pub explanation: [String; 3],
    /// Other layers that could be the color; they stay as they are.
    pub other_colors: Vec<String>,
    /// Why a layer that was found is not used, a sentence each.
    pub left_out: Vec<String>,
}

impl Selection {
    /// One line of at most `width` characters, unless there is no room for four of each name.
    #[must_use]
    pub fn summary(&self, width: usize) -> String {
        let [color, target] = [&self.color, &self.target].map(|name| escaped(last_word(name)));
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
        text + match (self.albedo, self.normal) {
            (true, true) => " with albedo and normal",
            (true, false) => " with albedo, no normal",
            (false, true) => " with normal, no albedo",
            (false, false) => " without albedo and normal",
        }
    }
}

/// `Noisy Image` of `ViewLayer.Noisy Image`.
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
            color: color.into(),
            target: target.into(),
            albedo: true,
            normal: true,
            explanation: Default::default(),
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
