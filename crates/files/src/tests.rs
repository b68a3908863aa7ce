use std::path::PathBuf;

use ::exr::prelude::*;

use super::{LayerChoice, Picture};
use wgdenoise::Image as Pixels;

mod choice;
mod damage;
mod kinds;
mod names;
mod png;
mod views;

type AnyImage = ::exr::image::Image<Layers<AnyChannels<FlatSamples>>>;

const SIZE: (usize, usize) = (37, 41);
const ALL: [Compression; 10] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
    Compression::DWAA(None),
    Compression::DWAB(None),
];

fn noise(seed: usize, i: usize) -> f32 {
    let mixed = (seed * 7919 + i).wrapping_mul(2_654_435_761) >> 7;
    (mixed % 4096) as f32 / 1024.0
}

fn half(seed: usize, n: usize) -> FlatSamples {
    FlatSamples::F16((0..n).map(|i| f16::from_f32(noise(seed, i))).collect())
}

fn float(seed: usize, n: usize) -> FlatSamples {
    // PXR24 keeps 16 bits of a float's mantissa: the values need no more.
    FlatSamples::F32((0..n).map(|i| noise(seed, i)).collect())
}

fn layer(
    name: &str,
    size: (usize, usize),
    encoding: Encoding,
    channels: Vec<(&str, FlatSamples)>,
) -> Layer<AnyChannels<FlatSamples>> {
    let list = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let mut attributes = LayerAttributes::named(name);
    attributes.other.insert(Text::from("shot"), AttributeValue::Text(Text::from(name)));
    Layer::new(size, attributes, encoding, AnyChannels::sort(list))
}

/// Karma's parts: half color with alpha, next to a float and an integer channel; albedo in another
/// window; normals.
fn karma(compression: Compression, blocks: Blocks) -> AnyImage {
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let n = SIZE.0 * SIZE.1;
    let ids = FlatSamples::U32((0..n as u32).map(|i| i.wrapping_mul(0x0101_0101)).collect());
    let mut channels: Vec<_> = ["A", "B", "G", "R"].into_iter().zip(1..).collect::<Vec<_>>();
    let mut list: Vec<_> = channels.drain(..).map(|(name, seed)| (name, half(seed, n))).collect();
    list.extend([("depth.Z", float(5, n)), ("id.X", ids)]);
    let mut color = layer("C", SIZE, encoding, list);
    color.attributes.layer_position = Vec2(-3, 5);
    let small = ["R", "G", "B"].map(|c| (c, half(6, 20 * 10))).to_vec();
    let mut albedo = layer("albedo", (20, 10), encoding, small);
    albedo.attributes.layer_position = Vec2(0, 0);
    let mut normal = layer("N", SIZE, encoding, ["X", "Y", "Z"].map(|c| (c, float(9, n))).to_vec());
    normal.attributes.layer_position = Vec2(-3, 5);
    let display = IntegerBounds::new((0, 0), (64, 48));
    AnyImage {
        attributes: ImageAttributes::new(display),
        layer_data: SmallVec::from_vec(vec![color, albedo, normal]),
    }
}

fn read(path: &std::path::Path) -> AnyImage {
    let reader = ::exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    reader.all_layers().all_attributes().from_file(path).unwrap()
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn with(&self, image: &AnyImage) -> PathBuf {
        let path = self.path("in.exr");
        image.write().to_file(&path).unwrap();
        path
    }
}

fn open(path: &std::path::Path) -> Picture {
    Picture::open(path, &LayerChoice::default()).unwrap()
}

/// A color with values that half holds exactly.
fn painted(like: &Pixels) -> Pixels {
    let (w, h) = like.size();
    let pixel = |i: u32| [i % 512, i * 7 % 509, i / 3 % 503].map(|v| v as f32 * 0.5);
    let pixels = (0..w * h).map(pixel).collect();
    Pixels::new(w, h, pixels).unwrap()
}

fn color(image: &AnyImage, part: usize, name: &str) -> Vec<f32> {
    let list = &image.layer_data[part].channel_data.list;
    list.iter().find(|c| c.name == *name).unwrap().sample_data.values_as_f32().collect()
}

fn planes(image: &Pixels) -> [Vec<f32>; 3] {
    [0, 1, 2].map(|c| image.pixels().iter().map(|p| p[c]).collect())
}

fn colors(image: &AnyImage, part: usize) -> [Vec<f32>; 3] {
    ["R", "G", "B"].map(|name| color(image, part, name))
}

#[test]
fn every_compression_keeps_all_but_the_three_channels_bit_for_bit() {
    let tiles = Blocks::Tiles(Vec2(16, 8));
    for compression in ALL {
        for (blocks, line_order) in [
            (Blocks::ScanLines, LineOrder::Increasing),
            (Blocks::ScanLines, LineOrder::Decreasing),
            (tiles, LineOrder::Increasing),
            (tiles, LineOrder::Decreasing),
            (tiles, LineOrder::Unspecified),
        ] {
            let mut image = karma(compression, blocks);
            image.layer_data.iter_mut().for_each(|l| l.encoding.line_order = line_order);
            // The color's part is the first, or the last.
            let last = line_order != LineOrder::Increasing;
            if last {
                image.layer_data.reverse();
            }
            check_round_trip(&image, compression, if last { 2 } else { 0 });
        }
    }
}

