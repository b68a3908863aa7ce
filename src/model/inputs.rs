//! The images a network reads.

use super::shown::shown;
use crate::error::{Error, Result};

/// The input images of a network. Color is always one of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Inputs {
    /// Albedo: the surface's reflectance.
    pub albedo: bool,
    /// Shading normal.
    pub normal: bool,
}

impl Inputs {
    /// Color, albedo and normal.
    pub const ALL: Self = Self { albedo: true, normal: true };

    /// Channels of the network's input.
    #[must_use]
    pub fn channels(self) -> usize {
        3 + 3 * usize::from(self.albedo) + 3 * usize::from(self.normal)
    }

    /// Parses the text of a weights file: `color`, `color,albedo` or `color,albedo,normal`.
    ///
    /// # Errors
    /// Fails on any other text.
    #[doc(hidden)]
    pub fn parse(text: &str) -> Result<Self> {
        match text {
            "color" => Ok(Self::default()),
            "color,albedo" => Ok(Self { albedo: true, normal: false }),
            "color,albedo,normal" => Ok(Self::ALL),
            _ => Err(Error::weights(format!(
                "metadata `inputs` is `{}`, expected `color`, `color,albedo` or \
                 `color,albedo,normal`",
                shown(text)
            ))),
        }
    }

    /// The images of `self` that a network for `trained` can read.
    #[must_use]
    pub fn intersection(self, trained: Self) -> Self {
        Self { albedo: self.albedo && trained.albedo, normal: self.normal && trained.normal }
    }

    /// The channel indices of `self` among those of `trained`, in order. `trained` must contain
    /// every image of `self`.
    #[must_use]
    #[doc(hidden)]
    pub fn channels_of(self, trained: Self) -> Vec<usize> {
        let groups = [(true, true), (trained.albedo, self.albedo), (trained.normal, self.normal)];
        let mut kept = Vec::new();
        let mut next = 0;
        for (_, wanted) in groups.into_iter().filter(|&(trained, _)| trained) {
            if wanted {
                kept.extend(next..next + 3);
            }
            next += 3;
        }
        kept
    }
}

impl std::fmt::Display for Inputs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let albedo = if self.albedo { ", albedo" } else { "" };
        let normal = if self.normal { ", normal" } else { "" };
        write!(f, "color{albedo}{normal}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_subset_keeps_its_own_channels() {
        let normal_only = Inputs { albedo: false, normal: true };
        assert_eq!(normal_only.channels_of(Inputs::ALL), [0, 1, 2, 6, 7, 8]);
        assert_eq!(Inputs::default().channels_of(Inputs::ALL), [0, 1, 2]);
        assert_eq!(normal_only.to_string(), "color, normal");
    }

    #[test]
    fn unknown_inputs_are_refused_by_name() {
        assert!(Inputs::parse("color,depth").unwrap_err().to_string().contains("color,depth"));
    }
}
