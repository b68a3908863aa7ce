//! Valid files that the renderers do not write.

use ::exr::image::RipMaps;
use ::exr::math::RoundingMode;
use ::exr::meta::attribute::{EnvironmentMap, FloatRect, Preview, TimeCode};

use super::*;

fn rgb(n: usize) -> Vec<(&'static str, FlatSamples)> {
    ["R", "G", "B"].into_iter().zip(1..).map(|(name, seed)| (name, half(seed, n))).collect()
}

fn image(layers: Vec<Layer<AnyChannels<FlatSamples>>>) -> AnyImage {
    let attributes = ImageAttributes::new(IntegerBounds::new((-9, -7), (64, 48)));
    AnyImage { attributes, layer_data: SmallVec::from_vec(layers) }
}

/// Denoises a file, checks that only R, G and B of its first part differ, and returns the notices.
fn keep_all_else(folder: &Folder, image: &AnyImage, color: Option<&str>) -> Vec<String> {
    let (input, output) = (folder.with(image), folder.path("out.exr"));
    let wanted = LayerChoice { color: color.map(Into::into), ..LayerChoice::default() };
    let picture = Picture::open(&input, &wanted).unwrap();
    let notices = picture.save(&output, &[painted(picture.first().color()).into()], true).unwrap();
    let (before, mut after) = (read(&input), read(&output));
    let old = &before.layer_data[0].channel_data.list;
    for (new, old) in after.layer_data[0].channel_data.list.iter_mut().zip(old) {
        if ["R", "G", "B"].iter().any(|name| old.name == **name) {
            assert_ne!(new.sample_data, old.sample_data);
            new.sample_data = old.sample_data.clone();
        }
    }
    assert!(before == after, "something else changed");
    assert_eq!(head(&input), head(&output));
    notices
}

/// Everything before the table of blocks, whose first entry is where the table ends.
fn head(path: &std::path::Path) -> Vec<u8> {
    let mut bytes = std::fs::read(path).unwrap();
    let meta = MetaData::read_from_file(path, false).unwrap();
    let blocks: usize = meta.headers.iter().map(|header| header.chunk_count).sum();
    let ends_table = |at: usize| bytes[at..at + 8] == ((at + 8 * blocks) as u64).to_le_bytes();
    let table = (0..bytes.len() - 8).find(|&at| ends_table(at)).unwrap();
    bytes.truncate(table);
    bytes
}

#[test]
fn a_single_pixel_is_an_image_in_every_compression() {
    for compression in ALL {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(64, 32))] {
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            let channels = [rgb(1), vec![("Z", float(4, 1))]].concat();
            let mut layer = layer("pixel", (1, 1), encoding, channels);
            layer.attributes.layer_position = Vec2(-1_000_000, 1_000_000);
            let notices = keep_all_else(&Folder::new(), &image(vec![layer]), None);
            assert!(notices.is_empty(), "{compression}: {notices:?}");
        }
    }
}

/// Reports loss only for channels in the color's blocks that the compression changes: channels
/// marked as kept must stay bit for bit.
#[test]
fn loss_beside_the_color_is_reported_exactly_where_it_happens() {
    let b44 = [Compression::B44, Compression::B44A];
    let dwa = [Compression::DWAA(None), Compression::DWAB(None)];
    let n = SIZE.0 * SIZE.1;
    let ids = || FlatSamples::U32((0..n as u32).map(|i| i.wrapping_mul(0x9e37_79b9)).collect());
    for (compressions, name, samples, kept) in [
        (b44, "A", half(7, n), false),
        (b44, "depth.Z", float(7, n), true),
        (b44, "id.X", ids(), true),
        (dwa, "A", half(7, n), true),
        (dwa, "albedo.G", half(7, n), false),
        (dwa, "albedo.G", float(7, n), false),
        (dwa, "luma.Y", half(7, n), false),
        (dwa, "depth.Z", half(7, n), true),
        (dwa, "depth.Z", float(7, n), true),
        (dwa, "id.R", ids(), true),
    ] {
        for compression in compressions {
            let encoding = Encoding { compression, ..Encoding::FAST_LOSSLESS };
            let channels = [rgb(n), vec![(name, samples.clone())]].concat();
            let image = image(vec![layer("C", SIZE, encoding, channels)]);
            let folder = Folder::new();
            let picture = open(&folder.with(&image));
            let notices = picture.save(
                &folder.path("o.exr"),
                &[painted(picture.first().color()).into()],
                false,
            );
            let said = notices.unwrap().iter().any(|n| n.contains("have changed slightly"));
            assert_eq!(said, !kept, "{compression} {name}");
            if kept {
                keep_all_else(&folder, &image, None);
            }
        }
    }
}

