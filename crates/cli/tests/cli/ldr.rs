use image::{DynamicImage, Rgb, Rgba};

use crate::support::{Folder, read_exr, take};

fn noise(x: u32, y: u32, c: u32) -> u32 {
    (x * 7919 + y * 104_729 + c * 1_299_709).wrapping_mul(2_654_435_761) >> 16
}

/// 16 bits, with a different alpha in every pixel.
fn rgba16() -> DynamicImage {
    let pixel = |x, y| Rgba([0, 1, 2, 3].map(|c| noise(x, y, c) as u16));
    DynamicImage::from(image::ImageBuffer::from_fn(33, 21, pixel))
}

fn rgb8() -> DynamicImage {
    let pixel = |x, y| Rgb([0, 1, 2].map(|c| noise(x, y, c) as u8));
    DynamicImage::from(image::RgbImage::from_fn(33, 21, pixel))
}

#[test]
fn a_png_keeps_its_depth_and_its_alpha() {
    let folder = Folder::new();
    for original in [rgba16(), rgb8(), rgba16().to_luma_alpha8().into(), rgb8().to_luma16().into()]
    {
        original.save(folder.path("in.png")).unwrap();
        folder.denoise(&["in.png", "out.png", "--force"]).assert_done();
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
    let run = folder.denoise(&["plain_rgb.exr", "out.png"]);
    run.assert_done();
    assert!(run.stderr.contains("clipped to [0, 1], sRGB-encoded, in 8 bits"), "{run:?}");
    let written = image::open(folder.path("out.png")).unwrap();
    assert_eq!((written.width(), written.height()), (37, 23));

    folder.denoise(&["out.png", "back.exr"]).assert_done();
    let back = read_exr(&folder.path("back.exr"));
    let names: Vec<_> =
        back.layer_data[0].channel_data.list.iter().map(|c| c.name.to_string()).collect();
    assert_eq!((names, back.layer_data[0].size.0), (vec!["B".into(), "G".into(), "R".into()], 37));
}

#[test]
fn an_exr_made_of_a_png_has_its_alpha_as_float() {
    let folder = Folder::new();
    rgba16().save(folder.path("in.png")).unwrap();
    let run = folder.denoise(&["in.png", "out.exr"]);
    run.assert_done();
    assert!(run.stderr.contains("linear R, G, B, and alpha as it is"), "{run:?}");
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
}
