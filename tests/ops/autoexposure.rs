use wgdenoise::internals::ops::autoexposure::{Band, autoexposure};
use wgdenoise::internals::ops::tile::Layout;
use wgdenoise::internals::reference;
use wgdenoise::{Image, Precision};

use wgdenoise_testing::gpu::{buffer, context, read_back, submit};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// Sums of up to 256 values in f32 (1e-5) under a logarithm, whose mean is an exponent.
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
    // An outlier in a bin of its own, among noise.
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

fn image(width: u32, height: u32, value: impl Fn(f32) -> f32) -> Image {
    let mut random = Random::new(u64::from(width * height));
    let pixels = (0..width * height).map(|_| [0; 3].map(|_| value(random.value()))).collect();
    Image::new(width, height, pixels).expect("the count is right")
}

fn compare_scale(found: f32, expected: f32) -> Result<(), String> {
    let scalar = |v| reference::Tensor::new(1, 1, 1, vec![v]);
    compare(&scalar(found), &scalar(expected), TOLERANCE)
}

/// The scale, computed from bands one after another.
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
