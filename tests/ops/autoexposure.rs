use wgdenoise::internals::ops::autoexposure::{Band, autoexposure};
use wgdenoise::internals::ops::tile::Layout;
use wgdenoise::internals::reference;
use wgdenoise::{Image, Precision};

use wgdenoise_testing::gpu::{buffer, context, read_back, submit};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// Sums of up to 256 values in f32 (1e-5), followed by a logarithm whose mean is an exponent.
const TOLERANCE: Tolerance = Tolerance { absolute: 0.0, relative: 5e-5 };

/// Width, height, exposure.
const CASES: [(u32, u32, f32); 8] = [
    (1, 1, 1.0),
    (16, 16, 1.0),
    (17, 15, 1e-4),
    (33, 100, 1e6),
    (257, 3, 1e-6),
    (5, 300, 30.0),
    (64, 48, 1e-12),
    (40, 40, 1e30),
];

#[test]
fn autoexposure_equals_the_reference_at_any_exposure() {
    run_cases(CASES, |&(width, height, exposure)| {
        let image = image(width, height, |v| v.abs() * exposure);
        let bands = [Band::whole(width, height, Layout::packed(width))];
        compare_scale(run(&image, &bands), reference::autoexposure(&image))
    });
}

#[test]
fn bad_and_lone_pixels_do_not_count_and_black_is_left_alone() {
    let mut image = image(40, 24, |v| v + 0.5);
    image.pixels_mut()[7] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    // An outlier in its own bin, surrounded by noise.
    image.pixels_mut()[45] = [f32::MAX, -1e20, 1e-40];
    // The last bin has a lone lit pixel; the one before it is very dark.
    for y in 12..24 {
        image.pixels_mut()[40 * y + 13..40 * y + 26].fill([1e-9; 3]);
        image.pixels_mut()[40 * y + 26..40 * y + 40].fill([0.0; 3]);
    }
    image.pixels_mut()[40 * 20 + 30] = [1e20; 3];
    let whole = [Band::whole(40, 24, Layout::packed(40))];
    let expected = reference::autoexposure(&image);
    compare_scale(run(&image, &whole), expected).unwrap();
    let lone = self::image(40, 24, |v| v * f32::from(v > 0.99));
    let lit = lone.pixels().iter().filter(|p| p.iter().any(|&v| v > 0.0)).count();
    assert!((2..12).contains(&lit), "{lit}");
    compare_scale(run(&lone, &whole), reference::autoexposure(&lone)).unwrap();
    let black = Image::filled(40, 24, [0.0; 3]).unwrap();
    assert_eq!(run(&black, &whole), 1.0);
}

#[test]
fn bands_of_rows_make_the_same_bits_as_the_whole_image() {
    let image = image(50, 201, f32::abs);
    let whole = run(&image, &[Band::whole(50, 201, Layout::packed(50))]);
    for rows in [16, 17, 40, 100] {
        let bands = Band::split(50, 201, rows);
        assert!(bands.len() > 1 && bands.iter().all(|b| b.rows().len() <= rows as usize));
        assert_eq!(run(&image, &bands).to_bits(), whole.to_bits(), "{rows} rows");
    }
}

/// Bins from 2⁻²⁴ to 2¹⁶: above, within and below the transition, up to 15 360 of them.
#[test]
fn the_bright_bins_are_found_among_many_of_any_level() {
    run_cases([[16_u32, 16], [48, 16], [320, 16], [400, 290], [2048, 1920]], |&[width, height]| {
        let mut random = Random::new(u64::from(width));
        let columns = width.div_ceil(16);
        let levels: Vec<f32> = (0..columns * height.div_ceil(16))
            .map(|_| (20.0 * random.value() - 4.0).exp2())
            .collect();
        let level = |i| levels[(i / width / 16 * columns + i % width / 16) as usize];
        let pixels = (0..width * height).map(|i| [level(i); 3]).collect();
        let image = Image::new(width, height, pixels).expect("the count is right");
        let whole = [Band::whole(width, height, Layout::packed(width))];
        compare_scale(run(&image, &whole), reference::autoexposure(&image))
    });
}

