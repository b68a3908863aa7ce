use std::io::Cursor;
use std::path::PathBuf;

use ::exr::prelude::{FlatSamples, ReadChannels, ReadLayers, Text};
use image::ImageEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;

use super::encode::convert;
use super::*;

/// A file in a folder that is removed with it.
struct Saved {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

impl Saved {
    fn new(bytes: &[u8]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("in");
        std::fs::write(&path, bytes).unwrap();
        Self { _folder: folder, path }
    }

    fn read(&self) -> (LdrFile, Image) {
        LdrFile::read(&self.path, Limits::default()).unwrap()
    }
}

/// The bytes of `file` written with this color and its own alpha, and the notices.
fn written(file: &LdrFile, color: &Image, format: Format) -> (Vec<u8>, Vec<String>) {
    let mut out = Cursor::new(Vec::new());
    let notices = file.write(&mut out, format, color, None).unwrap();
    (out.into_inner(), notices)
}

fn png(pixels: &DynamicImage) -> Vec<u8> {
    let mut bytes = Vec::new();
    pixels.write_with_encoder(PngEncoder::new(&mut bytes)).unwrap();
    bytes
}

/// A part of an EXR file with R, G, B and perhaps A: its attributes, and its samples by name.
fn exr_parts(bytes: &[u8]) -> (::exr::meta::header::ImageAttributes, Vec<(Text, Vec<f32>)>) {
    let reader = ::exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    let reader = reader.first_valid_layer().all_attributes();
    let image = reader.from_buffered(Cursor::new(bytes)).unwrap();
    let values = |samples: &FlatSamples| samples.values_as_f32().collect();
    let list = image.layer_data.channel_data.list;
    (image.attributes, list.iter().map(|c| (c.name.clone(), values(&c.sample_data))).collect())
}

const KINDS: [ColorType; 8] = [
    ColorType::L8,
    ColorType::La8,
    ColorType::Rgb8,
    ColorType::Rgba8,
    ColorType::L16,
    ColorType::La16,
    ColorType::Rgb16,
    ColorType::Rgba16,
];

/// Every value next to small, large and no alpha, hidden colors among them.
fn all_values() -> DynamicImage {
    let values = |i: u32| {
        let alpha = [0, 1, 255, 256, 257, 65534, 65535, i * 31 % 65536][i as usize / 3 % 8];
        image::Rgba([i as u16, (i * 7 % 65536) as u16, 65535 - i as u16, alpha as u16])
    };
    DynamicImage::from(image::ImageBuffer::from_fn(256, 256, |x, y| values(256 * y + x)))
}

#[test]
fn every_value_of_every_depth_and_alpha_survives_reading_and_writing() {
    for kind in KINDS {
        let stored = convert(&all_values(), kind);
        let (file, color) = Saved::new(&png(&stored)).read();
        let (again, _) = written(&file, &color, Format::Png);
        let again = image::load_from_memory(&again).unwrap();
        assert!(again.color() == kind && again.as_bytes() == stored.as_bytes(), "{kind:?}");
        // The same with the alpha passed in, as from a denoiser that leaves it alone.
        let mut out = Cursor::new(Vec::new());
        file.write(&mut out, Format::Png, &color, file.alpha().as_deref()).unwrap();
        let again = image::load_from_memory(out.get_ref()).unwrap();
        assert!(again.as_bytes() == stored.as_bytes(), "{kind:?}");
    }
}

#[test]
fn hidden_color_is_not_read_and_stays_where_alpha_is_0() {
    let pixels = [[255, 0, 200, 0], [255, 128, 0, 128], [10, 20, 30, 255]];
    let pixel = |x, _| image::Rgba(pixels[x as usize]);
    let stored = DynamicImage::from(image::RgbaImage::from_fn(3, 1, pixel));
    let (file, mut color) = Saved::new(&png(&stored)).read();
    let half = 128.0 / 255.0;
    assert_eq!(color.pixels()[0], [0.0; 3]);
    assert_eq!(color.pixels()[1], [half, Curve::Srgb.linear(half) * half, 0.0]);
    // A darker picture, of which the last pixel becomes transparent and the first half covered.
    color.pixels_mut().iter_mut().flatten().for_each(|v| *v *= 0.25);
    color.pixels_mut()[0] = [half; 3];
    let mut out = Cursor::new(Vec::new());
    file.write(&mut out, Format::Png, &color, Some(&[half, half, 0.0])).unwrap();
    let again = image::load_from_memory(out.get_ref()).unwrap().to_rgba8();
    let quarter = (Curve::Srgb.encoded(0.25) * 255.0).round() as u8;
    assert_eq!(again[(0, 0)].0, [255, 255, 255, 128]);
    assert_eq!(again[(1, 0)].0[0], quarter);
    assert_eq!(again[(2, 0)].0, [10, 20, 30, 0], "the file's color, hidden");
}

#[test]
fn an_exr_made_of_a_png_is_premultiplied() {
    let stored = convert(&all_values(), ColorType::Rgba8);
    let (file, color) = Saved::new(&png(&stored)).read();
    let (bytes, notices) = written(&file, &color, Format::Exr);
    assert_eq!(notices, ["written as linear R, G, B, premultiplied by alpha, in 32-bit float"]);
    let (_, channels) = exr_parts(&bytes);
    let [alpha, .., red] = channels.as_slice() else { panic!("{channels:?}") };
    assert!(alpha.0 == *"A" && red.0 == *"R");
    for ((alpha, red), stored) in alpha.1.iter().zip(&red.1).zip(stored.to_rgba8().pixels()) {
        let [r, .., a] = stored.0.map(|v| f64::from(v) / 255.0);
        let linear = if r <= 0.04045 { r / 12.92 } else { ((r + 0.055) / 1.055).powf(2.4) };
        assert!(
            (f64::from(*alpha) - a).abs() < 1e-6 && (f64::from(*red) - linear * a).abs() < 1e-6
        );
    }
}

#[test]
fn a_jpeg_made_of_a_png_shows_it_over_black() {
    let stored =
        DynamicImage::from(image::RgbaImage::from_pixel(16, 16, image::Rgba([255, 255, 255, 0])));
    let (file, color) = Saved::new(&png(&stored)).read();
    let (bytes, notices) = written(&file, &color, Format::Jpeg);
    assert!(notices[0].contains("JPEG has no alpha"), "{notices:?}");
    assert!(image::load_from_memory(&bytes).unwrap().to_rgb8().iter().all(|&v| v == 0));
}

#[test]
fn a_profile_stays_only_with_the_channels_it_is_for() {
    for (space, pixels, notices) in [
        (b"RGB ", DynamicImage::new_rgb8(4, 4), 0),
        (b"CMYK", DynamicImage::new_rgb8(4, 4), 1),
        (b"GRAY", DynamicImage::new_luma16(4, 4), 0),
        (b"RGB ", DynamicImage::new_luma8(4, 4), 1),
    ] {
        let icc = [&[0; 16][..], space, &[0; 108]].concat();
        let mut input = Vec::new();
        let mut encoder = PngEncoder::new(&mut input);
        encoder.set_icc_profile(icc.clone()).unwrap();
        pixels.write_with_encoder(encoder).unwrap();
        let (file, color) = Saved::new(&input).read();
        let (bytes, said) = written(&file, &color, Format::Png);
        assert_eq!(said.len(), notices);
        let mut decoder = image::codecs::png::PngDecoder::new(Cursor::new(bytes)).unwrap();
        assert_eq!(decoder.icc_profile().unwrap(), (notices == 0).then_some(icc));
        let (_, said) = written(&file, &color, Format::Exr);
        assert!(said[1].contains("color profile was not applied"), "{said:?}");
    }
}

/// EXIF data with nothing but an orientation.
fn exif(orientation: u8) -> Vec<u8> {
    let entry = [0x12, 0x01, 3, 0, 1, 0, 0, 0, orientation, 0, 0, 0];
    [&b"II*\0\x08\0\0\0\x01\0"[..], &entry, &[0; 4]].concat()
}

/// Six blocks of 8×8 pixels in three columns and two rows, from dark to bright.
fn blocks() -> DynamicImage {
    let gray = |x, y| image::Luma([20 + 40 * (x / 8 + 3 * (y / 8)) as u8]);
    DynamicImage::from(image::GrayImage::from_fn(24, 16, gray))
}

/// The number of the block in each place, row by row, and the picture's size in blocks.
fn seen(image: &Image) -> (Vec<u32>, (u32, u32)) {
    let size = (image.width() / 8, image.height() / 8);
    let places = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
    let value = |(x, y): (u32, u32)| image.row(8 * y + 4)[8 * x as usize + 4][0];
    let number = |v| ((Curve::Srgb.encoded(v) * 255.0 - 20.0) / 40.0).round() as u32;
    (places.map(value).map(number).collect(), size)
}

fn oriented(format: Format, orientation: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    if format == Format::Jpeg {
        let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 100);
        encoder.set_exif_metadata(exif(orientation)).unwrap();
        blocks().write_with_encoder(encoder).unwrap();
    } else {
        let mut encoder = PngEncoder::new(&mut bytes);
        encoder.set_exif_metadata(exif(orientation)).unwrap();
        blocks().write_with_encoder(encoder).unwrap();
    }
    bytes
}

