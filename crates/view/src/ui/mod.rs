//! The parts of the window. Each draws itself from the session and returns the user's actions.

pub(crate) mod canvas;
pub(crate) mod drop;
pub(crate) mod empty;
pub(crate) mod help;
pub(crate) mod layers;
pub(crate) mod look;
pub(crate) mod panel;
pub(crate) mod prompt;
pub(crate) mod recent;
pub(crate) mod settings;
pub(crate) mod status;
pub(crate) mod theme;
pub(crate) mod toolbar;
