//! A layer that was chosen.

use super::layers::{Layer, PLAIN, Place};

/// Channels of a layer, and why the layer was chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pick {
    /// The layer's name, as messages show it.
    pub layer: String,
    /// The name without the view.
    pub pass: String,
    /// Red, green and blue; x, y and z; or one channel three times, for gray.
    pub channels: [Place; 3],
    /// What the layer was recognized as.
    pub reason: String,
}

/// The reason given for a layer that the caller named.
pub(super) const ASKED_FOR: &str = "as asked for";

impl Pick {
    pub(super) fn new(layer: &Layer, channels: [Place; 3], reason: impl Into<String>) -> Self {
        let shown = layer.shown().to_string();
        let pass = if layer.base.is_empty() { PLAIN.into() } else { layer.base.clone() };
        let pass = if layer.base == layer.name { shown.clone() } else { pass };
        Self { layer: shown, pass, channels, reason: reason.into() }
    }

    /// Picks channels that the caller named.
    pub(super) fn named(layer: &str, channels: [Place; 3]) -> Self {
        Self { layer: layer.into(), pass: layer.into(), channels, reason: ASKED_FOR.into() }
    }

    /// The part whose window is the layer's.
    #[must_use]
    pub fn part(&self) -> usize {
        self.channels[0].part
    }

    /// Whether it is a single channel.
    #[must_use]
    pub fn is_gray(&self) -> bool {
        self.channels[0] == self.channels[1]
    }
}
