use std::io::Cursor;

use ::exr::math::Vec2;
use ::exr::meta::attribute::IntegerBounds;
use ::exr::prelude::SmallVec;
use image::{DynamicImage, ImageFormat};

use super::*;

const AP1: Chromaticities = Chromaticities {
    red: Vec2(0.713, 0.293),
    green: Vec2(0.165, 0.83),
    blue: Vec2(0.128, 0.044),
    white: Vec2(0.32168, 0.33767),
};

/// A header of 4×3 pixels at `corner`, with this display window.
fn header(corner: (i32, i32), display: IntegerBounds) -> Header {
    let mut header = Header::new("C".into(), (4, 3), SmallVec::new());
    header.own_attributes.layer_position = corner.into();
    header.shared_attributes.display_window = display;
    header
}

/// Linear light that numbers the pixels, row by row, over 16.
fn numbered() -> Image {
    Image::new(4, 3, (0..12).map(|i| [(i + 1) as f32 / 16.0; 3]).collect()).unwrap()
}

fn shown(
    header: &Header,
    color: &Image,
    alpha: Option<&[f32]>,
    format: Format,
) -> (DynamicImage, Vec<String>) {
    let display = Display::of(header);
    let (shown, notices) = display.show(color, alpha, Limits::default()).unwrap();
    let mut out = Cursor::new(Vec::new());
    let first = shown.write(&mut out, format).unwrap();
    let kind = if format == Format::Png { ImageFormat::Png } else { ImageFormat::Jpeg };
    let image = image::load_from_memory_with_format(out.get_ref(), kind).unwrap();
    (image, [first, notices].concat())
}

