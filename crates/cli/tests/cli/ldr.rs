use image::{DynamicImage, Rgb, Rgba};

use crate::support::{Folder, read_exr, take};

fn noise(x: u32, y: u32, c: u32) -> u32 {
    (x * 7919 + y * 104_729 + c * 1_299_709).wrapping_mul(2_654_435_761) >> 16
}

/// A 16-bit image with a different alpha in every pixel.
fn rgba16() -> DynamicImage {
    let pixel = |x, y| Rgba([0, 1, 2, 3].map(|c| noise(x, y, c) as u16));
    DynamicImage::from(image::ImageBuffer::from_fn(33, 21, pixel))
}

fn rgb8() -> DynamicImage {
    let pixel = |x, y| Rgb([0, 1, 2].map(|c| noise(x, y, c) as u8));
    DynamicImage::from(image::RgbImage::from_fn(33, 21, pixel))
}

#[test]
fn a_png_keeps_its_depth_and_on_request_its_alpha() {
    let folder = Folder::new();
    for original in [rgba16(), rgb8(), rgba16().to_luma_alpha8().into(), rgb8().to_luma16().into()]
    {
        original.save(folder.path("in.png")).unwrap();
        folder.denoise(&["in.png", "out.png", "--force", "--alpha", "keep"]).assert_done();
        let written = image::open(folder.path("out.png")).unwrap();
        assert_eq!(written.color(), original.color());
        let alpha = |i: &DynamicImage| i.to_rgba16().pixels().map(|p| p.0[3]).collect::<Vec<_>>();
        assert!(alpha(&written) == alpha(&original), "{:?}", original.color());
        assert!(written.as_bytes() != original.as_bytes(), "{:?}", original.color());
    }
}

#[test]
fn jpeg_goes_in_and_out() {
    let folder = Folder::new();
    rgb8().save(folder.path("in.jpg")).unwrap();
    folder.denoise(&["in.jpg", "out.jpeg"]).assert_done();
    let written = image::open(folder.path("out.jpeg")).unwrap();
    assert_eq!((written.width(), written.height()), (33, 21));
    rgba16().save(folder.path("in.png")).unwrap();
    let run = folder.denoise(&["in.png", "out.jpg"]);
    run.assert_done();
    assert!(run.stderr.contains("JPEG has no alpha"), "{run:?}");
}

#[test]
fn an_exr_can_be_written_as_png_to_look_at_and_a_png_as_exr() {
    let folder = Folder::new();
    folder.copy("plain_rgb.exr");
    // The 37×23 pixels lie inside a display window of 64×48.
    let run = folder.denoise(&["plain_rgb.exr", "out.png"]);
    run.assert_done();
    assert!(run.stderr.contains("clipped to [0, 1], sRGB-encoded, in 8 bits"), "{run:?}");
    let written = image::open(folder.path("out.png")).unwrap();
    assert_eq!((written.width(), written.height()), (64, 48));

    folder.denoise(&["out.png", "back.exr"]).assert_done();
    let back = read_exr(&folder.path("back.exr"));
    let names: Vec<_> =
        back.layer_data[0].channel_data.list.iter().map(|c| c.name.to_string()).collect();
    assert_eq!((names, back.layer_data[0].size.0), (vec!["B".into(), "G".into(), "R".into()], 64));
}

#[test]
fn an_exr_made_of_a_png_has_its_alpha_as_float() {
    let folder = Folder::new();
    rgba16().save(folder.path("in.png")).unwrap();
    let run = folder.denoise(&["in.png", "out.exr", "--alpha", "keep"]);
    run.assert_done();
    assert!(run.stderr.contains("linear R, G, B, premultiplied by alpha,"), "{run:?}");
    let alpha = take(&mut read_exr(&folder.path("out.exr")), 0, "A");
    let expected: Vec<f32> = rgba16().to_rgba32f().pixels().map(|p| p.0[3]).collect();
    assert_eq!(alpha.values_as_f32().collect::<Vec<_>>(), expected);
}

#[test]
fn a_png_has_no_layers_and_says_so() {
    let folder = Folder::new();
    rgb8().save(folder.path("in.png")).unwrap();
    folder
        .denoise(&["in.png", "out.png", "--color", "beauty"])
        .assert_failed(1, &["in.png: has no layers"]);
    let info = folder.run(&["info", "in.png"]);
    assert!(info.stdout.contains("PNG, 8-bit RGB, 33×21 pixels"), "{info:?}");
    assert!(!info.stdout.contains("alpha"), "{info:?}");
    disc().save(folder.path("disc.png")).unwrap();
    let named = folder.run(&["info", "in.png", "--color", "X"]);
    named.assert_failed(1, &["has no layers, so no layer `X`"]);
    let info = folder.run(&["info", "disc.png"]);
    assert!(info.stdout.contains("alpha from the pixels"), "{info:?}");
}

/// A disc with noisy edges, in which no two pixels share a color.
fn disc() -> image::RgbaImage {
    image::RgbaImage::from_fn(48, 48, |x, y| {
        let distance = (x as f32 - 23.5).hypot(y as f32 - 23.5);
        let edge = (128.0 + 60.0 * (15.0 - distance)).clamp(0.0, 255.0);
        let shaken = edge + (noise(x, y, 3) % 100) as f32 - 50.0;
        let is_edge = edge > 0.0 && edge < 255.0;
        let alpha = if is_edge { shaken.clamp(1.0, 254.0) } else { edge };
        let [r, g, b] = [0, 1, 2].map(|c| 100 + (noise(x, y, c) % 80) as u8);
        Rgba([r, g, b, alpha as u8])
    })
}

