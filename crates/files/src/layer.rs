//! A layer of an EXR file: channels that belong together.

use super::conventions::{self, Convention};

/// The names of one part of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// The part's `name` attribute.
    pub name: Option<String>,
    /// The full names of its channels, in the file's order.
    pub channels: Vec<String>,
    /// The part's `view` attribute.
    pub view: Option<String>,
    /// The part's `multiView` attribute: the views of its channels, the default one first.
    pub views: Vec<String>,
}

/// Where a channel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Place {
    /// Index of the part.
    pub part: usize,
    /// Index of the channel within the part.
    pub channel: usize,
}

/// Channels that share everything before the last dot of their names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// The shared name; empty for the plain channels of a file with a single part.
    pub name: String,
    /// The name without the view.
    pub base: String,
    /// The view that the layer belongs to; `None` if the file has only one.
    pub view: Option<String>,
    /// Each channel's word after the last dot, and where the channel is.
    pub channels: Vec<(String, Place)>,
    /// The name that messages show, unique to this layer.
    pub(super) shown: String,
}

/// Stands for the plain channels of a file with a single part.
pub(super) const PLAIN: &str = "RGB";

impl Layer {
    pub(super) fn new(name: &str) -> Self {
        Self {
            name: name.into(),
            base: name.into(),
            view: None,
            channels: Vec::new(),
            shown: String::new(),
        }
    }

    /// The name that messages show.
    #[must_use]
    pub fn shown(&self) -> &str {
        &self.shown
    }

    /// The layer's own name; plain channels without color go by theirs.
    pub(super) fn own_name(&self) -> String {
        if !self.name.is_empty() {
            return self.name.clone();
        }
        let single = self.single();
        let mut channels = self.channels.iter();
        match channels.find(|(_, place)| Some(*place) == single) {
            Some((letter, _)) => letter.clone(),
            _ if self.rgb().is_none() && self.xyz().is_some() => "XYZ".into(),
            _ => PLAIN.into(),
        }
    }

    /// Index of the part that holds the layer, or its first channel.
    #[must_use]
    pub fn part(&self) -> usize {
        self.channels[0].1.part
    }

    /// Red, green and blue, if the layer has them.
    #[must_use]
    pub fn rgb(&self) -> Option<[Place; 3]> {
        self.find(["r", "g", "b"]).or_else(|| self.find(["red", "green", "blue"]))
    }

    /// The components x, y and z, if the layer has them.
    #[must_use]
    pub fn xyz(&self) -> Option<[Place; 3]> {
        self.find(["x", "y", "z"])
    }

    /// Alpha, if the layer has it.
    #[must_use]
    pub fn alpha(&self) -> Option<Place> {
        let is_alpha = |letter: &str| matches!(letter.to_lowercase().as_str(), "a" | "alpha");
        self.channels.iter().find(|(letter, _)| is_alpha(letter)).map(|(_, place)| *place)
    }

    /// X, y and z, or else red, green and blue.
    pub(super) fn triple(&self) -> Option<[Place; 3]> {
        self.xyz().or_else(|| self.rgb())
    }

    /// The only channel besides alpha.
    pub(super) fn single(&self) -> Option<Place> {
        let alpha = self.alpha();
        match self.channels.as_slice() {
            [(_, only)] => Some(*only),
            [(_, a), (_, b)] if alpha == Some(*a) => Some(*b),
            [(_, a), (_, b)] if alpha == Some(*b) => Some(*a),
            _ => None,
        }
    }

    /// Finds the channels with these lower-case letters: in upper case, else in lower case, else in
    /// any.
    pub(super) fn find(&self, letters: [&str; 3]) -> Option<[Place; 3]> {
        let find = |is: &dyn Fn(&str, &str) -> bool| {
            let place = |letter: &str| {
                self.channels.iter().find(|(l, _)| is(l, letter)).map(|(_, place)| *place)
            };
            Some([place(letters[0])?, place(letters[1])?, place(letters[2])?])
        };
        find(&|l, letter| l == letter.to_uppercase())
            .or_else(|| find(&|l, letter| l == letter))
            .or_else(|| find(&|l, letter| l.eq_ignore_ascii_case(letter)))
    }

    pub(super) fn has(&self, letter: &str) -> bool {
        self.channels.iter().any(|(l, _)| l == letter)
    }

    /// The name without the view, split at its last dot.
    pub(super) fn pass_name(&self) -> (&str, &str) {
        self.base.rsplit_once('.').unwrap_or(("", &self.base))
    }

    /// The index in a table of the first convention that the name follows.
    pub(super) fn convention(&self, table: &[Convention]) -> Option<usize> {
        let pass = conventions::simple(self.pass_name().1);
        table.iter().position(|c| pass == c.pass && (!c.words || self.has("red")))
    }

    /// What the layer holds other than light, if its name tells.
    pub(super) fn data(&self) -> Option<&'static str> {
        match () {
            () if self.convention(conventions::ALBEDO).is_some() => Some("albedo"),
            () if self.convention(conventions::NORMAL).is_some() => Some("normals"),
            () if self.base.is_empty() => conventions::data(&self.shown),
            () => conventions::data(self.pass_name().1),
        }
    }

    /// Turns the name `rgba.R` of a part with the one channel `R` into `rgba`, and `R` into none.
    pub(super) fn leave_out(&mut self, channel: &str) {
        let is_color = ["R", "G", "B", "A"].contains(&channel);
        match self.name.strip_suffix(channel) {
            Some("") if is_color => self.name.clear(),
            Some(rest) if rest.ends_with(['.', '_']) => {
                self.name = rest.trim_end_matches(['.', '_']).to_string();
            }
            _ => {}
        }
        self.base.clone_from(&self.name);
    }

    /// The names that a user can give for the layer or its channels.
    pub(super) fn names(&self) -> Vec<&str> {
        if self.name.is_empty() && self.triple().is_none() {
            return self.channels.iter().map(|(letter, _)| letter.as_str()).collect();
        }
        vec![self.shown()]
    }
}