/// The eight orientations of EXIF 2.32, 4.6.5: where the blocks 0 1 2 / 3 4 5 are seen.
const SEEN: [([u32; 6], (u32, u32)); 8] = [
    ([0, 1, 2, 3, 4, 5], (3, 2)),
    ([2, 1, 0, 5, 4, 3], (3, 2)),
    ([5, 4, 3, 2, 1, 0], (3, 2)),
    ([3, 4, 5, 0, 1, 2], (3, 2)),
    ([0, 3, 1, 4, 2, 5], (2, 3)),
    ([3, 0, 4, 1, 5, 2], (2, 3)),
    ([5, 2, 4, 1, 3, 0], (2, 3)),
    ([2, 5, 1, 4, 0, 3], (2, 3)),
];

#[test]
fn pictures_are_read_upright_and_written_as_they_were() {
    for (format, other) in [(Format::Jpeg, Format::Png), (Format::Png, Format::Jpeg)] {
        for (orientation, (places, size)) in (1..).zip(SEEN) {
            let saved = Saved::new(&oriented(format, orientation));
            let (file, color) = saved.read();
            assert_eq!(seen(&color), (places.to_vec(), size), "{format:?} {orientation}");
            assert_eq!(describe(&saved.path, Limits::default()).unwrap().size, color.size());
            assert_eq!(read_normals(&saved.path, Limits::default()).unwrap().size(), color.size());

            // The same format: stored pixels and tag as they were.
            let (alike, _) = written(&file, &color, format);
            let stored = image::load_from_memory(&alike).unwrap();
            assert_eq!((stored.width(), stored.height()), (24, 16));
            let (again, color_again) = Saved::new(&alike).read();
            assert_eq!(seen(&color_again), (places.to_vec(), size), "{format:?} {orientation}");
            assert_eq!(again.exif, Some(exif(orientation)));

            // Another format: upright, with EXIF data that turns nothing.
            let (turned, _) = written(&file, &color, other);
            let stored = image::load_from_memory(&turned).unwrap();
            assert_eq!((stored.width() / 8, stored.height() / 8), size);
            let (again, color_again) = Saved::new(&turned).read();
            assert_eq!(seen(&color_again), (places.to_vec(), size), "to {other:?} {orientation}");
            assert_eq!(again.exif, Some(exif(1)));
            let (bytes, _) = written(&file, &color, Format::Exr);
            assert_eq!(exr_parts(&bytes).1.len(), 3);
        }
    }
}

