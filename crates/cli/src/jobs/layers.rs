//! Which layers each picture of several is read with.

use std::path::Path;

use super::sequence::Sequence;
use super::source::Source;
use crate::args::LayerArgs;
use crate::failure::Failure;
use wgdenoise_files::LayerChoice;

/// The layers of the flags; beside an animation, albedo and normals may be animations too.
#[derive(Debug)]
pub(super) struct Layers {
    choice: LayerChoice,
    albedo: Option<Sequence>,
    normal: Option<Sequence>,
}

impl Layers {
    pub(super) fn of(args: &LayerArgs, source: &Source) -> Result<Self, Failure> {
        let choice = LayerChoice::from(args);
        let sequence = |name: &Option<String>| match name {
            Some(name) if source.is_sequence() => Sequence::of(Path::new(name)),
            _ => Ok(None),
        };
        let (albedo, normal) = (sequence(&choice.albedo)?, sequence(&choice.normal)?);
        Ok(Self { choice, albedo, normal })
    }

    /// Makes sure that the files of these frames are there.
    pub(super) fn check(&self, frames: &[u32]) -> Result<(), Failure> {
        let sequences = [&self.albedo, &self.normal].into_iter().flatten();
        sequences.into_iter().try_for_each(|sequence| sequence.check(frames))
    }

    /// The layers of one picture.
    pub(super) fn at(&self, frame: Option<u32>) -> LayerChoice {
        let file = |sequence: &Option<Sequence>| {
            let file = sequence.as_ref().zip(frame).map(|(sequence, frame)| sequence.file(frame));
            file.map(|file| file.to_string_lossy().into_owned())
        };
        let choice = self.choice.clone();
        LayerChoice {
            albedo: file(&self.albedo).or(choice.albedo),
            normal: file(&self.normal).or(choice.normal),
            ..choice
        }
    }
}
