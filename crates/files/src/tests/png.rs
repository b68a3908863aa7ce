//! PNG by its chunks: what is kept, decoded and refused.

use std::io::Cursor;

use ::exr::math::Vec2;
use png::chunk::ChunkType;
use png::{BitDepth, ColorType};

use crate::ldr::chunks::checksum;
use crate::ldr::{self, LdrFile};
use crate::{Format, Limits, Problem, primaries};
use wgdenoise::Image;

type Named<'a> = (&'a [u8; 4], Vec<u8>);

/// A PNG with a ramp of 16-bit colors, and these chunks before and after it.
fn ramp(before: &[Named], after: &[Named]) -> Vec<u8> {
    let samples = (0..3 * 64 * 4_u32).flat_map(|i| ((i * 85) as u16).to_be_bytes());
    file((64, 4), (ColorType::Rgb, BitDepth::Sixteen), &samples.collect::<Vec<_>>(), before, after)
}

fn file(
    (width, height): (u32, u32),
    (color, depth): (ColorType, BitDepth),
    samples: &[u8],
    before: &[Named],
    after: &[Named],
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().unwrap();
    let put = |writer: &mut png::Writer<_>, chunks: &[Named]| {
        for (kind, data) in chunks {
            writer.write_chunk(ChunkType(**kind), data).unwrap();
        }
    };
    put(&mut writer, before);
    writer.write_image_data(samples).unwrap();
    put(&mut writer, after);
    writer.finish().unwrap();
    bytes
}

/// Length, type and data of every chunk but the header, the pixels and the end.
fn listed(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let (mut at, mut found) = (8, Vec::new());
    while at < bytes.len() {
        let len = u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let kind = String::from_utf8(bytes[at + 4..at + 8].to_vec()).unwrap();
        if !["IHDR", "IEND"].contains(&&*kind)
            && found.last().is_none_or(|(k, _)| kind != "IDAT" || k != "IDAT")
        {
            let data =
                if kind == "IDAT" { Vec::new() } else { bytes[at + 8..at + 8 + len].to_vec() };
            found.push((kind, data));
        }
        at += 12 + len;
    }
    found
}

fn as_listed(chunks: &[Named]) -> Vec<(String, Vec<u8>)> {
    let name = |kind: &[u8; 4]| String::from_utf8(kind.to_vec()).unwrap();
    chunks.iter().map(|(kind, data)| (name(kind), data.clone())).collect()
}

fn try_read(bytes: &[u8]) -> Result<(LdrFile, Image), Problem> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("in.png");
    std::fs::write(&path, bytes).unwrap();
    LdrFile::read(&path, Limits::default())
}

fn written(bytes: &[u8], format: Format) -> (Vec<u8>, Vec<String>) {
    let (file, color) = try_read(bytes).unwrap();
    let mut out = Cursor::new(Vec::new());
    let notices = file.write(&mut out, format, &color, None).unwrap();
    (out.into_inner(), notices)
}

fn gamma(value: u32) -> Named<'static> {
    (b"gAMA", value.to_be_bytes().to_vec())
}

fn physical(x: u32, y: u32, unit: u8) -> Named<'static> {
    (b"pHYs", [&x.to_be_bytes()[..], &y.to_be_bytes(), &[unit]].concat())
}

/// White, red, green and blue.
fn chromaticities(points: [f64; 8]) -> Named<'static> {
    let bytes = points.map(|v| ((v * 1e5).round() as u32).to_be_bytes());
    (b"cHRM", bytes.concat())
}

const P3: [f64; 8] = [0.3127, 0.329, 0.68, 0.32, 0.265, 0.69, 0.15, 0.06];

