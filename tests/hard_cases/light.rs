//! Light of any hue, brightness and pattern is kept, by every built-in tier.

use wgdenoise::{Image, Precision, Quality};

use crate::weights;
use wgdenoise_testing::gpu::gpu;
use wgdenoise_testing::hard_cases::cases::{clean, with_noise};
use wgdenoise_testing::hard_cases::engines::engine;
use wgdenoise_testing::{Random, run_cases};

const SIZE: [u32; 2] = [128, 96];

/// An image of [`SIZE`] by column and row.
fn image(pixel: impl Fn([f32; 2]) -> [f32; 3]) -> Image {
    let places = (0..SIZE[0] * SIZE[1]).map(|i| [i % SIZE[0], i / SIZE[0]].map(|at| at as f32));
    Image::new(SIZE[0], SIZE[1], places.map(pixel).collect()).expect("the count is right")
}

fn map(image: &Image, pixel: impl Fn(usize, [f32; 3]) -> [f32; 3]) -> Image {
    let mut image = image.clone();
    let pixels = image.pixels_mut().iter_mut().enumerate();
    pixels.for_each(|(i, value)| *value = pixel(i, *value));
    image
}

fn mean(image: &Image, channel: usize) -> f64 {
    let sum: f64 = image.pixels().iter().map(|pixel| f64::from(pixel[channel])).sum();
    sum / image.pixels().len() as f64
}

/// The mean difference of the square roots, roughly as visible.
fn error(found: &Image, truth: &Image) -> f64 {
    let root = |v: f32| f64::from(v.max(0.0)).sqrt();
    let pairs = found.pixels().iter().flatten().zip(truth.pixels().iter().flatten());
    let all = found.pixels().len() as f64 * 3.0;
    pairs.map(|(a, b)| (root(*a) - root(*b)).abs()).sum::<f64>() / all
}

/// Runs every case in every tier; `check` gets the case's input and result.
fn in_every_tier<T: Copy + std::fmt::Debug>(
    cases: &[T],
    input: impl Fn(T) -> Image,
    check: impl Fn(T, &Image, &Image) -> Result<(), String>,
) {
    for quality in Quality::ALL {
        let denoise = engine(gpu(), &weights(quality), Precision::F16, None);
        run_cases(cases.iter().map(|&case| (quality.name(), case)), |&(_, case)| {
            let noisy = input(case);
            check(case, &noisy, &denoise(&noisy))
        });
    }
}

/// Fails unless `found` is within a share of `expected`.
fn near(what: &str, found: f64, expected: f64, share: f64) -> Result<(), String> {
    let off = (found / expected - 1.0).abs();
    // NaN is not near.
    if off <= share { Ok(()) } else { Err(format!("{what}: {found}, expected {expected}")) }
}

#[test]
fn every_hue_keeps_its_light() {
    let hues = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 0.0],
        [1.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
        [1.0, 0.01, 0.01],
        [0.05, 1.0, 0.05],
        [1.0, 0.5, 1e-4],
    ];
    let gray = map(&clean(), |_, [r, ..]| [r; 3]);
    let lit = |hue: [f32; 3]| map(&gray, |_, [v, ..]| hue.map(|share| v * share));
    in_every_tier(
        &hues,
        |hue| with_noise(&lit(hue), 7),
        |hue, noisy, found| {
            (0..3).try_for_each(|c| match hue[c] {
                0.0 if mean(found, c) == 0.0 => Ok(()),
                0.0 => Err(format!("channel {c} was black")),
                _ => near(&format!("channel {c}"), mean(found, c), mean(noisy, c), 0.02),
            })
        },
    );
}

#[test]
fn gray_stays_gray() {
    let gray = |seed| map(&with_noise(&clean(), seed), |_, [r, ..]| [r; 3]);
    in_every_tier(&[1, 2], gray, |_, _, found| {
        let colored = found.pixels().iter().filter(|[r, g, b]| r != g || g != b).count();
        if colored == 0 { Ok(()) } else { Err(format!("{colored} pixels have a hue")) }
    });
}

/// Each of four samples has one of three wavelengths and three times its light.
#[test]
fn samples_of_one_wavelength_keep_their_light() {
    let sampled = |seed| {
        let mut random = Random::new(seed);
        let mut image = with_noise(&clean(), seed);
        for pixel in image.pixels_mut() {
            let mut counts = [0.0; 3];
            for _ in 0..4 {
                counts[((random.value() * 0.5 + 0.5) * 3.0) as usize] += 0.75;
            }
            *pixel = std::array::from_fn(|c| pixel[c] * counts[c]);
        }
        image
    };
    in_every_tier(&[3, 4], sampled, |_, noisy, found| {
        (0..3).try_for_each(|c| near(&format!("{c}"), mean(found, c), mean(noisy, c), 0.03))
    });
}

#[test]
fn lamps_keep_their_light_at_any_brightness() {
    let inside = |i: usize| {
        let [x, y] = [i % 128, i / 128].map(|at| at as f64);
        (x - 64.0).hypot(y - 48.0) < 12.0
    };
    let lit = |lamp: f32| {
        map(&with_noise(&clean(), 5), |i, pixel| if inside(i) { [lamp; 3] } else { pixel })
    };
    in_every_tier(&[10.0, 100.0, 1e3, 1e4, 65504.0], lit, |lamp, _, found| {
        let lamp_pixels = (0..found.pixels().len()).filter(|&i| inside(i));
        let light: Vec<_> = lamp_pixels.map(|i| f64::from(found.pixels()[i][1])).collect();
        near("mean", light.iter().sum::<f64>() / light.len() as f64, f64::from(lamp), 0.02)
    });
}

