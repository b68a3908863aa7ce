//! The table of hard cases: inputs, measures and their goals.

use wgdenoise::Image;

use crate::random::Random;

/// One row of the table.
pub struct Case {
    pub name: String,
    pub color: Image,
    pub measure: Measure,
    /// The upper bound that the measure should meet.
    pub goal: f64,
    /// Looser bounds for the denoisers that miss the goal, indexed by [`By`].
    pub(super) missed: [Option<f64>; 3],
}

/// The denoisers under test.
#[derive(Clone, Copy)]
pub enum By {
    /// The engine with the balanced weights and 32-bit tensors.
    F32,
    /// The engine with the balanced weights and 16-bit tensors.
    F16,
    /// The CPU reference with the fast weights.
    FastReference,
}

/// What to measure in a result.
#[derive(Clone, Copy)]
pub enum Measure {
    /// The number of pixels that differ by more than 10 % from the result without the fault.
    Changed,
    /// The mean error, relative to that of the result without the fault.
    Error,
    /// The largest relative difference from the input.
    Unchanged,
    /// The largest relative difference from the result at another exposure times this factor.
    Exposure(f32),
    /// The largest value.
    Light,
    /// The relative difference between the means of result and input.
    Mean,
    /// The largest value more than one pixel away from this pixel, relative to the pixel's input.
    Halo([u32; 2]),
    /// The largest relative difference between a channel's means in result and input. A black
    /// channel must stay black.
    Channels,
    /// The largest difference between two channels of a pixel.
    Hue,
    /// The largest relative difference of a channel's mean from the true one, in a central disc.
    Disc {
        /// Radius of the disc in pixels.
        radius: f64,
        /// The true mean.
        expected: [f32; 3],
    },
    /// The error relative to the input's, both against the truth that this function makes.
    Noise(fn() -> Image),
    /// The relative difference of the error in the upper left from that without the surroundings.
    Scene,
    /// Nothing beyond what every case checks: that all values are finite and non-negative.
    Finite,
}

const SIZE: [u32; 2] = [128, 96];

impl Case {
    pub(super) fn new(name: impl Into<String>, color: Image, measure: Measure, goal: f64) -> Self {
        Self { name: name.into(), color, measure, goal, missed: [None; 3] }
    }

    /// The bound that a test enforces.
    pub fn bound(&self, by: By) -> f64 {
        self.missed[by as usize].unwrap_or(self.goal)
    }
}

/// The image that most cases damage: gradients, a wave and a disc.
pub fn clean() -> Image {
    image(SIZE, |[x, y]| {
        let [u, v] = [x as f32, y as f32];
        let disc = if (u - 64.0).hypot(v - 48.0) < 30.0 { 2.0 } else { 1.0 };
        [0.2 + 0.3 * u / 128.0, 0.3 + 0.2 * (v / 15.0).sin(), 0.25].map(|c| c * disc)
    })
}

/// [`clean`] with noise.
pub fn noisy() -> Image {
    with_noise(&clean(), 1)
}

/// Adds noise with a standard deviation of 0.7 times the value to each channel.
pub fn with_noise(image: &Image, seed: u64) -> Image {
    let mut random = Random::new(seed);
    let mut uniform = || 0.5 * random.value() + 0.500_001;
    let mut image = image.clone();
    image.pixels_mut().iter_mut().flatten().for_each(|v| *v *= -0.5 * (uniform() * uniform()).ln());
    image
}

/// Every case.
pub fn cases() -> Vec<Case> {
    [bad_pixels(), fireflies(), even_images(), patterns(), exposures(), sizes(), extremes()]
        .into_iter()
        .flatten()
        .collect()
}

fn bad_pixels() -> Vec<Case> {
    let bad = [f32::NAN, f32::NEG_INFINITY, -1.0, 1e-42];
    let one = |value: f32| Case {
        // With the fast weights, a black pixel changes 12 pixels.
        missed: [None, None, Some(16.0)],
        ..Case::new(
            format!("one pixel of {}", number(value)),
            spoilt(value, 1),
            Measure::Changed,
            9.0,
        )
    };
    let many = |value: f32| {
        let name = format!("1 % of the pixels {}", number(value));
        Case::new(name, spoilt(value, 100), Measure::Error, 1.5)
    };
    let mut bucket = noisy();
    for y in 32..48 {
        bucket.pixels_mut()[y * 128 + 48..][..16].fill([f32::NAN; 3]);
    }
    let bucket = Case::new("a bucket of 16×16 NaN", bucket, Measure::Error, 1.5);
    let many = [f32::NAN, f32::INFINITY].map(many);
    bad.map(one).into_iter().chain(many).chain([bucket]).collect()
}

fn fireflies() -> Vec<Case> {
    let firefly = |value: f32| {
        Case::new(
            format!("one firefly of {}", number(value)),
            spoilt(value, 1),
            Measure::Changed,
            100.0,
        )
    };
    [5.0, 20.0, 70.0, 1e4, 1e6, 1e12, 1e30, f32::MAX, f32::INFINITY].map(firefly).into()
}

fn even_images() -> Vec<Case> {
    let even = |value: f32| {
        let name = format!("constant {}", number(value));
        Case::new(name, filled(SIZE, [value; 3]), Measure::Unchanged, 0.01)
    };
    let black = |value: f32| {
        let name = format!("every pixel {}", number(value));
        Case::new(name, filled(SIZE, [value; 3]), Measure::Light, 0.0)
    };
    let hue = Case::new("constant, colored", filled(SIZE, [9.0, 0.5, 0.0]), Measure::Mean, 0.01);
    let evens = [1e-3, 0.18, 0.5, 1.0, 100.0].map(even);
    let blacks = [0.0, f32::NAN, -1.0].map(black);
    // Very bright light.
    let infinite = filled(SIZE, [f32::INFINITY; 3]);
    let infinite = Case::new("every pixel inf", infinite, Measure::Finite, 0.0);
    evens.into_iter().chain([hue]).chain(blacks).chain([infinite]).collect()
}

