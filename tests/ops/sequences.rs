//! Properties of the mean of frames over a whole sequence.

use proptest::prelude::*;

use crate::film::{Formats, Frame, Sequence};
use wgdenoise_testing::Random;
use wgdenoise_testing::image::Pixel;

/// Where the denoised frame is broken, the next one stands alone; pixels around it read what is
/// left.
#[test]
fn a_broken_result_does_not_spread() {
    let size = [9, 9];
    for (right, broken_share) in [(0.0, 1.0), (0.5, 0.5)] {
        let mut sequence = Sequence::new(size, Formats::light_alone(9), 1.0);
        let mut first = constant(size, 1.0);
        first.denoised[40][1] = f32::NAN;
        let mut second = constant(size, 1.04);
        second.motion.fill([right, 0.0, 0.0, 0.0]);
        sequence.next(&first);
        let found = sequence.next(&second);
        let agreement = (-(0.04_f32 / (1.02 + 0.005 * 0.18) / 0.3).powi(2)).exp();
        let mean = |frames: f32| (1.04 + frames) / (1.0 + frames);
        let expected = [mean(agreement), mean(agreement * (1.0 - broken_share))];
        for (i, expected) in [(42, expected[0]), (40, expected[1]), (31, expected[0])] {
            let off = (found[i][1] - expected).abs();
            assert!(off < 1e-5, "{right}, pixel {i}: {} is not {expected}", found[i][1]);
        }
    }
}

/// Next to a broken pixel, light is the mean of what is left, neither darker nor sharpened.
#[test]
fn what_is_left_beside_a_broken_pixel_is_averaged() {
    let size = [9, 9];
    let mut sequence = Sequence::new(size, Formats::light_alone(9), 1.0);
    let mut first = constant(size, 1.0);
    first.denoised[40][0] = f32::NAN;
    first.denoised[49] = [1.02; 4];
    first.denoised[50] = [1.04; 4];
    let mut second = constant(size, 1.04);
    second.motion.fill([0.5, 0.5, 0.0, 0.0]);
    sequence.next(&first);
    let found = sequence.next(&second)[40][1];
    // The history is 1.02 and counts as three quarters of a frame, nearly all of which agrees.
    let expected = (1.04 + 0.75 * 0.97 * 1.02) / (1.0 + 0.75 * 0.97);
    assert!((found - expected).abs() < 1e-3, "{found} is not {expected}");
}