#[test]
fn fractional_alpha_of_a_png_is_denoised_and_settled_alpha_stays() {
    let folder = Folder::new();
    let before = disc();
    before.save(folder.path("in.png")).unwrap();
    let run = folder.run(&["in.png", "out.png", "--quality", "fast"]);
    run.assert_done();
    assert!(run.stderr.contains("alpha is denoised by the color's weights"), "{run:?}");
    let after = image::open(folder.path("out.png")).unwrap().to_rgba8();
    let distance = |x: u32, y: u32| (x as f32 - 23.5).hypot(y as f32 - 23.5);
    let mut error = [0.0; 2];
    for ((x, y, old), new) in before.enumerate_pixels().zip(after.pixels()) {
        let truth = (128.0 + 60.0 * (15.0 - distance(x, y))).clamp(0.0, 255.0);
        for (error, pixel) in error.iter_mut().zip([old, new]) {
            *error += (f32::from(pixel.0[3]) - truth).abs();
        }
        match distance(x, y) {
            ..8.0 => assert!(new.0[3] == 255, "{x} {y}"),
            22.0.. => assert!(new == old, "hidden as it was: {x} {y}"),
            _ if new.0[3] > 20 => assert!(new.0[..3].iter().all(|&v| v > 90), "{x} {y} {new:?}"),
            _ => {}
        }
    }
    assert!(error[1] < 0.8 * error[0], "{error:?}");
}

#[test]
fn alpha_goes_from_png_to_exr_and_back() {
    let folder = Folder::new();
    disc().save(folder.path("in.png")).unwrap();
    folder.denoise(&["in.png", "a.exr", "--alpha", "keep"]).assert_done();
    let run = folder.denoise(&["a.exr", "back.png", "--alpha", "keep"]);
    run.assert_done();
    assert!(run.stderr.contains("only the color, divided by its alpha"), "{run:?}");
    let back = image::open(folder.path("back.png")).unwrap().to_rgba8();
    for (old, new) in disc().pixels().zip(back.pixels()) {
        assert_eq!(old.0[3], new.0[3]);
        // Only the disc's own colors: color that is not divided by its alpha would give dark rims.
        assert!(new.0[3] < 60 || new.0[..3].iter().all(|&v| v > 80), "{old:?} {new:?}");
    }
}

#[test]
fn alpha_that_cannot_be_denoised_is_told_when_asked_for() {
    let folder = Folder::new();
    rgb8().save(folder.path("in.png")).unwrap();
    disc().save(folder.path("disc.png")).unwrap();
    for (input, output, words) in [
        ("in.png", "out.png", "found no alpha to denoise"),
        ("disc.png", "out.jpg", "JPEG has no alpha to denoise"),
    ] {
        let run = folder.denoise(&[input, output, "--alpha", "denoise"]);
        run.assert_done();
        assert!(run.stderr.contains(words), "{run:?}");
    }
}

/// Color hidden under an alpha of 0 must not affect visible pixels.
#[test]
fn hidden_color_does_not_bleed_into_edges() {
    let folder = Folder::new();
    let covered = |x: u32| (x * 12).saturating_sub(120).min(255) as u8;
    let denoised = |hidden: [u8; 3]| {
        let pixel = |x, y| {
            let [r, g, b] = [0, 1, 2].map(|c| noise(x, y, c) as u8);
            let [r, g, b] = if covered(x) == 0 { hidden } else { [r, g, b] };
            Rgba([r, g, b, covered(x)])
        };
        image::RgbaImage::from_fn(33, 21, pixel).save(folder.path("in.png")).unwrap();
        folder.denoise(&["in.png", "out.png", "--force"]).assert_done();
        image::open(folder.path("out.png")).unwrap().to_rgba8()
    };
    let [black, red] = [[0; 3], [255, 0, 0]].map(denoised);
    for (black, red) in black.pixels().zip(red.pixels()) {
        if black.0[3] == 0 {
            assert_eq!((black.0, red.0), ([0; 4], [255, 0, 0, 0]), "as they were");
        } else {
            assert_eq!(black, red);
        }
    }
}

/// Images rotated by EXIF are used as a viewer shows them, as input and as albedo.
#[test]
fn a_turned_jpeg_becomes_an_upright_exr_and_a_fitting_albedo() {
    let folder = Folder::new();
    let exif = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
    let file = std::fs::File::create(folder.path("turned.jpg")).unwrap();
    let mut encoder = image::codecs::jpeg::JpegEncoder::new(file);
    image::ImageEncoder::set_exif_metadata(&mut encoder, exif.to_vec()).unwrap();
    rgb8().write_with_encoder(encoder).unwrap();
    folder.denoise(&["turned.jpg", "upright.exr"]).assert_done();
    assert_eq!(read_exr(&folder.path("upright.exr")).layer_data[0].size, exr::math::Vec2(21, 33));
    folder.denoise(&["upright.exr", "out.exr", "--albedo", "turned.jpg"]).assert_done();
    let info = folder.run(&["info", "turned.jpg"]);
    assert!(info.stdout.contains("JPEG, 8-bit RGB, 21×33 pixels"), "{info:?}");
}