#[test]
fn chunks_that_hold_for_any_pixels_are_kept_byte_for_byte_on_their_side() {
    let before = [
        gamma(45_455),
        chromaticities(P3),
        (b"mDCV", vec![1; 24]),
        (b"cLLI", vec![2; 8]),
        physical(11_811, 11_811, 1),
        (b"bKGD", vec![0, 1, 0, 2, 0, 3]),
        (b"tEXt", b"RenderTime\x0012:34.56".to_vec()),
        (b"tEXt", b"Camera\0Camera.001".to_vec()),
        (b"zTXt", b"Long\0\0\x78\x9c\x03\0\0\0\0\x01".to_vec()),
        (b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0<x/>".to_vec()),
        (b"vpAg", vec![9; 9]),
    ];
    let after = [
        (b"tIME", vec![0x07, 0xea, 1, 2, 3, 4, 5]),
        (b"eXIf", b"MM\0*\0\0\0\x08\0\0\0\0\0\0".to_vec()),
        (b"tEXt", b"Late\0text".to_vec()),
    ];
    let input = ramp(&before, &after);
    let (output, notices) = written(&input, Format::Png);
    let pixels = vec![("IDAT".to_string(), Vec::new())];
    assert_eq!(listed(&output), [as_listed(&before), pixels, as_listed(&after)].concat());
    assert!(notices.is_empty(), "{notices:?}");
    let [old, new] = [&input, &output].map(|bytes| image::load_from_memory(bytes).unwrap());
    assert!(old.as_bytes() == new.as_bytes(), "unchanged color is unchanged");
}

/// A file with data that the other formats have no place for.
#[test]
fn what_another_format_has_no_place_for_is_told() {
    let input = ramp(&[gamma(45_455), physical(1, 1, 0), (b"tEXt", b"a\0b".to_vec())], &[]);
    let (_, notices) = written(&input, Format::Exr);
    assert_eq!(notices[1..], ["chunks of the PNG that were left out: `tEXt`"]);
    let (_, notices) = written(&input, Format::Jpeg);
    assert_eq!(notices, ["chunks of the PNG that were left out: `tEXt`"]);
}

#[test]
fn chunks_that_describe_the_old_pixels_are_left_out_and_told() {
    let before = [(b"sBIT", vec![10, 10, 10]), (b"caBX", vec![1]), (b"tEXt", b"a\0b".to_vec())];
    let (output, notices) = written(&ramp(&before, &[(b"sPLT", vec![1])]), Format::Png);
    assert_eq!(listed(&output)[0].0, "tEXt");
    assert_eq!(notices, ["chunks of the PNG that were left out: `sBIT`, `caBX`, `sPLT`"]);
    // A background by its index in the palette, which the output does not have.
    let before = [(b"PLTE", vec![0, 50, 100, 200, 250, 255]), (b"bKGD", vec![1])];
    let palette = (ColorType::Grayscale, BitDepth::One);
    let mut bytes = file((8, 1), palette, &[0b0110_0101], &before, &[]);
    bytes[25] = 3;
    let sum = checksum(*b"IHDR", &bytes[16..29]).to_be_bytes();
    bytes[29..33].copy_from_slice(&sum);
    let (output, notices) = written(&bytes, Format::Png);
    assert_eq!(notices, ["chunks of the PNG that were left out: `bKGD`"]);
    let pixels = image::load_from_memory(&output).unwrap().to_rgb8();
    assert_eq!((pixels[(0, 0)].0, pixels[(1, 0)].0), ([0, 50, 100], [200, 250, 255]));
}

#[test]
fn damaged_and_huge_chunks_are_left_out_and_told() {
    let mut bytes = ramp(&[(b"tEXt", b"a\0b".to_vec())], &[(b"tEXt", b"late\0c".to_vec())]);
    let at = bytes.windows(4).position(|w| w == b"tEXt").unwrap();
    bytes[at + 5] ^= 1;
    let (output, notices) = written(&bytes, Format::Png);
    assert_eq!(notices, ["chunks of the PNG that were left out: `tEXt`"]);
    assert_eq!(listed(&output), [("IDAT".into(), vec![]), ("tEXt".into(), b"late\0c".to_vec())]);
    // It ends within the second text.
    bytes.truncate(bytes.len() - 14);
    assert_eq!(listed(&written(&bytes, Format::Png).0).len(), 1);
    let huge = ramp(&[], &[(b"huge", vec![0; (64 << 20) + 1]), (b"tEXt", b"d\0e".to_vec())]);
    let (output, notices) = written(&huge, Format::Png);
    assert_eq!(notices, ["chunks of the PNG that were left out: `huge`"]);
    assert_eq!(listed(&output), [("IDAT".into(), vec![]), ("tEXt".into(), b"d\0e".to_vec())]);
}

#[test]
fn light_is_decoded_by_the_gamma_of_the_file() {
    let light = |chunks: &[Named]| try_read(&ramp(chunks, &[])).unwrap().1.pixels()[21][0];
    let stored = f64::from(63 * 85) / 65535.0;
    let srgb = ((stored + 0.055) / 1.055).powf(2.4);
    let bt709 = ((stored + 0.099_296_8) / 1.099_296_8).powf(1.0 / 0.45);
    let cicp = |curve: u8| (b"cICP", vec![1, curve, 0, 1]);
    for (chunks, expected) in [
        (vec![], srgb),
        (vec![gamma(100_000)], stored),
        (vec![gamma(45_455)], stored.powf(1.0 / 0.45455)),
        (vec![gamma(100_000), (b"sRGB", vec![0])], srgb),
        (vec![gamma(0)], srgb),
        (vec![gamma(1)], srgb),
        (vec![gamma(45_455), cicp(8)], stored),
        (vec![cicp(13)], srgb),
        (vec![cicp(1)], bt709),
        (vec![gamma(100_000), cicp(2)], stored),
    ] {
        assert!((f64::from(light(&chunks)) - expected).abs() < 1e-6, "{chunks:?}");
        let input = ramp(&chunks, &[]);
        let [old, new] = [&input, &written(&input, Format::Png).0]
            .map(|bytes| image::load_from_memory(bytes).unwrap());
        assert!(old.as_bytes() == new.as_bytes(), "{chunks:?}");
    }
}

#[test]
fn curves_and_primaries_that_are_not_supported_are_refused_in_one_sentence() {
    for (numbers, words) in [
        ([9, 16, 0, 1], "is encoded by PQ"),
        ([9, 18, 0, 1], "is encoded by HLG"),
        ([1, 17, 0, 1], "is encoded by the curve 17 of H.273"),
        ([1, 13, 1, 1], "is stored as video"),
        ([1, 13, 0, 0], "is stored as video"),
        ([99, 13, 0, 1], "is of the primaries 99 of H.273"),
    ] {
        let error = try_read(&ramp(&[(b"cICP", numbers.to_vec())], &[])).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn an_exr_has_the_primaries_and_the_pixel_shape_of_the_png() {
    let attributes = |chunks: &[Named]| {
        let (bytes, _) = written(&ramp(chunks, &[]), Format::Exr);
        let meta = ::exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).unwrap();
        meta.headers[0].shared_attributes.clone()
    };
    let srgb = [0.3127, 0.329, 0.64, 0.33, 0.3, 0.6, 0.15, 0.06];
    assert_eq!(attributes(&[chromaticities(srgb)]).chromaticities, None);
    let p3 = attributes(&[chromaticities(P3), physical(100, 200, 0)]);
    assert_eq!(p3.pixel_aspect, 2.0);
    let found = p3.chromaticities.unwrap();
    assert!(primaries::are_alike(&found, &primaries::numbered(12).unwrap()), "{found:?}");
    let bt2020 = attributes(&[(b"cICP", vec![9, 13, 0, 1])]).chromaticities.unwrap();
    assert_eq!(bt2020.red, Vec2(0.708, 0.292));
}

/// Red of P3 is outside sRGB: its green and blue would be negative.
#[test]
fn a_jpeg_made_of_a_png_has_colors_of_srgb() {
    let red = [0x80, 0x00, 0x20, 0x00, 0x20, 0x00].repeat(64);
    let kind = (ColorType::Rgb, BitDepth::Sixteen);
    let stored = |chunks: &[Named]| file((8, 8), kind, &red, chunks, &[]);
    let shown = |chunks: &[Named]| {
        let (bytes, _) = written(&stored(chunks), Format::Jpeg);
        image::load_from_memory(&bytes).unwrap().to_rgb8()[(4, 4)].0
    };
    let [plain, wide] = [shown(&[]), shown(&[chromaticities(P3), gamma(45_455)])];
    assert!(plain[0].abs_diff(128) < 3 && wide[0] > plain[0] + 8, "{plain:?} {wide:?}");
    assert!(wide[1] < plain[1], "{plain:?} {wide:?}");
}

#[test]
fn an_animation_is_told() {
    let control = [&2_u32.to_be_bytes()[..], &[0; 4]].concat();
    let (file, _) = try_read(&ramp(&[(b"acTL", control)], &[])).unwrap();
    assert!(file.notices()[0].contains("only its first image is denoised"), "{:?}", file.notices());
    let (still, _) = try_read(&ramp(&[], &[])).unwrap();
    assert!(still.notices().is_empty());
}

#[test]
fn info_tells_the_curve_and_frames() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("in.png");
    std::fs::write(&path, ramp(&[gamma(100_000), (b"acTL", vec![0, 0, 0, 2, 0, 0, 0, 0])], &[]))
        .unwrap();
    let found = ldr::describe(&path, Limits::default()).unwrap();
    assert_eq!((found.text.as_str(), found.size), ("16-bit RGB, linear, animated", (64, 4)));
}

/// Every bit of the chunks and every length: an error or a picture, never a panic.
#[test]
fn no_damage_makes_it_panic() {
    let chunks =
        [gamma(45_455), chromaticities(P3), (b"cICP", vec![1, 13, 0, 1]), physical(1, 2, 0)];
    let exif =
        (b"eXIf", b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0".to_vec());
    let bytes = ramp(&chunks, &[exif]);
    let mut refused = 0;
    for round in 0..400_usize {
        let mut damaged = bytes.clone();
        let at = (round * 7919 + round * round * 31) % bytes.len();
        if round % 3 == 0 {
            damaged.truncate(at);
        } else {
            damaged[at] ^= 1 << (round % 8);
        }
        match try_read(&damaged) {
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
