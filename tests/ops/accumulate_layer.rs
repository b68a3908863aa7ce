//! Further layers in the mean of frames, compared with the reference and with required properties.

use wgdenoise::internals::ops::tile::Layout;
use wgdenoise::wgpu::TextureFormat as Texture;

use crate::accumulate::{check, frames};
use crate::film::{F16, F32, Formats, Frame, Sequence, sizes_and_features, texture};
use crate::sequences::constant;
use wgdenoise_testing::image::Pixel;
use wgdenoise_testing::{Random, run_cases};

fn layered(seed: u64, size: [u32; 2], [count, layers]: [usize; 2]) -> Vec<Frame> {
    let mut random = Random::new(seed);
    let frames = frames(seed, size, count).into_iter();
    frames.map(|frame| frame.with_layers(&mut random, layers)).collect()
}

#[test]
fn layers_equal_the_reference_in_every_format() {
    let size = [13, 7];
    let all = Formats::all(13);
    let gaps = |format, channels| (format, Layout::new(5, 71, 5).with_channels(channels));
    let motion = [gaps(F32, 2), gaps(F16, 3), texture(Texture::Rg16Float)];
    let layer = [
        gaps(F32, 3),
        gaps(F32, 4),
        gaps(F16, 4),
        texture(Texture::Rgba16Float),
        texture(Texture::Rgba32Float),
    ];
    let cases = layer.map(|layer| Formats { layer, ..all }).into_iter();
    let cases = cases.chain(motion.map(|motion| Formats { motion, ..all }));
    run_cases(cases, |&formats| check(&layered(5, size, [3, 2]), size, formats, 0.5));
}

#[test]
fn layers_equal_the_reference_at_any_size_and_without_any_feature() {
    run_cases(sizes_and_features(), |&(size, set)| {
        let formats = Formats::with_features(size[0], set);
        let layers = 1 + set as usize % 3;
        check(&layered(u64::from(set), size, [4, layers]), size, formats, 1.0)
    });
}

#[test]
fn where_motion_is_no_number_layers_stand_alone() {
    let size = [13, 7];
    let frames: Vec<_> =
        layered(9, size, [3, 2]).into_iter().map(Frame::with_broken_pixels).collect();
    check(&frames, size, Formats::all(13), 1.0).unwrap();
}

/// A wall of waves that moves by fractions of a pixel, seen in `count` frames.
fn waves(size: [u32; 2], count: usize) -> Vec<Frame> {
    let frame = |k: usize| {
        let at = |i: u32| (i % size[0]) as f32 - 0.3 * k as f32;
        let light = |i| 1.0 + 0.2 * (0.9 * at(i)).sin() + 0.1 * (i / size[0]) as f32;
        let denoised = (0..size[0] * size[1]).map(|i| [light(i), 0.5 * light(i), 1.0, 1.0]);
        let motion = vec![[0.3, 0.0, 0.0, 0.0]; (size[0] * size[1]) as usize];
        Frame { denoised: denoised.collect(), motion, ..constant(size, 1.0) }
    };
    (0..count).map(frame).collect()
}

fn results(frames: &[Frame], size: [u32; 2]) -> Vec<Vec<Vec<Pixel>>> {
    let mut sequence = Sequence::new(size, Formats::all(size[0]), 1.0);
    frames.iter().map(|frame| sequence.next_with_layers(frame)).collect()
}

/// Where light is 0 or constant, such as full alpha, sums do nothing but round.
#[test]
fn constant_layers_leave_the_color_alone_and_stay_as_they_are() {
    let size = [24, 9];
    let plain = waves(size, 6);
    let expected = results(&plain, size);
    let constants = [0.0, 1.0, 0.7, -3.3];
    let layers: Vec<_> = constants.iter().map(|&v| vec![[v; 4]; 24 * 9]).collect();
    let frames = plain.into_iter().map(|frame| Frame { layers: layers.clone(), ..frame });
    let found = results(&frames.collect::<Vec<_>>(), size);
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(found[0], expected[0]);
        assert_eq!(found[1..], layers);
    }
}

