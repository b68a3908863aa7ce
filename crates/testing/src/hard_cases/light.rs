//! Hard cases for light: hues, lamps, skies, patterns and surroundings that a network need not have
//! seen in training. Every built-in tier is tested with them.

use wgdenoise::Image;

use super::cases::{Case, Measure, clean, with_noise};
use crate::random::Random;

/// Every case.
pub fn light() -> Vec<Case> {
    let groups = [hues(), samples(), lamps(), skies(), patterns(), surroundings()];
    groups.into_iter().flatten().collect()
}

const WIDTH: u32 = 128;
const HEIGHT: u32 = 96;

/// Makes an image from a function of column and row.
fn image(pixel: impl Fn([f32; 2]) -> [f32; 3]) -> Image {
    let places = (0..WIDTH * HEIGHT).map(|i| [i % WIDTH, i / WIDTH].map(|at| at as f32));
    Image::new(WIDTH, HEIGHT, places.map(pixel).collect()).expect("the count is right")
}

fn map(mut image: Image, mut pixel: impl FnMut([f32; 2], [f32; 3]) -> [f32; 3]) -> Image {
    for (i, value) in image.pixels_mut().iter_mut().enumerate() {
        let at = [i % WIDTH as usize, i / WIDTH as usize].map(|at| at as f32);
        *value = pixel(at, *value);
    }
    image
}

/// Single channels, mixtures, and wide gamuts with negative channels.
fn hues() -> Vec<Case> {
    let hues = [
        ("red", [1.0, 0.0, 0.0]),
        ("green", [0.0, 1.0, 0.0]),
        ("blue", [0.0, 0.0, 1.0]),
        ("yellow", [1.0, 1.0, 0.0]),
        ("magenta", [1.0, 0.0, 1.0]),
        ("cyan", [0.0, 1.0, 1.0]),
        ("red with 1 % of the others", [1.0, 0.01, 0.01]),
        ("green with 5 % of the others", [0.05, 1.0, 0.05]),
        ("sodium", [1.0, 0.5, 1e-4]),
    ];
    // Negative channels, which wide gamuts need, have noise like the others.
    let wide = [("green beyond sRGB", [-0.2, 1.0, -0.05]), ("red beyond sRGB", [1.0, -0.1, 0.2])];
    let wide = wide.map(|(name, hue): (&str, [f32; 3])| {
        let noisy = map(with_noise(&clean(), 2), |_, [r, ..]| hue.map(|share| share * r));
        Case::new(format!("light of {name}"), noisy, Measure::Channels, 0.02)
    });
    let case = |(name, hue): (&str, [f32; 3])| {
        let lit = map(clean(), |_, [r, ..]| hue.map(|share| share * r));
        Case::new(format!("light of {name}"), with_noise(&lit, 7), Measure::Channels, 0.02)
    };
    let gray = map(with_noise(&clean(), 3), |_, [r, ..]| [r; 3]);
    let gray = Case::new("gray noise", gray, Measure::Hue, 0.0);
    hues.map(case).into_iter().chain(wide).chain([gray]).collect()
}

/// Sample noise: one of three wavelengths per sample, or mostly no light.
fn samples() -> Vec<Case> {
    let spectral = |seed| {
        let mut random = Random::new(seed);
        map(with_noise(&clean(), seed), |_, pixel| {
            let mut light = [0.0; 3];
            for _ in 0..4 {
                light[((random.value() * 0.5 + 0.5) * 3.0) as usize] += 0.75;
            }
            std::array::from_fn(|c| pixel[c] * light[c])
        })
    };
    let spectral = [3, 4].map(|seed| {
        let name = format!("one wavelength a sample, 4 spp, seed {seed}");
        Case::new(name, spectral(seed), Measure::Channels, 0.03)
    });
    let sparse = [(1, 0.1), (4, 0.05)].map(|(count, goal)| {
        let name = format!("light in 5 % of the samples, {count} spp");
        Case::new(name, sparse(count), Measure::Channels, goal)
    });
    spectral.into_iter().chain(sparse).collect()
}

/// Samples of which one in twenty has twenty times the light and the others none.
fn sparse(count: u32) -> Image {
    let mut random = Random::new(11);
    map(clean(), |_, pixel| {
        let lit = (0..count).filter(|_| random.value() > 0.9).count();
        pixel.map(|v| v * 20.0 * lit as f32 / count as f32)
    })
}

