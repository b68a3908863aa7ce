//! The images being looked at, and their layout.

/// An image that can be looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shown {
    Noisy,
    Denoised,
    Reference,
    Albedo,
    Normal,
    /// The difference between the denoised image and the noisy one or the reference.
    Difference,
}

impl Shown {
    /// All images, in the order of their keys, 1 to 6.
    pub(crate) const ALL: [Self; 6] = [
        Self::Noisy,
        Self::Denoised,
        Self::Reference,
        Self::Albedo,
        Self::Normal,
        Self::Difference,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Noisy => "Noisy",
            Self::Denoised => "Denoised",
            Self::Reference => "Reference",
            Self::Albedo => "Albedo",
            Self::Normal => "Normal",
            Self::Difference => "Difference",
        }
    }
}

/// The images available besides the noisy one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(clippy::struct_excessive_bools, reason = "each is an image")]
pub(crate) struct Available {
    pub(crate) denoised: bool,
    pub(crate) reference: bool,
    pub(crate) albedo: bool,
    pub(crate) normal: bool,
}

impl Available {
    pub(crate) fn has(self, shown: Shown) -> bool {
        match shown {
            Shown::Noisy => true,
            Shown::Denoised | Shown::Difference => self.denoised,
            Shown::Reference => self.reference,
            Shown::Albedo => self.albedo,
            Shown::Normal => self.normal,
        }
    }
}

/// How images share the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layout {
    /// One image.
    Single,
    /// Two images in one place, divided by a line that can be dragged.
    Split,
    /// Two images next to each other, at the same position and zoom.
    SideBySide,
}

impl Layout {
    pub(crate) const ALL: [(Self, &'static str); 3] =
        [(Self::Single, "Single"), (Self::Split, "Split"), (Self::SideBySide, "Side by side")];
}

/// What a difference measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measure {
    /// The difference in linear light.
    Light,
    /// The visible error, by FLIP. Needs a reference.
    Perceived,
}

/// What the user wants to look at.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Looking {
    /// The image, or the right one of two.
    pub(crate) shown: Shown,
    /// The left one of two.
    pub(crate) left: Shown,
    pub(crate) layout: Layout,
    /// Position of the split line, from 0 at the window's left edge to 1.
    pub(crate) split: f32,
    /// Factor on a difference.
    pub(crate) amplification: f32,
    pub(crate) measure: Measure,
}

impl Default for Looking {
    fn default() -> Self {
        Self {
            shown: Shown::Denoised,
            left: Shown::Noisy,
            layout: Layout::Single,
            split: 0.5,
            amplification: 4.0,
            measure: Measure::Light,
        }
    }
}

impl Looking {
    /// Range of the amplification.
    pub(crate) const AMPLIFICATION: [f32; 2] = [1.0, 64.0];

    /// Shows the noisy image in place of the denoised one, or the denoised one in place of any
    /// other.
    pub(crate) fn toggle(&mut self) {
        self.shown = match self.shown {
            Shown::Denoised => Shown::Noisy,
            _ => Shown::Denoised,
        };
    }

    /// Switches a difference to the other measure.
    pub(crate) fn next_measure(&mut self) {
        self.shown = Shown::Difference;
        self.measure = match self.measure {
            Measure::Light => Measure::Perceived,
            Measure::Perceived => Measure::Light,
        };
    }

    /// Switches to this layout, or from it back to a single image.
    pub(crate) fn toggle_layout(&mut self, layout: Layout) {
        self.layout = if self.layout == layout { Layout::Single } else { layout };
    }

    /// Moves the split line, keeping it within reach at both edges.
    pub(crate) fn move_split(&mut self, to: f32) {
        self.split = to.clamp(0.02, 0.98);
    }

    /// The images actually shown, left and right. The noisy image replaces a missing one.
    pub(crate) fn visible(&self, available: Available) -> [Shown; 2] {
        let there = |shown| if available.has(shown) { shown } else { Shown::Noisy };
        let right = there(self.shown);
        match self.layout {
            Layout::Single => [right, right],
            Layout::Split | Layout::SideBySide => [there(self.left), right],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn space_toggles_noisy_and_denoised_and_leads_back_from_others() {
        let mut looking = Looking::default();
        let mut next = || {
            looking.toggle();
            looking.shown
        };
        assert_eq!([next(), next()], [Shown::Noisy, Shown::Denoised]);
        looking.shown = Shown::Albedo;
        looking.toggle();
        assert_eq!(looking.shown, Shown::Denoised);
    }

    #[test]
    fn what_is_missing_is_replaced_by_the_noisy_image() {
        let all = Available { denoised: true, reference: true, albedo: true, normal: true };
        let none = Available::default();
        for shown in Shown::ALL {
            let looking = Looking { shown, ..Looking::default() };
            assert_eq!(looking.visible(all), [shown; 2]);
            assert_eq!(looking.visible(none), [Shown::Noisy; 2]);
        }
    }

    #[test]
    fn two_images_are_left_and_right() {
        let mut looking = Looking { left: Shown::Reference, ..Looking::default() };
        looking.toggle_layout(Layout::Split);
        let available = Available { denoised: true, reference: true, ..Available::default() };
        assert_eq!(looking.visible(available), [Shown::Reference, Shown::Denoised]);
        looking.toggle_layout(Layout::SideBySide);
        assert_eq!(looking.layout, Layout::SideBySide);
        looking.toggle_layout(Layout::SideBySide);
        assert_eq!(looking.layout, Layout::Single);
    }

    #[test]
    fn the_line_of_a_split_stays_in_the_window() {
        let mut looking = Looking::default();
        for (to, found) in [(-3.0, 0.02), (0.3, 0.3), (7.0, 0.98)] {
            looking.move_split(to);
            assert_eq!(looking.split, found);
        }
    }
}