/// The sides of a picture's levels.
fn halved(mut side: usize, rounding: RoundingMode) -> Vec<usize> {
    let mut sides = vec![side];
    while side > 1 {
        side = if rounding == RoundingMode::Up { side.div_ceil(2) } else { side / 2 };
        sides.push(side);
    }
    sides
}

fn levels(
    seed: usize,
    (w, h): (usize, usize),
    rounding: RoundingMode,
    rip: bool,
) -> Levels<FlatSamples> {
    let (xs, ys) = (halved(w, rounding), halved(h, rounding));
    let samples = |(w, h): (usize, usize)| half(seed, w * h);
    if rip {
        let sizes = ys.iter().flat_map(|&h| xs.iter().map(move |&w| (w, h)));
        let level_count = Vec2(xs.len(), ys.len());
        let level_data = RipMaps { map_data: sizes.map(samples).collect(), level_count };
        return Levels::Rip { rounding_mode: rounding, level_data };
    }
    let side = |sides: &[usize], i: usize| sides.get(i).copied().unwrap_or(1);
    let sizes = (0..xs.len().max(ys.len())).map(|i| (side(&xs, i), side(&ys, i)));
    Levels::Mip { rounding_mode: rounding, level_data: sizes.map(samples).collect() }
}

#[test]
fn mip_maps_and_rip_maps_keep_all_but_their_largest_level() {
    for (rounding, rip) in [
        (RoundingMode::Down, false),
        (RoundingMode::Up, false),
        (RoundingMode::Down, true),
        (RoundingMode::Up, true),
    ] {
        let folder = Folder::new();
        let (input, output) = (folder.path("in.exr"), folder.path("out.exr"));
        let size = (29, 14);
        let channel = |(name, seed)| AnyChannel::new(name, levels(seed, size, rounding, rip));
        let list = [("R", 1), ("G", 2), ("B", 3), ("A", 4)].map(channel);
        let encoding = Encoding {
            compression: Compression::PIZ,
            blocks: Blocks::Tiles(Vec2(8, 4)),
            line_order: LineOrder::Increasing,
        };
        let channels = AnyChannels::sort(list.into_iter().collect());
        let layer = Layer::new(size, LayerAttributes::named("C"), encoding, channels);
        Image::from_layer(layer).write().to_file(&input).unwrap();
        let picture = open(&input);
        let notices =
            picture.save(&output, &[painted(picture.first().color()).into()], false).unwrap();
        assert_eq!(notices, ["only the largest mip level was denoised"]);
        let read = |path: &PathBuf| {
            let reader = ::exr::prelude::read().no_deep_data().all_resolution_levels();
            reader.all_channels().first_valid_layer().all_attributes().from_file(path).unwrap()
        };
        let (before, after) = (read(&input), read(&output));
        assert!(before.layer_data.attributes == after.layer_data.attributes);
        let samples = |channels: &AnyChannels<Levels<FlatSamples>>| -> Vec<Vec<FlatSamples>> {
            channels.list.iter().map(|c| c.sample_data.levels_as_slice().to_vec()).collect()
        };
        let before = samples(&before.layer_data.channel_data);
        let after = samples(&after.layer_data.channel_data);
        assert!(before[0] == after[0], "alpha changed");
        for (old, new) in before[1..].iter().zip(&after[1..]) {
            assert!(old[0] != new[0] && old[1..] == new[1..]);
        }
    }
}