/// The borders are whole bins: a bin that is half scene and half background would be neither.
#[test]
fn a_dark_background_leaves_the_scale_that_the_scene_has_alone() {
    let scenes = [[32, 16], [48, 64], [160, 112]];
    let levels = [0.0, 1e-6, 1e-4];
    let cases = scenes.into_iter().flat_map(|scene| {
        levels.into_iter().flat_map(move |level| {
            [0.3, 0.6, 0.8]
                .into_iter()
                .flat_map(move |share| [false, true].map(|noisy| (scene, level, share, noisy)))
        })
    });
    run_cases(cases, |&([width, height], level, share, noisy)| {
        let scene = image(width, height, |v| 0.1 + v.abs() * 2.0);
        let rows = (f64::from(height) * share / (1.0 - share) / 16.0) as u32 * 16;
        let mut random = Random::new(9);
        let mut dark = || level * if noisy { -2.0 * random.value().abs().ln() } else { 1.0 };
        let mut pixels: Vec<_> = (0..width * rows).map(|_| [0; 3].map(|_| dark())).collect();
        let behind = (width * (rows / 32 * 16)) as usize;
        pixels.splice(behind..behind, scene.pixels().iter().copied());
        let alone = scale_of(&scene);
        compare_scale(scale_of(&Image::new(width, height + rows, pixels).unwrap()), alone)
    });
}

/// The log average over bins moves by the lamps' share of the bins, times their distance from it.
#[test]
fn lamps_move_the_scale_no_further_than_the_log_average_would() {
    let scene = image(160, 160, |v| 0.5 * (6.0 * v).exp2());
    let alone = scale_of(&scene);
    for lamps in [[0, 1], [45, 46], [0, 99]] {
        let mut lit = scene.clone();
        for (i, pixel) in lit.pixels_mut().iter_mut().enumerate() {
            if lamps.contains(&(i / 160 / 16 * 10 + i % 160 / 16)) {
                *pixel = [65504.0; 3];
            }
        }
        let moved = (alone / scale_of(&lit)).log2();
        let most = 0.02 * (65504.0 / 0.18 * alone).log2();
        assert!((0.0..most * 1.05).contains(&moved), "{lamps:?}: {moved} of {most}");
    }
}

/// As 40 of 100 bins fade by 2¹⁶, the mean falls with them at first, then rises again as they lose
/// weight, at up to 0.4 · 6.5 / 0.6 times their rate. A hard limit would make it jump by 0.4 · 11.
#[test]
fn a_part_that_gets_dark_never_makes_the_scale_jump() {
    const STEP: f32 = 1.0 / 16.0;
    let scale = |fade: u32| {
        let mut scene = Image::filled(160, 160, [1.0; 3]).unwrap();
        scene.pixels_mut()[160 * 96..].fill([(-STEP * fade as f32).exp2(); 3]);
        scale_of(&scene).log2()
    };
    let scales: Vec<f32> = (0..=256).map(scale).collect();
    let largest = scales.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
    assert!((STEP..4.4 * STEP).contains(&largest), "{largest}");
    assert_eq!(scales[0], scales[256]);
}

fn scale_of(image: &Image) -> f32 {
    let (width, height) = image.size();
    run(image, &[Band::whole(width, height, Layout::packed(width))])
}

fn image(width: u32, height: u32, value: impl Fn(f32) -> f32) -> Image {
    let mut random = Random::new(u64::from(width * height));
    let pixels = (0..width * height).map(|_| [0; 3].map(|_| value(random.value()))).collect();
    Image::new(width, height, pixels).expect("the count is right")
}

fn compare_scale(found: f32, expected: f32) -> Result<(), String> {
    let scalar = |v| reference::Tensor::new(1, 1, 1, vec![v]);
    compare(&scalar(found), &scalar(expected), TOLERANCE)
}

/// The scale, computed from consecutive bands.
fn run(image: &Image, bands: &[Band]) -> f32 {
    let context = context(Precision::F32);
    let scale = buffer(context, &[0; 4]);
    let width = image.width() as usize;
    let capacity = bands.iter().map(|b| b.rows().len()).max().expect("there is a band");
    let color = buffer(context, &vec![0; capacity * width * 12]);
    let uniform = buffer(context, bytemuck::bytes_of(&bands[0]));
    let calls = autoexposure(context, &bands[0], &uniform, (&color).into(), &scale);
    for band in bands {
        let rows = band.rows().start as usize * width..band.rows().end as usize * width;
        context.queue.write_buffer(&color, 0, bytemuck::cast_slice(&image.pixels()[rows]));
        context.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(band));
        submit(context, |pass| calls.bins.record(pass));
    }
    submit(context, |pass| calls.reduce.record(pass));
    let bytes = read_back(context, 4, |encoder, target| {
        encoder.copy_buffer_to_buffer(&scale, 0, target, 0, 4);
    });
    bytemuck::pod_read_unaligned(&bytes)
}
