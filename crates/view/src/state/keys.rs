//! The key bindings. The help in the window lists this table.

use eframe::egui::{Key, Modifiers};

use crate::state::looking::{Layout, Shown};

/// An action that the user requests by a key or a button.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Action {
    Show(Shown),
    Toggle,
    Arrange(Layout),
    Fit,
    OneToOne,
    Zoom(f32),
    Brighten(f32),
    ResetExposure,
    NextCurve,
    NextMeasure,
    Open,
    OpenReference,
    OpenWeights,
    OpenWeightsFolder,
    BuiltInWeights,
    Save,
    SaveComparison,
    CopyCommand,
    CopyImage,
    Step(isize),
    First,
    Last,
    Watch,
    Cancel,
    Help,
}

/// A key and its action.
pub(crate) struct Binding {
    pub(crate) key: Key,
    /// Whether it needs Ctrl, or Command on a Mac.
    pub(crate) command: bool,
    pub(crate) shift: bool,
    pub(crate) action: Action,
    /// The help text; empty for a second key of the same action.
    pub(crate) help: &'static str,
}

const fn plain(key: Key, action: Action, help: &'static str) -> Binding {
    Binding { key, command: false, shift: false, action, help }
}

const fn with_command(key: Key, action: Action, help: &'static str) -> Binding {
    Binding { command: true, ..plain(key, action, help) }
}

/// All bindings, grouped as the help shows them.
pub(crate) const BINDINGS: &[Binding] = &[
    plain(Key::Num1, Action::Show(Shown::Noisy), "noisy image"),
    plain(Key::Num2, Action::Show(Shown::Denoised), "denoised image"),
    plain(Key::Num3, Action::Show(Shown::Reference), "reference"),
    plain(Key::Num4, Action::Show(Shown::Albedo), "albedo"),
    plain(Key::Num5, Action::Show(Shown::Normal), "normal"),
    plain(Key::Num6, Action::Show(Shown::Difference), "difference"),
    plain(Key::P, Action::NextMeasure, "difference: light or FLIP"),
    plain(Key::Space, Action::Toggle, "toggle noisy and denoised"),
    plain(Key::S, Action::Arrange(Layout::Split), "split, with a line to drag"),
    plain(Key::D, Action::Arrange(Layout::SideBySide), "side by side"),
    plain(Key::F, Action::Fit, "fit the window"),
    plain(Key::Z, Action::OneToOne, "1:1"),
    plain(Key::Plus, Action::Zoom(1.25), "zoom in"),
    plain(Key::Equals, Action::Zoom(1.25), ""),
    plain(Key::Minus, Action::Zoom(0.8), "zoom out"),
    plain(Key::E, Action::Brighten(0.5), "half a stop brighter"),
    Binding { shift: true, ..plain(Key::E, Action::Brighten(-0.5), "half a stop darker") },
    plain(Key::Num0, Action::ResetExposure, "reset exposure"),
    plain(Key::T, Action::NextCurve, "tone curve: sRGB or filmic"),
    with_command(Key::O, Action::Open, "open images"),
    plain(Key::R, Action::OpenReference, "open a reference"),
    plain(Key::N, Action::OpenWeights, "open a weights file"),
    with_command(Key::S, Action::Save, "save the result"),
    Binding {
        shift: true,
        ..with_command(Key::S, Action::SaveComparison, "save the comparison as PNG")
    },
    with_command(Key::E, Action::CopyCommand, "copy the command line"),
    with_command(Key::C, Action::CopyImage, "copy the picture that is shown"),
    plain(Key::ArrowRight, Action::Step(1), "next file or frame"),
    plain(Key::ArrowLeft, Action::Step(-1), "previous file or frame"),
    plain(Key::Home, Action::First, "first file or frame"),
    plain(Key::End, Action::Last, "last file or frame"),
    plain(Key::W, Action::Watch, "watch the file"),
    plain(Key::Escape, Action::Cancel, "cancel, close"),
    plain(Key::Questionmark, Action::Help, "this list"),
    plain(Key::F1, Action::Help, ""),
];

impl Binding {
    /// The keys as people write them.
    pub(crate) fn keys(&self) -> String {
        let command = if self.command { "Ctrl " } else { "" };
        let shift = if self.shift { "Shift " } else { "" };
        let name = match self.key {
            // The fonts lack symbols for the other keys.
            Key::Plus | Key::Minus | Key::Questionmark => self.key.symbol_or_name(),
            key => key.name(),
        };
        format!("{command}{shift}{name}")
    }
}

/// The action of a key with these modifiers.
pub(crate) fn action(key: Key, held: Modifiers) -> Option<Action> {
    // On many keyboards, these need Shift.
    let shift = held.shift && !matches!(key, Key::Questionmark | Key::Plus | Key::Equals);
    let fits = |binding: &&Binding| {
        (binding.key, binding.command, binding.shift) == (key, held.command, shift)
    };
    BINDINGS.iter().filter(|_| !held.alt).find(fits).map(|binding| binding.action)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_actions_share_a_key() {
        for (i, a) in BINDINGS.iter().enumerate() {
            let same = |b: &&Binding| (a.key, a.command, a.shift) == (b.key, b.command, b.shift);
            assert_eq!(BINDINGS.iter().filter(same).count(), 1, "{} at {i}", a.keys());
        }
    }

    #[test]
    fn every_image_has_its_number() {
        let numbers = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6];
        for (key, shown) in numbers.into_iter().zip(Shown::ALL) {
            assert_eq!(action(key, Modifiers::NONE), Some(Action::Show(shown)));
        }
    }

    #[test]
    fn modifiers_make_another_key() {
        assert_eq!(action(Key::S, Modifiers::NONE), Some(Action::Arrange(Layout::Split)));
        assert_eq!(action(Key::S, Modifiers::COMMAND), Some(Action::Save));
        let both = Modifiers::COMMAND | Modifiers::SHIFT;
        assert_eq!(action(Key::S, both), Some(Action::SaveComparison));
        assert_eq!(action(Key::S, Modifiers::ALT), None);
        assert_eq!(action(Key::Questionmark, Modifiers::SHIFT), Some(Action::Help));
    }

    #[test]
    fn every_action_is_explained_once() {
        for binding in BINDINGS {
            let explained =
                BINDINGS.iter().filter(|b| b.action == binding.action && !b.help.is_empty());
            assert_eq!(explained.count(), 1, "{}", binding.keys());
        }
    }
}