/// Every known type of attribute, unknown types, and names of the greatest length.
#[test]
fn attributes_of_all_types_and_long_names_are_kept() {
    use AttributeValue as V;
    let long = |letter: &str| Text::from(letter.repeat(255).as_str());
    let text = |text: &str| Text::from(text);
    let time = TimeCode { hours: 9, minutes: 8, binary_groups: [5; 8], ..TimeCode::default() };
    // The crate would write six of these seven numbers.
    let code = (1..8_u8).flat_map(|number| [number, 0, 0, 0]).collect();
    let values = [
        V::EnvironmentMap(EnvironmentMap::Cube),
        V::Custom { kind: text("keycode"), bytes: code },
        V::Matrix3x3([0.5; 9]),
        V::Matrix4x4([-0.5; 16]),
        V::Rational((24000, 1001)),
        V::TextVector(vec![text("left"), text("right")]),
        V::Text(text("still life")),
        V::F64(f64::MIN_POSITIVE),
        V::F32(f32::INFINITY),
        V::I32(i32::MIN),
        V::IntegerBounds(IntegerBounds::new((-4, 5), (6, 7))),
        V::FloatRect(FloatRect { min: Vec2(-1.0, 0.5), max: Vec2(2.0, 3.0) }),
        V::IntVec2(Vec2(1, -2)),
        V::FloatVec2(Vec2(1.5, -2.5)),
        V::IntVec3((1, -2, 3)),
        V::FloatVec3((1.5, -2.5, 3.5)),
        V::Bytes { type_hint: text("icc"), bytes: SmallVec::from_slice(&[0, 255, 7]) },
        V::Custom { kind: text("studio.opaque"), bytes: SmallVec::from_slice(&[0xab; 999]) },
        V::Custom { kind: long("k"), bytes: SmallVec::new() },
    ];
    let id = format!("{}.R", "i".repeat(253));
    let n = SIZE.0 * SIZE.1;
    let channels = [rgb(n), vec![(id.as_str(), float(4, n))]].concat();
    let mut layer = layer(&"n".repeat(255), SIZE, Encoding::FAST_LOSSLESS, channels);
    let other = &mut layer.attributes.other;
    other.insert(long("a"), V::F32(0.25));
    for (i, value) in values.into_iter().enumerate() {
        other.insert(text(&format!("attribute{i}")), value);
    }
    layer.attributes.preview =
        Some(Preview { size: Vec2(3, 2), pixel_data: (0..24).map(|i| i * 5 - 60).collect() });
    layer.attributes.view_name = Some(text("left"));
    let mut image = image(vec![layer]);
    image.attributes.chromaticities = Some(rec2020());
    image.attributes.time_code = Some(time);
    // These two types must be the same in all parts.
    image.attributes.other.insert(text("gamut"), V::Chromaticities(rec2020()));
    image.attributes.other.insert(text("clock"), V::TimeCode(time));
    image.attributes.pixel_aspect = 1.333;
    assert!(keep_all_else(&Folder::new(), &image, None).is_empty());
}

fn rec2020() -> ::exr::meta::attribute::Chromaticities {
    ::exr::meta::attribute::Chromaticities {
        red: Vec2(0.708, 0.292),
        green: Vec2(0.170, 0.797),
        blue: Vec2(0.131, 0.046),
        white: Vec2(0.3127, 0.3290),
    }
}

#[test]
fn of_two_views_both_are_denoised_or_the_one_that_is_named() {
    let view = |name: &str, encoding| {
        let n = SIZE.0 * SIZE.1;
        let mut layer = layer(name, SIZE, encoding, rgb(n));
        layer.attributes.view_name = Some(Text::from(name));
        layer
    };
    let left = view("left", Encoding::SMALL_FAST_LOSSLESS);
    let image = image(vec![left, view("right", Encoding::UNCOMPRESSED)]);
    let folder = Folder::new();
    assert!(keep_all_else(&folder, &image, Some("left")).is_empty());
    let picture = open(&folder.with(&image));
    let names: Vec<_> = picture.views().iter().map(crate::View::name).collect();
    assert_eq!(names, [Some("left"), Some("right")]);
}

#[test]
fn only_a_latlong_environment_is_a_panorama() {
    let cases = [
        (None, false),
        (Some(EnvironmentMap::LatitudeLongitude), true),
        (Some(EnvironmentMap::Cube), false),
    ];
    for (environment_map, expected) in cases {
        for (width, is_whole) in [(6, true), (8, false)] {
            let mut layer = layer("sky", (6, 4), Encoding::default(), rgb(24));
            layer.attributes.environment_map = environment_map;
            let window = IntegerBounds::new(layer.attributes.layer_position, (width, 4));
            let attributes = ImageAttributes::new(window);
            let sky = AnyImage { attributes, layer_data: SmallVec::from_vec(vec![layer]) };
            let folder = Folder::new();
            let picture = Picture::open(&folder.with(&sky), &LayerChoice::default()).unwrap();
            assert_eq!(
                picture.first().is_panorama(),
                expected && is_whole,
                "{environment_map:?} {width}"
            );
            let warns = picture.notices().iter().any(|notice| notice.contains("cube map"));
            assert_eq!(warns, environment_map == Some(EnvironmentMap::Cube));
        }
    }
}
