//! How well two frames agree at each pixel.

use rayon::prelude::*;

use crate::sample::Four;
use crate::shot::Feature;
use crate::trend::{Changes, trend};
use crate::{Offsets, Shot};

/// The differences at which agreement falls to 1/e: pixels off after following the motion there and
/// back, albedo, normals, and light relative to its mean. Albedo and normals are noisy, light is
/// denoised; all three are averaged over 3×3 pixels.
const MOTION: f32 = 1.0;
const ALBEDO: f32 = 0.1;
const NORMAL: f32 = 0.2;
const LIGHT: f32 = 0.4;
/// The same for the mean change of light over 15×15 pixels, which noise hardly affects.
const TREND: f32 = 0.13;

/// Added to the light, as a fraction of the frame's mean, so that differences in the dark count
/// little.
const DARK: f32 = 0.02;

/// Measures how well each pixel of `own` agrees with the place in `other` its offset leads to: from
/// 0 for not at all to 1, row by row. It is 0 where the surface has left the picture.
///
/// `to` leads from `own` to `other`; `back`, if known, leads from `other` to `own`. Where one does
/// not undo the other, one of the two surfaces is hidden. Albedo and normals must agree if both
/// frames have them. Light must agree too, because reflections and shadows do not move with the
/// surface.
///
/// # Panics
/// If the sizes differ.
#[must_use]
pub fn agreement(own: &Shot, other: &Shot, to: &Offsets, back: Option<&Offsets>) -> Vec<f32> {
    assert!([other.size(), to.size()] == [own.size(); 2], "sizes");
    let shared = |feature| own.has(feature) && other.has(feature);
    let features = [(Feature::Albedo, ALBEDO), (Feature::Normal, NORMAL)].into_iter();
    let features: Vec<_> = features.filter(|(feature, _)| shared(*feature)).collect();
    let dark = DARK * own.light().max(f32::MIN_POSITIVE);
    let at = |i: usize| {
        let Some(four) = to.four(i) else { return Difference::default() };
        let pixel = own.compare(i, other, &four);
        let mut squares = 0.0;
        for (feature, scale) in &features {
            squares += (pixel.difference(*feature) / scale).powi(2);
        }
        squares += back.map_or(0.0, |back| (detour(to.pixels()[i], back, &four) / MOTION).powi(2));
        let light = (pixel.light_difference(dark) / LIGHT).powi(2);
        Difference::new(pixel.light_change(dark), [squares, squares + light])
    };
    let found: Vec<_> = (0..to.pixels().len()).into_par_iter().map(at).collect();
    let changes: Vec<_> = found.iter().map(|difference| difference.changes).collect();
    let trends = trend(&changes, own.size().0 as usize, TREND);
    found.iter().zip(&trends).map(|(found, trend)| found.agreement * (-trend).exp()).collect()
}

/// How a pixel differs from its counterpart in another frame.
#[derive(Clone, Copy, Debug, Default)]
struct Difference {
    /// The change of light, weighted by how well everything else agrees.
    changes: Changes,
    /// Agreement in everything, light included, from 0 to 1.
    agreement: f32,
}

impl Difference {
    /// Takes the change of light, and the sums of squared differences without and with light.
    fn new(change: f32, [others, all]: [f32; 2]) -> Self {
        // NaN agrees with nothing.
        if !(all.is_finite() && change.is_finite()) {
            return Self::default();
        }
        Self { changes: Changes::new(change, (-others).exp()), agreement: (-all).exp() }
    }
}