fn check_round_trip(image: &AnyImage, compression: Compression, part: usize) {
    let folder = Folder::new();
    let input = folder.with(image);
    let picture = open(&input);
    assert!(picture.first().albedo().is_some() && picture.first().normal().is_some());
    let output = folder.path("out.exr");
    let denoised = painted(picture.first().color());
    let notices = picture.save(&output, &[denoised.clone().into()], false).unwrap();

    // B44 changes half channels such as alpha; to DWA, alpha is neither color nor luminance.
    let b44 = matches!(compression, Compression::B44 | Compression::B44A);
    let lossy = b44 || matches!(compression, Compression::DWAA(_) | Compression::DWAB(_));
    assert_eq!(notices.len(), usize::from(b44), "{compression}: {notices:?}");
    let (before, mut after) = (read(&input), read(&output));
    assert!(
        planes(picture.first().color()) == colors(&before, part),
        "{compression}: other colors"
    );
    if !lossy {
        assert!(colors(&before, part) == colors(image, part), "{compression}: other colors");
        assert!(colors(&after, part) == planes(&denoised), "{compression}: not as painted");
    }
    let old = &before.layer_data[part].channel_data.list;
    for (new, old) in after.layer_data[part].channel_data.list.iter_mut().zip(old) {
        let painted = ["R", "G", "B"].iter().any(|n| new.name == **n);
        if painted || (b44 && new.name == *"A") {
            assert!(!painted || new.sample_data != old.sample_data);
            new.sample_data = old.sample_data.clone();
        }
    }
    assert!(before == after, "{compression}: something else changed");
}

#[test]
fn albedo_in_another_window_is_moved_to_the_color_with_a_notice() {
    let folder = Folder::new();
    let picture = open(&folder.with(&karma(Compression::ZIP16, Blocks::ScanLines)));
    let albedo = picture.first().albedo().unwrap();
    assert_eq!(albedo.size(), (37, 41));
    // The color's corner is (−3, 5), the albedo's (0, 0): column 3 of row 0 is its row 5.
    let expected = f16::from_f32(noise(6, 5 * 20)).to_f32();
    assert_eq!((albedo.row(0)[2], albedo.row(0)[3]), ([0.0; 3], [expected; 3]));
    assert!(
        picture.notices().iter().any(|n| n.contains("`albedo` covers 20×10 pixels from (0, 0)"))
    );
}

#[test]
fn smaller_mip_levels_stay_as_they_were_with_a_notice() {
    let folder = Folder::new();
    let path = folder.path("in.exr");
    let levels = |seed| Levels::Mip {
        rounding_mode: ::exr::math::RoundingMode::Down,
        level_data: [37 * 41, 18 * 20, 9 * 10, 4 * 5, 2 * 2, 1].map(|n| half(seed, n)).to_vec(),
    };
    let channel = |(name, seed)| AnyChannel::new(name, levels(seed));
    let channels =
        AnyChannels::sort([("R", 1), ("G", 2), ("B", 3)].map(channel).into_iter().collect());
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::Tiles(Vec2(16, 16)),
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(SIZE, LayerAttributes::default(), encoding, channels);
    Image::from_layer(layer).write().to_file(&path).unwrap();

    let picture = open(&path);
    let denoised = painted(picture.first().color());
    let notices = picture.save(&folder.path("out.exr"), &[denoised.clone().into()], false).unwrap();
    assert_eq!(notices, ["only the largest mip level was denoised"]);
    let read = |path: PathBuf| {
        let reader = ::exr::prelude::read().no_deep_data().all_resolution_levels().all_channels();
        let image = reader.all_layers().all_attributes().from_file(path).unwrap();
        image.layer_data[0].channel_data.list[2].sample_data.levels_as_slice().to_vec()
    };
    let (before, after) = (read(path.clone()), read(folder.path("out.exr")));
    assert_eq!((before.len(), &before[1..]), (6, &after[1..]));
    let red: Vec<f32> = denoised.pixels().iter().map(|p| p[0]).collect();
    assert_eq!(after[0].values_as_f32().collect::<Vec<_>>(), red);
}

#[test]
fn values_too_large_for_half_are_clamped_and_counted() {
    let folder = Folder::new();
    let picture = open(&folder.with(&karma(Compression::PIZ, Blocks::ScanLines)));
    let mut denoised = painted(picture.first().color());
    denoised.pixels_mut()[7] = [1e6, 65504.0, f32::INFINITY];
    let notices = picture.save(&folder.path("out.exr"), &[denoised.clone().into()], false).unwrap();
    assert!(notices[0].starts_with("2 values exceed 65504"), "{notices:?}");
    let written = read(&folder.path("out.exr"));
    assert_eq!((color(&written, 0, "R")[7], color(&written, 0, "B")[7]), (65504.0, 65504.0));
}
