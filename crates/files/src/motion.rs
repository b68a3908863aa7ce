//! Finds the motion vector layer and its channels.

use super::Problem;
use super::conventions::MOTION;
use super::escape::escaped;
use super::layers::{Layer, Place, named};
use super::pick::ASKED_FOR;

/// How to choose the motion vectors.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum MotionWish {
    /// No motion vectors.
    #[default]
    Without,
    /// By the names that renderers use, beside the color.
    Auto,
    /// The layer of this name.
    Named(String),
}

/// A view's motion vectors, as the file stores them.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionLayer {
    /// The layer's name in the file.
    pub name: String,
    /// x and y, then x and y of a second vector if the layer has one; row by row, of the color's
    /// size.
    pub planes: Vec<Vec<f32>>,
}

/// A layer of motion vectors to read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MotionPick {
    /// The layer's name, as messages show it.
    pub layer: String,
    /// What the layer was recognized as.
    pub reason: String,
    /// Two or four channels.
    pub channels: Vec<Place>,
}

/// Chooses a color's motion vectors among the other layers of its view; `all` are the file's
/// layers.
///
/// # Errors
/// If a named layer is missing or has the wrong channels.
pub(super) fn choose<'a>(
    others: impl Iterator<Item = &'a Layer>,
    color: &Layer,
    all: &[Layer],
    wish: &MotionWish,
) -> Result<Option<MotionPick>, Problem> {
    match wish {
        MotionWish::Without => Ok(None),
        MotionWish::Auto => Ok(beside(others, color)),
        MotionWish::Named(name) => {
            let found = named(all, name)?;
            let own = found.iter().find(|layer| layer.view == color.view).unwrap_or(&found[0]);
            let pick = pick(own, ASKED_FOR.into()).ok_or_else(|| not_vectors(own))?;
            Ok(Some(pick))
        }
    }
}

/// The layer with the preferred known name and the color's prefix.
fn beside<'a>(layers: impl Iterator<Item = &'a Layer>, color: &Layer) -> Option<MotionPick> {
    let home = color.pass_name().0;
    let beside = layers.filter(|layer| layer.pass_name().0 == home);
    let known = beside.filter_map(|layer| {
        let rank = layer.convention(MOTION)?;
        Some((rank, pick(layer, MOTION[rank].whose.into())?))
    });
    known.min_by_key(|(rank, _)| *rank).map(|(_, pick)| pick)
}

/// The letters of vector channels, preferred first. A third component is depth.
const LETTERS: &[&[&str]] =
    &[&["x", "y", "z", "w"], &["x", "y"], &["u", "v"], &["r", "g"], &["red", "green"]];

fn pick(layer: &Layer, reason: String) -> Option<MotionPick> {
    let place = |letter: &&str| {
        let mut channels = layer.channels.iter();
        channels.find(|(own, _)| own.eq_ignore_ascii_case(letter)).map(|(_, place)| *place)
    };
    let all = |letters: &&[&str]| letters.iter().map(place).collect::<Option<Vec<_>>>();
    let channels = LETTERS.iter().find_map(all)?;
    Some(MotionPick { layer: layer.shown().into(), reason, channels })
}

fn not_vectors(layer: &Layer) -> Problem {
    let letters: Vec<_> = layer.channels.iter().map(|(letter, _)| escaped(letter)).collect();
    Problem::Layers(format!(
        "layer `{}` has the channels {} and not X and Y, R and G or U and V of motion vectors",
        escaped(layer.shown()),
        letters.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::super::layers::{Part, layers};
    use super::*;

    fn find(channels: &str, wish: &MotionWish) -> Result<Option<(String, usize)>, String> {
        let channels = channels.split_whitespace().map(Into::into).collect();
        let all = layers(&[Part { channels, ..Part::default() }]);
        let color = all.iter().find(|layer| layer.rgb().is_some()).expect("there is a color");
        let found = choose(all.iter().filter(|l| *l != color), color, &all, wish);
        let found = found.map_err(|problem| problem.to_string())?;
        Ok(found.map(|pick| (pick.layer, pick.channels.len())))
    }

    #[test]
    fn renderers_names_are_known_and_the_channels_are_two_or_four() {
        for (channels, expected) in [
            (
                "V.Combined.R V.Combined.G V.Combined.B V.Vector.X V.Vector.Y V.Vector.Z V.Vector.W",
                ("V.Vector", 4),
            ),
            ("R G B motionvector.R motionvector.G motionvector.B", ("motionvector", 2)),
            ("R G B motion.X motion.Y", ("motion", 2)),
            ("R G B velocity.red velocity.green velocity.blue", ("velocity", 2)),
            ("R G B motion.U motion.V", ("motion", 2)),
        ] {
            let found = find(channels, &MotionWish::Auto);
            assert_eq!(found, Ok(Some((expected.0.into(), expected.1))), "{channels}");
            assert_eq!(find(channels, &MotionWish::Without), Ok(None));
        }
    }

    #[test]
    fn another_view_layers_motion_is_not_taken_unless_named() {
        let channels = "A.Combined.R A.Combined.G A.Combined.B B.Vector.X B.Vector.Y";
        assert_eq!(find(channels, &MotionWish::Auto), Ok(None));
        let named = |name: &str| find(channels, &MotionWish::Named(name.into()));
        assert_eq!(named("B.Vector"), Ok(Some(("B.Vector".into(), 2))));
        assert!(named("C.Vector").unwrap_err().starts_with("has no layer `C.Vector`"));
    }

    #[test]
    fn a_named_layer_without_vectors_is_refused() {
        let found = find("R G B Depth.Z", &MotionWish::Named("Depth".into()));
        assert!(found.unwrap_err().contains("has the channels Z and not X and Y"));
    }
}