#[test]
fn exif_data_too_long_for_a_jpeg_is_left_out_and_told() {
    for (len, is_kept) in [(65_527, true), (65_528, false)] {
        let mut long = exif(1);
        long.resize(len, 0);
        let mut bytes = Vec::new();
        let mut encoder = PngEncoder::new(&mut bytes);
        encoder.set_exif_metadata(long.clone()).unwrap();
        blocks().write_with_encoder(encoder).unwrap();
        let (file, color) = Saved::new(&bytes).read();
        let (jpeg, said) = written(&file, &color, Format::Jpeg);
        assert_eq!(Saved::new(&jpeg).read().0.exif, is_kept.then_some(long));
        assert_eq!(said.iter().any(|notice| notice.contains("eXIf")), !is_kept, "{said:?}");
    }
}

/// The markers and data of all segments up to the pixels.
fn segments(bytes: &[u8]) -> Vec<(u8, Vec<u8>)> {
    let (mut at, mut found) = (2, Vec::new());
    while bytes[at + 1] != 0xda {
        let end = at + 2 + usize::from(u16::from_be_bytes([bytes[at + 2], bytes[at + 3]]));
        found.push((bytes[at + 1], bytes[at + 4..end].to_vec()));
        at = end;
    }
    found
}

#[test]
fn metadata_of_a_jpeg_is_kept_or_told() {
    let mut bytes = oriented(Format::Jpeg, 6);
    let xmp = b"http://ns.adobe.com/xap/1.0/\0<x:xmpmeta/>".to_vec();
    let extended =
        [b"http://ns.adobe.com/xmp/extension/\0", &[b'0'; 32][..], &[0, 0, 0, 4, 0, 0, 0, 0]];
    let extended = [&extended.concat(), &b"more"[..]].concat();
    let iptc = b"Photoshop 3.0\08BIM\x04\x04\0\0\0\0\0\x02\x1c\x02".to_vec();
    let kept = [(0xe1, xmp), (0xe1, extended), (0xed, iptc), (0xfe, b"by hand".to_vec())];
    let others = [(0xe2, b"MPF\0".to_vec()), (0xeb, b"JP".to_vec()), (0xeb, b"JP".to_vec())];
    let segment = |(marker, data): &(u8, Vec<u8>)| {
        let len = (data.len() as u16 + 2).to_be_bytes();
        [&[0xff, *marker], &len[..], data].concat()
    };
    let added: Vec<u8> = kept.iter().chain(&others).flat_map(segment).collect();
    // 300 pixels per inch across and 150 down the stored picture.
    bytes[13..18].copy_from_slice(&[1, 1, 0x2c, 0, 0x96]);
    bytes.splice(20..20, added);
    let (file, color) = Saved::new(&bytes).read();

    let (alike, notices) = written(&file, &color, Format::Jpeg);
    assert_eq!(notices, ["metadata of the JPEG that was left out: APP2, APP11"]);
    let found = segments(&alike);
    assert!(found[0].1.ends_with(&[1, 1, 0x2c, 0, 0x96, 0, 0]), "{:?}", found[0]);
    assert!(found[1].1.starts_with(b"Exif\0\0II*"), "{:?}", found[1]);
    assert_eq!(found[2..6], kept);
    assert_eq!(image::load_from_memory(&alike).unwrap().width(), 24);

    let (png, notices) = written(&file, &color, Format::Png);
    let lost = "a comment, APP2, APP11";
    assert_eq!(notices, [format!("metadata of the JPEG that was left out: XMP, IPTC, {lost}")]);
    // Upright, the sparse side is the horizontal one: 5906 by 11811 per meter.
    let physical = b"pHYs\0\0\x17\x12\0\0\x2e\x23\x01";
    assert!(png.windows(13).any(|window| window == physical));
    let (exr, notices) = written(&file, &color, Format::Exr);
    assert_eq!(exr_parts(&exr).0.pixel_aspect, 2.0);
    assert!(notices[1].ends_with(": Exif, XMP, IPTC, a comment, APP2, APP11"), "{notices:?}");
}

/// Cut or with a flipped bit, segments are an error or a picture, never a panic.
#[test]
fn no_damage_of_a_jpeg_makes_it_panic() {
    let bytes = oriented(Format::Jpeg, 6);
    let mut refused = 0;
    for round in 0..400_usize {
        let mut damaged = bytes.clone();
        let at = (round * 7919 + round * round * 31) % bytes.len();
        if round.is_multiple_of(3) {
            damaged.truncate(at);
        } else {
            damaged[at] ^= 1 << (round % 8);
        }
        match LdrFile::read(&Saved::new(&damaged).path, Limits::default()) {
            Err(_) => refused += 1,
            Ok((file, color)) => {
                for format in [Format::Png, Format::Jpeg, Format::Exr] {
                    file.write(&mut Cursor::new(Vec::new()), format, &color, None).unwrap();
                }
            }
        }
    }
    assert!(refused > 99, "only {refused} were refused");
}
