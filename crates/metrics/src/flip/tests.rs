use super::*;

fn flat(rgb: [f32; 3]) -> Image {
    Image::filled(24, 20, rgb).expect("a valid image")
}

fn found(image: &Image, reference: &Image) -> Flip {
    flip(image, reference, PIXELS_PER_DEGREE).expect("one size")
}

/// A ramp within the display range plus noise from a fixed sequence.
fn noisy(amount: f32) -> Image {
    let mut state = 7_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    let pixel = |i: usize| [0.3 + (i % 24) as f32 / 60.0, 0.4, 0.6 - (i / 24) as f32 / 60.0];
    let pixels = (0..24 * 20).map(|i| pixel(i).map(|v| v + amount * next())).collect();
    Image::new(24, 20, pixels).expect("a valid image")
}

#[test]
fn equal_images_have_no_error() {
    for image in [flat([0.3, 0.9, 0.1]), noisy(0.5)] {
        let Flip { errors, mean } = found(&image, &image);
        assert!(mean == 0.0 && errors.iter().all(|&error| error == 0.0));
        assert_eq!(errors.len(), 24 * 20);
    }
}

#[test]
fn more_noise_is_more_error_and_none_leaves_the_bounds() {
    let clean = noisy(0.0);
    let means = [0.05, 0.1, 0.2, 0.4, 0.8].map(|amount| {
        let Flip { errors, mean } = found(&noisy(amount), &clean);
        assert!(errors.iter().all(|error| (0.0..=1.0).contains(error)));
        mean
    });
    assert!(means.is_sorted() && means[0] > 0.0, "{means:?}");
    let swapped = found(&clean, &noisy(0.4)).mean;
    assert!((swapped - means[3]).abs() < 1e-12, "the order does not matter");
}

/// Even images have no features, and blurring does not change them. White and black differ by 100
/// in lightness alone. Green and blue are the largest difference, by definition 1.
#[test]
fn even_images_differ_by_their_color_alone() {
    let [white, black] = [flat([1.0; 3]), flat([0.0; 3])];
    // Lab of green and of blue, rounded, with the chroma times 0.01 L.
    let (green, blue) = ([87.735, -75.611, 72.978], [32.297, 25.576, -34.836]);
    let most = hyab(green, blue).powf(0.7);
    let (difference, knee) = (100.0_f64.powf(0.7), 0.4 * most);
    let expected = 0.95 + 0.05 * (difference - knee) / (most - knee);
    let error = found(&white, &black).mean;
    assert!((error - expected).abs() < 1e-4, "found {error}, not {expected}");
    let error = found(&flat([0.0, 1.0, 0.0]), &flat([0.0, 0.0, 1.0])).mean;
    assert!((error - 1.0).abs() < 1e-9, "{error}");
}

/// Grays of L* 50 and 51: c = 0.95 / (0.4 · most) · 1^0.7. Filters have 32 bits, so even pictures
/// have features of up to 1e-7, and their square root in the exponent moves c by −c · ln c · 3e-4 =
/// 5e-5.
#[test]
fn a_small_difference_of_lightness_is_on_the_steep_line() {
    let gray = |lightness: f64| {
        let light = ((lightness + 16.0) / 116.0).powi(3);
        flat([(1.055 * light.powf(1.0 / 2.4) - 0.055) as f32; 3])
    };
    let error = found(&gray(50.0), &gray(51.0)).mean;
    let expected = 0.95 / (0.4 * most());
    assert!((error - expected).abs() < 5e-5, "found {error}, not {expected}");
}

#[test]
fn an_edge_weighs_more_than_the_same_colors_without_one() {
    let step = |low: f32, high: f32| {
        let pixel = |i: usize| [if i % 24 < 12 { low } else { high }; 3];
        Image::new(24, 20, (0..24 * 20).map(pixel).collect()).expect("a valid image")
    };
    let error = found(&step(0.4, 0.6), &step(0.5, 0.5));
    let (at_edge, far) = (error.errors[10 * 24 + 10], error.errors[10 * 24]);
    assert!(at_edge > far, "{at_edge} and {far}");
}

#[test]
fn what_is_no_color_is_clipped() {
    let odd = flat([f32::NAN, f32::INFINITY, -3.0]);
    assert_eq!(found(&odd, &flat([0.0, 1.0, 0.0])).mean, 0.0);
}

#[test]
fn images_of_two_sizes_are_refused() {
    let small = Image::filled(3, 2, [1.0; 3]).expect("a valid image");
    let error = flip(&flat([1.0; 3]), &small, PIXELS_PER_DEGREE).expect_err("two sizes");
    assert!(error.to_string().contains("24×20") && error.to_string().contains("3×2"), "{error}");
}

/// Three ramps, and a pattern on them that is clipped at the ends.
fn patterned(amount: i32) -> Image {
    let value = |x: i32, y: i32, c: i32| {
        let ramp = [x as f32 / 23.0, y as f32 / 19.0, (x + y) as f32 / 42.0][c as usize];
        let step = (x * 37 + y * 101 + c * 53) % 7 - 3;
        (ramp + (amount * step) as f32 * 0.04).clamp(0.0, 1.0)
    };
    let pixel = |i: i32| [0, 1, 2].map(|c| value(i % 24, i / 24, c));
    Image::new(24, 20, (0..24 * 20).map(pixel).collect()).expect("a valid image")
}

/// Computed with the authors' package `flip-evaluator` 1.7 (LDR, 67 pixels per degree) in 32 bits,
/// where sums of hundreds of values and their fractional powers keep four digits.
#[test]
fn errors_agree_with_the_reference_implementation() {
    let Flip { errors, mean } = found(&patterned(1), &patterned(0));
    assert!((mean - 0.108_889_557).abs() < 1e-4, "{mean}");
    for (x, y, expected) in
        [(0, 0, 0.123_692_7), (12, 10, 0.048_699_68), (23, 19, 0.242_444), (5, 17, 0.163_901)]
    {
        let error = errors[y * 24 + x];
        assert!((error - expected).abs() < 1e-4, "{error}, not {expected} at {x}, {y}");
    }
}

/// Threads compute bands of rows, which depend on the rows around them.
#[test]
fn a_band_of_rows_has_the_errors_of_the_whole() {
    let (image, reference) = (noisy(0.4), noisy(0.0));
    let errors = |rows| band([&image, &reference], rows, PIXELS_PER_DEGREE);
    let whole = errors(0..20);
    assert_eq!(whole.len(), 24 * 20);
    for rows in [0..1, 3..5, 13..20] {
        assert_eq!(errors(rows.clone()), whole[24 * rows.start..24 * rows.end], "{rows:?}");
    }
}
