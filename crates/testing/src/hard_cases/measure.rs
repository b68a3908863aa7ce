//! Computes each [`Measure`].

use wgdenoise::Image;

use super::cases::{Case, Measure, clean};

/// The measure of a case's result, or infinity if a value is negative or not finite. `sound` is the
/// result for the undamaged noisy picture.
pub fn measure(case: &Case, found: &Image, sound: &Image) -> f64 {
    assert_eq!(found.size(), case.color.size(), "{}", case.name);
    if values(found).any(|v| !v.is_finite() || v < 0.0) {
        return f64::INFINITY;
    }
    match case.measure {
        Measure::Changed => changed(found, sound) as f64,
        Measure::Error => error(found, &clean()) / error(sound, &clean()),
        Measure::Unchanged => most_off(found, &case.color, 1.0),
        Measure::Exposure(factor) => most_off(found, sound, f64::from(factor)),
        Measure::Light => values(found).fold(0.0, f64::max),
        Measure::Mean => (mean(found) / mean(&case.color) - 1.0).abs(),
        Measure::Halo(at) => {
            furthest(found, at) / f64::from(case.color.row(at[1])[at[0] as usize][1])
        }
        Measure::Finite => 0.0,
    }
}

fn values(image: &Image) -> impl Iterator<Item = f64> {
    image.pixels().iter().flatten().map(|&v| f64::from(v))
}

fn mean(image: &Image) -> f64 {
    values(image).sum::<f64>() / values(image).count() as f64
}

fn changed(found: &Image, sound: &Image) -> usize {
    let differs = |(a, b): (&f32, &f32)| (a - b).abs() > 0.1 * b;
    let pixels = found.pixels().iter().zip(sound.pixels());
    pixels.filter(|(found, sound)| found.iter().zip(*sound).any(differs)).count()
}

fn error(found: &Image, clean: &Image) -> f64 {
    values(found).zip(values(clean)).map(|(a, b)| (a - b).abs()).sum()
}

/// The largest relative difference from `expected` times `factor`.
fn most_off(found: &Image, expected: &Image, factor: f64) -> f64 {
    let off = |(found, expected): (f64, f64)| (found / (expected * factor) - 1.0).abs();
    values(found).zip(values(expected)).map(off).fold(0.0, f64::max)
}

/// The largest value more than one pixel away from `at`.
fn furthest(found: &Image, [x, y]: [u32; 2]) -> f64 {
    let far = |&(i, _): &(u32, &[f32; 3])| {
        let [u, v] = [i % found.width(), i / found.width()];
        u.abs_diff(x).max(v.abs_diff(y)) > 1
    };
    let far = (0..).zip(found.pixels()).filter(far);
    far.flat_map(|(_, pixel)| pixel).fold(0.0, |most, &v| f64::from(v).max(most))
}
