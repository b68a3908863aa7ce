//! Computes each [`Measure`].

use wgdenoise::Image;

use super::cases::{Case, Measure, clean};

/// Measures a result. Returns infinity if a value is not finite, or is negative although the input
/// has no negative value. `sound` is the result for the undamaged noisy image.
pub fn measure(case: &Case, found: &Image, sound: &Image) -> f64 {
    assert_eq!(found.size(), case.color.size(), "{}", case.name);
    let signed = values(&case.color).any(|v| v < 0.0);
    if values(found).any(|v| !v.is_finite() || v < 0.0 && !signed) {
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
        Measure::Channels => {
            let kept = |c| relative(channel(found, c), channel(&case.color, c));
            [0, 1, 2].map(kept).into_iter().fold(0.0, f64::max)
        }
        Measure::Hue => most_colored(found),
        Measure::Disc { radius, expected } => {
            let mean = disc(found, radius);
            (0..3).map(|c| relative(mean[c], f64::from(expected[c]))).fold(0.0, f64::max)
        }
        Measure::Noise(truth) => error(found, &truth()) / error(&case.color, &truth()),
        Measure::Scene => {
            let [found, sound] = [found, sound].map(scene);
            relative(visible(&found, &scene(&clean())), visible(&sound, &scene(&clean())))
        }
        Measure::Finite => 0.0,
    }
}

/// The relative difference from `expected`; infinite if only `expected` is 0.
fn relative(found: f64, expected: f64) -> f64 {
    if found == expected { 0.0 } else { (found / expected - 1.0).abs() }
}

/// The mean of a channel.
fn channel(image: &Image, c: usize) -> f64 {
    let sum: f64 = image.pixels().iter().map(|pixel| f64::from(pixel[c])).sum();
    sum / image.pixels().len() as f64
}

fn most_colored(image: &Image) -> f64 {
    let range = |pixel: &[f32; 3]| {
        let [least, most] = [f32::min, f32::max].map(|f| pixel.iter().copied().reduce(f));
        f64::from(most.expect("three channels") - least.expect("three channels"))
    };
    image.pixels().iter().map(range).fold(0.0, f64::max)
}

/// The mean of each channel in a central disc.
fn disc(image: &Image, radius: f64) -> [f64; 3] {
    let (width, height) = image.size();
    let inside = |&(i, _): &(u32, &[f32; 3])| {
        let [x, y] = [i % width, i / width].map(f64::from);
        (x - f64::from(width / 2)).hypot(y - f64::from(height / 2)) < radius
    };
    let pixels: Vec<_> = (0..).zip(image.pixels()).filter(inside).map(|(_, pixel)| pixel).collect();
    [0, 1, 2]
        .map(|c| pixels.iter().map(|pixel| f64::from(pixel[c])).sum::<f64>() / pixels.len() as f64)
}

/// The upper left, the usual image's size without the margins near the surroundings.
fn scene(image: &Image) -> Image {
    const SIZE: [u32; 2] = [112, 80];
    let rows = (0..SIZE[1]).flat_map(|y| &image.row(y)[..SIZE[0] as usize]);
    Image::new(SIZE[0], SIZE[1], rows.copied().collect()).expect("the count is right")
}

/// The sum of differences of square roots, about equally visible in dark and bright areas.
fn visible(found: &Image, truth: &Image) -> f64 {
    let pairs = values(found).zip(values(truth));
    pairs.map(|(a, b)| (a.max(0.0).sqrt() - b.max(0.0).sqrt()).abs()).sum()
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