fn patterns() -> Vec<Case> {
    let board = |side: u32| {
        image(SIZE, move |[x, y]| [f32::from((x / side + y / side).is_multiple_of(2)); 3])
    };
    let fine = Case::new("checkerboard of 1 pixel", board(1), Measure::Mean, 0.02);
    let coarse = Case::new("checkerboard of 16 pixels", board(16), Measure::Mean, 0.02);
    let one = image(SIZE, |at| [f32::from(at == [64, 48]); 3]);
    let one = Case::new("one pixel of 1 on black", one, Measure::Halo([64, 48]), 1e-3);
    let step = |at: u32| image(SIZE, move |[x, _]| [if x < at { 0.1 } else { 10.0 }; 3]);
    let border = Case {
        // The reference runs the fast weights, whose kernels mix 0.12 % of the bright side into the
        // dark side, which is 100 times darker.
        missed: [None, None, Some(0.13)],
        ..Case::new("a step on a block's border", step(64), Measure::Unchanged, 0.01)
    };
    let inside = Case::new("a step inside a block", step(70), Measure::Mean, 0.02);
    vec![fine, coarse, one, border, inside]
}

fn exposures() -> Vec<Case> {
    let exposure = |factor: f32| {
        let mut color = noisy();
        color.pixels_mut().iter_mut().flatten().for_each(|v| *v *= factor);
        let name = format!("exposure × {factor:e}");
        Case {
            // Scaled pixels round differently. If a 16-bit tensor then rounds to the neighboring
            // value, it differs by 2⁻¹¹; the end of the network may take two such steps.
            missed: [None, Some(1e-3), None],
            ..Case::new(name, color, Measure::Exposure(factor), 1e-4)
        }
    };
    [1e-12, 1e-8, 1e-6, 1e-3, 1e3, 1e6, 1e12].map(exposure).into()
}

fn sizes() -> Vec<Case> {
    let sizes = [[1, 1], [2, 1], [3, 2], [17, 15], [17, 17], [97, 89], [4096, 1], [1, 4096]];
    let gray = |[w, h]: [u32; 2]| {
        Case::new(format!("{w}×{h} of 0.5"), filled([w, h], [0.5; 3]), Measure::Unchanged, 0.02)
    };
    let noise = |[w, h]: [u32; 2]| {
        let mut random = Random::new(u64::from(w));
        let color = image([w, h], |_| [0; 3].map(|_| random.value().abs()));
        Case::new(format!("{w}×{h} of noise"), color, Measure::Finite, 0.0)
    };
    sizes.map(gray).into_iter().chain([[17, 15], [97, 89], [2, 300]].map(noise)).collect()
}

/// The limits of 16-bit and 32-bit floats.
fn extremes() -> Vec<Case> {
    let mut random = Random::new(7);
    // From the smallest 16-bit float to the largest.
    let mut value = || (20.0 * random.value() - 4.0).exp2();
    let range = image(SIZE, |_| [0; 3].map(|_| value()));
    let range = Case::new("noise from 2^-24 to 65504", range, Measure::Finite, 0.0);
    let mut dark = filled(SIZE, [6e-8; 3]);
    dark.pixels_mut()[..64].fill([65504.0; 3]);
    let dark = Case::new("65504 beside 6e-8", dark, Measure::Finite, 0.0);
    let even = |value: f32| {
        let name = format!("constant {}", number(value));
        Case::new(name, filled(SIZE, [value; 3]), Measure::Unchanged, 0.01)
    };
    let tiny = Case::new("constant 1e-42", filled(SIZE, [1e-42; 3]), Measure::Light, 1e-41);
    let board = image(SIZE, |[x, y]| [65504.0 * f32::from((x + y) % 2 == 0); 3]);
    let board = Case::new("checkerboard of 65504", board, Measure::Finite, 0.0);
    [range, dark, board, tiny].into_iter().chain([6e-8, 65504.0, 1e30].map(even)).collect()
}

/// The noisy image with `of_10_000` of 10 000 pixels set to this value, the first in the middle.
fn spoilt(value: f32, of_10_000: u64) -> Image {
    let mut image = noisy();
    let pixels = image.pixels_mut();
    let mut random = Random::new(3);
    let count = (pixels.len() as u64 * of_10_000).div_ceil(10_000).max(1);
    let mut at = 40 * 128 + 60;
    for _ in 0..if of_10_000 == 1 { 1 } else { count } {
        pixels[at] = [value; 3];
        at = ((0.5 * random.value() + 0.5) * pixels.len() as f32) as usize;
    }
    image
}

fn number(value: f32) -> String {
    if (1e-3..1e3).contains(&value.abs()) || value == 0.0 {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

fn filled([width, height]: [u32; 2], pixel: [f32; 3]) -> Image {
    Image::filled(width, height, pixel).expect("it has pixels")
}

fn image([width, height]: [u32; 2], mut pixel: impl FnMut([u32; 2]) -> [f32; 3]) -> Image {
    let pixels = (0..width * height).map(|i| pixel([i % width, i / width])).collect();
    Image::new(width, height, pixels).expect("the count is right")
}

impl std::fmt::Debug for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name)
    }
}