/// How far a round trip along both offsets ends from its start, in pixels.
fn detour([right, down]: [f32; 2], back: &Offsets, four: &Four) -> f32 {
    let [left, up] = four.mean(back.pixels());
    (right + left).hypot(down + up)
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgdenoise::Image;

    const SIZE: (u32, u32) = (12, 8);

    fn gray(value: f32) -> Image {
        Image::filled(SIZE.0, SIZE.1, [value; 3]).expect("a valid image")
    }

    fn shot(color: &Image, albedo: &Image, normal: &Image) -> Shot {
        Shot::new(color, Some(albedo), Some(normal))
    }

    fn all(offset: [f32; 2]) -> Offsets {
        Offsets::new(SIZE.0, SIZE.1, vec![offset; 96]).expect("it fits")
    }

    #[test]
    fn equal_frames_agree_wherever_the_surface_is_in_the_picture() {
        let image = gray(0.5);
        let own = shot(&image, &image, &image);
        let found = agreement(&own, &own, &all([3.0, 0.0]), Some(&all([-3.0, 0.0])));
        for (i, agreement) in found.into_iter().enumerate() {
            assert_eq!(agreement, f32::from(u8::from(i % 12 + 3 < 12)), "{i}");
        }
    }

    #[test]
    fn each_difference_alone_ends_agreement() {
        let (half, other) = (gray(0.5), gray(1.5));
        let [still, away] = [all([0.0; 2]), all([0.0, 4.0])];
        let own = shot(&half, &half, &half);
        for (what, shot, back) in [
            ("light", shot(&other, &half, &half), &still),
            ("albedo", shot(&half, &other, &half), &still),
            ("normal", shot(&half, &half, &other), &still),
            ("motion", own.clone(), &away),
        ] {
            let found = agreement(&own, &shot, &still, Some(back));
            assert!(found.iter().all(|v| *v < 0.1), "{what}: {}", found[0]);
        }
    }

    #[test]
    fn absent_features_and_an_unknown_way_back_say_nothing() {
        let (half, other) = (gray(0.5), gray(0.9));
        let bare = Shot::new(&half, None, None);
        let found = agreement(&shot(&half, &other, &other), &bare, &all([0.0; 2]), None);
        assert!(found.iter().all(|v| *v == 1.0));
    }

    #[test]
    fn light_agrees_relative_to_its_level_and_darkness_agrees() {
        let agree = |a: f32, b: f32| {
            let (own, other) = (gray(a), gray(b));
            let bare = |color| Shot::new(color, None, None);
            agreement(&bare(&own), &bare(&other), &all([0.0; 2]), None)[0]
        };
        assert!((agree(1.0, 1.05) - agree(1e4, 1.05e4)).abs() < 1e-4);
        assert!(agree(1.0, 1.02) > 0.9 && agree(1.0, 1.3) < 0.1);
        assert_eq!(agree(0.0, 0.0), 1.0);
        assert_eq!(agree(1.0, f32::NAN), 0.0);
    }

    #[test]
    fn light_that_changes_over_an_area_agrees_less_than_noise_of_that_size() {
        let (width, height) = (45, 30);
        let is_light = |i: u32| (i % width / 3 + i / width / 3).is_multiple_of(2);
        let sign = |i: u32| if is_light(i) { 1.0 } else { -1.0 };
        let shot = |change: &dyn Fn(u32) -> f32| {
            let pixels = (0..width * height).map(|i| [1.0 + change(i); 3]).collect();
            Shot::new(&Image::new(width, height, pixels).expect("a valid image"), None, None)
        };
        let mean = |other: &Shot| {
            let still = Offsets::still(width, height);
            let found = agreement(&shot(&|_| 0.0), other, &still, None);
            found.iter().sum::<f32>() / found.len() as f32
        };
        let (noise, brighter) = (mean(&shot(&|i| 0.25 * sign(i))), mean(&shot(&|_| 0.25)));
        assert!(noise > 0.7 && brighter < 0.1, "{noise}, {brighter}");
    }

    #[test]
    fn what_changes_beside_a_surface_does_not_count_for_it() {
        let halves = |left: f32, right: f32| {
            let pixels = (0..40 * 20).map(|i| [if i % 40 < 20 { left } else { right }; 3]);
            Image::new(40, 20, pixels.collect()).expect("a valid image")
        };
        let own = Shot::new(&halves(1.0, 1.0), Some(&halves(0.2, 0.2)), None);
        let other = Shot::new(&halves(3.0, 1.0), Some(&halves(0.9, 0.2)), None);
        let found = agreement(&own, &other, &Offsets::still(40, 20), None);
        let beside = found.chunks(40).map(|row| row[22]);
        assert!(beside.clone().all(|v| v > 0.9), "{:?}", beside.collect::<Vec<_>>());
    }
}