fn in_disc([x, y]: [f32; 2], radius: f32) -> bool {
    (x - 64.0).hypot(y - 48.0) < radius
}

/// Flat lamps and suns in a noisy scene.
fn lamps() -> Vec<Case> {
    let lit = |lamp: [f32; 3]| {
        map(with_noise(&clean(), 5), |at, pixel| if in_disc(at, 12.0) { lamp } else { pixel })
    };
    let lamp = |value: f32| {
        let measure = Measure::Disc { radius: 12.0, expected: [value; 3] };
        Case::new(format!("lamp of {value}"), lit([value; 3]), measure, 0.02)
    };
    let inf = f32::INFINITY;
    let sun = |name: &str, lamp: [f32; 3]| {
        let measure = Measure::Disc { radius: 12.0, expected: lamp.map(|v| v.min(65504.0)) };
        Case::new(name, lit(lamp), measure, 0.02)
    };
    let suns = [sun("sun of inf", [inf; 3]), sun("sun of inf, 100, inf", [inf, 100.0, inf])];
    let lamps = [10.0, 100.0, 1e3, 1e4, 65504.0].map(lamp);
    lamps.into_iter().chain(suns).collect()
}

fn sky() -> Image {
    image(|_| [0.5; 3])
}

fn ramp() -> Image {
    image(|[x, y]| [0.4 + 0.001 * x, 0.5, 0.6 + 0.001 * y])
}

/// Little noise, which must not increase.
fn skies() -> Vec<Case> {
    let case = |name: &str, truth: fn() -> Image, percent: f32| {
        let mut random = Random::new(8);
        let mut noisy = truth();
        let values = noisy.pixels_mut().iter_mut().flatten();
        values.for_each(|v| *v *= 1.0 + 0.01 * percent * random.value());
        Case::new(format!("{name} with {percent} % of noise"), noisy, Measure::Noise(truth), 1.0)
    };
    let percents = [1.0, 0.3, 0.1, 0.03];
    let skies = percents.map(|percent| case("sky", sky, percent));
    skies.into_iter().chain(percents.map(|percent| case("ramp", ramp, percent))).collect()
}

/// Black and white patterns of single pixels, in both phases.
fn patterns() -> Vec<Case> {
    type Pattern = (&'static str, fn(u32, u32, u32) -> bool);
    let patterns: [Pattern; 4] = [
        ("checks", |x, y, phase| (x + y + phase) % 2 == 0),
        ("columns", |x, _, phase| (x + phase) % 2 == 0),
        ("rows", |_, y, phase| (y + phase) % 2 == 0),
        ("dots", |x, y, phase| (x + phase) % 2 == 0 && (y + phase) % 2 == 0),
    ];
    let case = |(name, is_lit): Pattern, phase: u32| {
        let lit = |[x, y]: [f32; 2]| is_lit(x as u32, y as u32, phase);
        let picture = image(|at| [f32::from(u8::from(lit(at))); 3]);
        let first = if lit([0.0; 2]) { "white" } else { "black" };
        Case::new(format!("{name} of 1 pixel, {first} first"), picture, Measure::Channels, 0.02)
    };
    patterns.into_iter().flat_map(|pattern| [0, 1].map(|phase| case(pattern, phase))).collect()
}

/// The usual image in dark surroundings of three times its area, which must not change it.
fn surroundings() -> Vec<Case> {
    [0.0, 1e-6, 1e-4].map(surrounded).into()
}

fn surrounded(level: f32) -> Case {
    let (scene, dark) = (with_noise(&clean(), 1), with_noise(&image(|_| [level; 3]), 9));
    let beside = |y: u32| [scene.row(y), dark.row(y)].concat();
    let below = |y: u32| [dark.row((y + 7) % HEIGHT), dark.row((y + 50) % HEIGHT)].concat();
    let rows = (0..HEIGHT).flat_map(beside).chain((0..HEIGHT).flat_map(below)).collect();
    let picture = Image::new(2 * WIDTH, 2 * HEIGHT, rows).expect("the count is right");
    let name = format!("dark surrounding of {level:e}");
    Case { missed: [Some(0.021); 3], ..Case::new(name, picture, Measure::Scene, 0.02) }
}