/// One light ends where the other begins, so the color has no edge there. Splines would exceed the
/// range of both.
#[test]
fn layers_stay_between_what_they_were_beside_edges_that_the_color_lacks() {
    let size = [24, 9];
    let edge = |k: usize, i: usize| f32::from((i % 24) as f32 - 0.3 * k as f32 > 11.5);
    let frames = waves(size, 8).into_iter().enumerate().map(|(k, frame)| {
        let light = |i: usize, v: f32| [0.8 * v, 0.4 * v, v, frame.denoised[i][3]];
        let left = (0..24 * 9).map(|i| light(i, 1.0 - edge(k, i))).collect();
        let right = (0..24 * 9).map(|i| light(i, edge(k, i))).collect();
        let denoised = (0..24 * 9).map(|i| light(i, 1.0)).collect();
        Frame { denoised, layers: vec![left, right], ..frame }
    });
    for found in results(&frames.collect::<Vec<_>>(), size) {
        for layer in &found[1..] {
            let range = layer.iter().map(|pixel| pixel[2]);
            assert!(
                range.clone().all(|v| (0.0..=1.0).contains(&v)),
                "{:?}",
                range.collect::<Vec<_>>()
            );
        }
        sums(&found, 1e-6).unwrap();
    }
}

/// Whether the layers add up to the color within `most` of 1.
fn sums(found: &[Vec<Pixel>], most: f32) -> Result<(), String> {
    let sum = |i: usize, c: usize| found[1..].iter().map(|layer| layer[i][c]).sum::<f32>();
    let off = |i: usize| (0..3).map(move |c| (i, c));
    let off = (0..found[0].len()).flat_map(off).map(|(i, c)| (sum(i, c) - found[0][i][c]).abs());
    let off = off.fold(0.0, f32::max);
    if off <= most { Ok(()) } else { Err(format!("the sum is off by {off}")) }
}

/// Light below 2.8 is read with rounding errors of at most 3e-6 (`ROUNDING` in `spline.wgsl`),
/// mostly less than a tenth of that, which add up over at most nine frames.
#[test]
fn layers_that_add_up_to_the_color_still_do() {
    let size = [33, 21];
    run_cases([1_u64, 2, 3], |&seed| {
        let mut random = Random::new(seed);
        let frames = frames(seed, size, 6).into_iter().map(|frame| {
            let all = frame.denoised.iter();
            let first: Vec<_> =
                all.map(|pixel| pixel.map(|v| 2.0 * v * random.value())).collect::<Vec<Pixel>>();
            let rest = |(all, part): (&Pixel, &Pixel)| [0, 1, 2, 3].map(|c| all[c] - part[c]);
            let second = frame.denoised.iter().zip(&first).map(rest).collect();
            Frame { layers: vec![first, second], ..frame }
        });
        let found = results(&frames.collect::<Vec<_>>(), size);
        found.iter().try_for_each(|found| sums(found, 1e-5))
    });
}

/// A layer's broken pixel starts anew in the next frame; the other layers continue.
#[test]
fn a_layer_that_is_broken_neither_spreads_nor_breaks_the_others() {
    let size = [9, 9];
    let mut frame = constant(size, 1.0);
    frame.layers = vec![vec![[0.25; 4]; 81], vec![[0.75; 4]; 81]];
    let mut first = frame.clone();
    first.layers[0][40][1] = f32::NAN;
    let mut second = frame.clone();
    second.layers[0].fill([0.5; 4]);
    second.layers[1].fill([1.5; 4]);
    let found = results(&[first, second], size).remove(1);
    assert_eq!(found[0], frame.denoised);
    assert_eq!(found[1][40], [0.5; 4]);
    assert_eq!(found[1][41], [0.375, 0.375, 0.375, 0.5]);
    assert_eq!(found[2][40], [1.125, 1.125, 1.125, 1.5]);
}

/// Where the color is broken, the layers keep no history either; next to it, both read what is
/// left.
#[test]
fn layers_have_no_history_where_the_color_has_none() {
    let size = [9, 9];
    let split = |frame: Frame| {
        let share = |v: f32| frame.denoised.iter().map(|pixel| pixel.map(|p| v * p)).collect();
        Frame { layers: vec![share(0.25), share(0.75)], ..frame.clone() }
    };
    let mut first = constant(size, 1.0);
    first.denoised[49] = [1.02; 4];
    let mut first = split(first);
    first.denoised[40][1] = f32::INFINITY;
    first.layers[0][40] = [0.75; 4];
    for right in [0.0, 0.5] {
        let mut second = split(constant(size, 1.04));
        second.motion.fill([right, 0.0, 0.0, 0.0]);
        let found = results(&[first.clone(), second.clone()], size).remove(1);
        assert_eq!(found[1][40] == second.layers[0][40], right == 0.0);
        assert_ne!(found[1][39], second.layers[0][39]);
        sums(&found, 1e-6).unwrap();
    }
}