#[test]
fn skies_and_ramps_with_little_noise_never_get_worse() {
    let sky = |[x, y]: [f32; 2]| [0.4 + 0.001 * x, 0.5, 0.6 + 0.001 * y];
    let cases = [1e-2, 3e-3, 1e-3, 3e-4].map(|sigma| [false, true].map(|ramp| (sigma, ramp)));
    let truth = |ramp: bool| if ramp { image(sky) } else { image(|_| [0.5; 3]) };
    let noisy = |(sigma, ramp): (f32, bool)| {
        let mut random = Random::new(8);
        let mut image = truth(ramp);
        image.pixels_mut().iter_mut().flatten().for_each(|v| *v *= 1.0 + sigma * random.value());
        image
    };
    in_every_tier(&cases.concat(), noisy, |(_, ramp), noisy, found| {
        let [before, after] = [noisy, found].map(|image| error(image, &truth(ramp)));
        if after <= before { Ok(()) } else { Err(format!("error {before} became {after}")) }
    });
}

#[test]
fn patterns_of_single_pixels_keep_their_light_in_every_phase() {
    type Pattern = (&'static str, fn(u32, u32) -> bool);
    let patterns: [Pattern; 4] = [
        ("checks", |x, y| (x + y) % 2 == 0),
        ("columns", |x, _| x % 2 == 0),
        ("rows", |_, y| y % 2 == 0),
        ("dots", |x, y| x % 2 == 0 && y % 2 == 0),
    ];
    let cases = patterns.map(|pattern| [0, 1].map(|phase| (pattern.0, pattern.1, phase)));
    let picture = |(_, is_lit, phase): (&str, fn(u32, u32) -> bool, u32)| {
        let lit = |[x, y]: [f32; 2]| is_lit(x as u32 + phase, y as u32 + phase);
        image(|at| [f32::from(u8::from(lit(at))); 3])
    };
    in_every_tier(&cases.concat(), picture, |_, noisy, found| {
        near("mean", mean(found, 1), mean(noisy, 1), 0.02)
    });
}

/// A dark surrounding of three times the scene's area.
#[test]
fn a_dark_surrounding_changes_nothing_in_the_scene() {
    let surrounded = |level: f32| {
        let (scene, dark) = (with_noise(&clean(), 6), with_noise(&image(|_| [level; 3]), 9));
        let row = |y: u32| [dark.row(y % 96), dark.row((y + 7) % 96)].concat();
        let beside = |y: u32| [scene.row(y), dark.row((y + 31) % 96)].concat();
        let rows = (0..96).flat_map(beside).chain((0..96).flat_map(row));
        Image::new(256, 192, rows.collect()).expect("the count is right")
    };
    let scene_error = |found: &Image| {
        // Without the pixels at the border, where a surrounding is seen.
        let pixels = (0..80).flat_map(|y| found.row(y)[..112].to_vec()).collect();
        let truth = clean();
        let cut = (0..80).flat_map(|y| truth.row(y)[..112].to_vec()).collect();
        let [found, truth] = [pixels, cut].map(|pixels| Image::new(112, 80, pixels));
        error(&found.expect("the count is right"), &truth.expect("the count is right"))
    };
    for quality in Quality::ALL {
        let denoise = engine(gpu(), &weights(quality), Precision::F16, None);
        let alone = scene_error(&denoise(&with_noise(&clean(), 6)));
        run_cases([0.0, 1e-6, 1e-4].map(|level| (quality.name(), level)), |&(_, level)| {
            near("error", scene_error(&denoise(&surrounded(level))), alone, 0.02)
        });
    }
}

#[test]
fn an_infinite_sun_is_the_brightest_thing() {
    let inside = |[x, y]: [f32; 2]| (x - 40.0).hypot(y - 40.0) < 6.0;
    let sun = |finite: f32| {
        let noisy = with_noise(&clean(), 4);
        map(&noisy, |i, pixel| {
            let at = [i % 128, i / 128].map(|at| at as f32);
            if inside(at) { [f32::INFINITY, finite, f32::INFINITY] } else { pixel }
        })
    };
    in_every_tier(&[f32::INFINITY, 100.0], sun, |finite, _, found| {
        let [r, g, _] = found.row(40)[40];
        near("red", f64::from(r), 65504.0, 0.02)?;
        near("green", f64::from(g), f64::from(finite.min(65504.0)), 0.02)?;
        let outside = found.row(70).iter().flatten().fold(0.0_f32, |most, &v| most.max(v));
        if outside < 50.0 { Ok(()) } else { Err(format!("{outside} far from the sun")) }
    });
}

#[test]
fn wide_gamuts_keep_their_negative_channels() {
    let hues = [[-0.2, 1.0, -0.05], [1.0, -0.1, 0.2]];
    let wide =
        |hue: [f32; 3]| map(&with_noise(&clean(), 2), |_, [r, ..]| hue.map(|share| share * r));
    in_every_tier(&hues, wide, |_, noisy, found| {
        (0..3).try_for_each(|c| near(&format!("{c}"), mean(found, c), mean(noisy, c), 0.02))
    });
}