fn srgb(light: f32) -> u8 {
    let v = f64::from(light);
    let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

#[test]
fn the_display_window_is_what_a_png_shows() {
    // Two columns and one row are shown, and a column beyond the pixels.
    let header = header((-2, 5), IntegerBounds::new((0, 6), (3, 1)));
    let (image, notices) = shown(&header, &numbered(), None, Format::Png);
    let pixels: Vec<_> = image.to_rgb8().pixels().map(|p| p.0[0]).collect();
    assert_eq!(pixels, [srgb(7.0 / 16.0), srgb(8.0 / 16.0), 0]);
    assert_eq!(image.color(), ColorType::Rgb8);
    let said = "cropped and padded to the display window, 3×1 pixels from (0, 6); the pixels are \
                4×3 pixels from (-2, 5)";
    assert_eq!(notices[1], said);
    // With alpha, what is not covered is transparent.
    let (image, _) = shown(&header, &numbered(), Some(&[1.0; 12]), Format::Png);
    let alpha: Vec<_> = image.to_rgba8().pixels().map(|p| p.0[3]).collect();
    assert_eq!((image.color(), alpha), (ColorType::Rgba8, vec![255, 255, 0]));
}

#[test]
fn alpha_is_written_straight_to_png_and_over_black_to_jpeg() {
    let header = header((0, 0), IntegerBounds::new((0, 0), (4, 3)));
    let alpha: Vec<_> = (0..12).map(|i| i as f32 / 11.0).collect();
    let color = Image::new(4, 3, alpha.iter().map(|a| [0.5 * a, 0.25 * a, 0.0]).collect()).unwrap();
    let (image, notices) = shown(&header, &color, Some(&alpha), Format::Png);
    for (pixel, alpha) in image.to_rgba8().pixels().zip(&alpha) {
        let levels = (alpha * 255.0).round();
        // What is written is divided by the alpha that is written.
        let straight =
            |light: f32| if levels > 0.0 { srgb(light * alpha * 255.0 / levels) } else { 0 };
        assert_eq!(pixel.0, [straight(0.5), straight(0.25), 0, levels as u8]);
    }
    assert!(notices[0].contains("divided by its alpha"), "{notices:?}");
    let (image, notices) = shown(&header, &color, Some(&alpha), Format::Jpeg);
    assert!(image.to_rgb8()[(0, 0)].0[0] < 20 && notices[0].contains("over black"), "{notices:?}");
    // Alpha of 1 everywhere is no reason for a fourth channel.
    let (image, _) = shown(&header, &color, Some(&[1.0; 12]), Format::Png);
    assert_eq!(image.color(), ColorType::Rgb8);
}

#[test]
fn alpha_that_would_hide_a_picture_is_left_out_and_hidden_glows_are_counted() {
    let header = header((0, 0), IntegerBounds::new((0, 0), (4, 3)));
    let light = Image::filled(4, 3, [0.0, 0.5, 0.0]).unwrap();
    let (image, notices) = shown(&header, &light, Some(&[0.0; 12]), Format::Png);
    assert_eq!(image.to_rgba8()[(3, 2)].0, [0, srgb(0.5), 0, 255]);
    assert_eq!(notices[1], "alpha is 0 everywhere and was left out");
    // An empty frame of an animation stays transparent.
    let empty = Image::filled(4, 3, [0.0; 3]).unwrap();
    let (image, notices) = shown(&header, &empty, Some(&[0.0; 12]), Format::Png);
    assert_eq!((image.to_rgba8()[(3, 2)].0, notices.len()), ([0; 4], 1));

    let mut alpha = [1.0; 12];
    alpha[..3].copy_from_slice(&[0.0, 1e-9, f32::NAN]);
    let (_, notices) = shown(&header, &light, Some(&alpha), Format::Png);
    assert!(notices[1].ends_with("cannot be shown by PNG: 2"), "{notices:?}");
    let (_, notices) = shown(&header, &light, Some(&alpha), Format::Jpeg);
    assert_eq!(notices.len(), 1, "over black, all light shows: {notices:?}");
}

#[test]
fn primaries_become_those_of_srgb() {
    let mut header = header((0, 0), IntegerBounds::new((0, 0), (4, 3)));
    header.shared_attributes.chromaticities = Some(AP1);
    // sRGB's (0.4, 0.1, 0.05) in ACEScg, by the inverse of the matrix that ACES publishes.
    let color = Image::filled(4, 3, [0.281_561, 0.120_387, 0.062_694]).unwrap();
    let (image, notices) = shown(&header, &color, None, Format::Png);
    let found = image.to_rgb8()[(2, 1)].0;
    for (found, expected) in found.iter().zip([0.4, 0.1, 0.05].map(srgb)) {
        assert!(found.abs_diff(expected) <= 1, "{found} {expected}");
    }
    assert_eq!(notices[1], "converted from the file's primaries to those of sRGB");
    // Values that are not color stay.
    let data = Display::of(&header).of_data();
    assert!(data.show(&color, None, Limits::default()).unwrap().1.is_empty());
    header.shared_attributes.chromaticities = Some(Chromaticities { white: Vec2(0.3, 0.0), ..AP1 });
    let (image, notices) = shown(&header, &color, None, Format::Png);
    assert_eq!(image.to_rgb8()[(0, 0)].0[0], srgb(0.281_561));
    assert!(notices[1].contains("make no color space"), "{notices:?}");
}

#[test]
fn the_shape_of_pixels_is_written_or_told() {
    let mut header = header((0, 0), IntegerBounds::new((0, 0), (4, 3)));
    for (aspect, words) in [
        (2.0, "pixels are 2 times as wide as high, which is written"),
        (0.0, "ratio of 0 cannot be written"),
        (f32::NAN, "ratio of NaN cannot be written"),
        (1e9, "ratio of 1000000000 cannot be written"),
    ] {
        header.shared_attributes.pixel_aspect = aspect;
        for format in [Format::Png, Format::Jpeg] {
            let (_, notices) = shown(&header, &numbered(), None, format);
            assert!(notices[1].contains(words), "{notices:?}");
        }
    }
}

#[test]
fn a_display_window_beyond_the_limits_is_refused() {
    let header = header((0, 0), IntegerBounds::new((0, 0), (1 << 29, 1 << 29)));
    let error = Display::of(&header).show(&numbered(), None, Limits::default()).unwrap_err();
    assert!(error.to_string().contains("claims 536870912×536870912 pixels"), "{error}");
}