pub(crate) fn constant(size: [u32; 2], light: f32) -> Frame {
    let pixels = |v: f32| vec![[v; 4]; (size[0] * size[1]) as usize];
    Frame {
        denoised: pixels(light),
        motion: pixels(0.0),
        albedo: pixels(0.5),
        normal: pixels(0.5),
        depth: pixels(3.0),
        layers: Vec::new(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn constant_light_stays_bit_for_bit(
        color in prop::array::uniform3(1e-20_f32..1e20),
        motion in prop::array::uniform2(-3.0_f32..3.0),
    ) {
        let size = [12, 9];
        let mut frame = constant(size, 0.0);
        let scale = 0.18 / color.iter().sum::<f32>();
        frame.denoised.fill([color[0], color[1], color[2], 1.0]);
        frame.motion.fill([motion[0], motion[1], 0.0, 0.0]);
        let mut sequence = Sequence::new(size, Formats::all(12), scale);
        for _ in 0..4 {
            let found = sequence.next(&frame);
            prop_assert!(found.iter().all(|pixel| pixel[..3] == color), "{found:?}");
        }
    }
}

/// The results of frames from light alone, in 32-bit floats.
fn results(frames: &[Frame], size: [u32; 2]) -> Vec<Vec<Pixel>> {
    let mut sequence = Sequence::new(size, Formats::light_alone(size[0]), 1.0);
    frames.iter().map(|frame| sequence.next(frame)).collect()
}

fn rms(found: &[Pixel], expected: impl Fn(usize) -> f32) -> f32 {
    let squares = found.iter().enumerate().flat_map(|(i, pixel)| {
        let expected = expected(i);
        pixel[..3].iter().map(move |v| (v - expected).powi(2)).collect::<Vec<_>>()
    });
    (squares.sum::<f32>() / (3 * found.len()) as f32).sqrt()
}

/// Noise of about 3 % RMS of the light, independent in each frame.
fn noise(random: &mut Random, light: f32) -> Pixel {
    [0; 4].map(|_| light * (1.0 + 0.05 * random.value()))
}

#[test]
fn noise_falls_as_that_of_a_mean() {
    let size = [64, 64];
    let mut random = Random::new(17);
    let frames = (0..16).map(|_| {
        let denoised = (0..64 * 64).map(|_| noise(&mut random, 1.0)).collect();
        Frame { denoised, ..constant(size, 1.0) }
    });
    let found = results(&frames.collect::<Vec<_>>(), size);
    let first = rms(&found[0], |_| 1.0);
    let mut variance = 1.0_f32;
    for (i, result) in found.iter().enumerate() {
        // A frame's share is at least a ninth, because at most eight earlier ones count.
        let share = 1.0 / (i.min(8) + 1) as f32;
        variance = variance * (1.0 - share).powi(2) + share.powi(2);
        let ratio = rms(result, |_| 1.0) / first / variance.sqrt();
        // 12288 values have a spread of 0.6 %; noise mistaken for change costs a little.
        assert!((0.97..1.05).contains(&ratio), "frame {i}: {ratio} of the expected noise");
    }
}

/// A pattern of waves eight pixels long moves, and noise is averaged along its motion.
#[test]
fn a_moving_pattern_is_followed() {
    let size = [48, 32];
    let wave = |x: f32, y: f32| 1.0 + 0.4 * (0.8 * x).sin() * (0.5 * y).cos();
    for (right, down) in [(1.0, -2.0), (0.5, 0.25), (-1.75, 1.0)] {
        // The light at pixel `i` of the frame `k` frames before the last.
        let at = |k: usize, i: usize| {
            let [x, y, k] = [i % 48, i / 48, k].map(|v| v as f32);
            wave(x - k * right, y - k * down)
        };
        let mut random = Random::new(5);
        let mut frame = |k: usize| {
            let denoised = (0..48 * 32).map(|i| noise(&mut random, at(k, i))).collect();
            let motion = vec![[right, down, 0.0, 0.0]; 48 * 32];
            Frame { denoised, motion, ..constant(size, 1.0) }
        };
        let frames: Vec<_> = (0..7).map(|k| frame(6 - k)).collect();
        let found = &results(&frames, size)[6];
        let is_inner = |i: &usize| (16..32).contains(&(i % 48)) && (12..20).contains(&(i / 48));
        let inner: Vec<_> = (0..48 * 32).filter(is_inner).collect();
        let off = |pixels: &[Pixel]| {
            let kept: Vec<_> = inner.iter().map(|&i| pixels[i]).collect();
            rms(&kept, |i| at(0, inner[i]))
        };
        let ratio = off(found) / off(&frames[6].denoised);
        assert!(ratio < 0.6, "{right} {down}: {ratio} of the noise is left");
    }
}

#[test]
fn light_that_is_switched_is_followed_within_two_frames() {
    for (before, after) in [(1.0, 0.5), (1.0, 2.0), (0.02, 0.01)] {
        let size = [8, 8];
        let mut frames = vec![constant(size, before); 12];
        frames.extend(vec![constant(size, after); 2]);
        let found = results(&frames, size);
        let off = |frame: usize| rms(&found[frame], |_| after) / after;
        assert!(off(13) < 0.05, "{before} to {after}: off by {}, then {}", off(12), off(13));
        assert!(rms(&found[11], |_| before) < 1e-6 * before);
    }
}
