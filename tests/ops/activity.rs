use std::collections::BTreeSet;

use wgdenoise::Rect;
use wgdenoise::internals::model::{Encoding, TransferFunction};
use wgdenoise::internals::ops::activity::{Activity, FAR, LAYERS, activity};
use wgdenoise::internals::ops::input_process::Sources;
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::plan::tiles::PlacedTile;
use wgdenoise::internals::reference::{self, TileOfView, View};
use wgdenoise::{Frame, Image, Precision, wgpu};

use wgdenoise_testing::gpu::{buffer, context, read_back, submit};
use wgdenoise_testing::{Random, run_cases};

/// The largest second difference of a clean block, by definition.
const T: f64 = 1.0 / 1024.0;
const SCALE: f32 = 0.37;
const RADIUS: u32 = 7;

/// Sizes of single-tile images: below, at and above one block; one with room for every distance.
const SIZES: [[u32; 2]; 6] = [[1, 1], [2, 40], [17, 33], [100, 70], [19, 50], [400, 290]];

/// A name and a function for pixels. No block comes within a tenth of the threshold; otherwise the
/// rounding of the encoding would decide.
type Paint = (&'static str, fn([u32; 2], &mut Random) -> [f32; 3]);
const PAINTS: [Paint; 15] = [
    ("black", |_, _| [0.0; 3]),
    ("constant, one channel limited", |_, _| [1e-7, 2.0, 1e30]),
    ("noise", |_, random| [0; 3].map(|_| random.value().abs())),
    ("visible noise", |_, random| encoded(0.4, random, T)),
    ("noise below the threshold", |_, random| encoded(0.4, random, T / 5.0)),
    ("rows that just do not bend", |[x, _], _| bent(0.9, x)),
    ("rows that bend", |[x, _], _| bent(1.1, x)),
    ("columns that just do not bend", |[_, y], _| bent(0.9, y)),
    ("columns that bend", |[_, y], _| bent(1.1, y)),
    ("a first column", |[x, _], _| [[0.5, 0.7][usize::from(x % 16 == 0)]; 3]),
    ("a last row", |[_, y], _| [0.5, 0.5, [0.5, 0.7][usize::from(y % 16 == 15)]]),
    ("the dark end of the encoding", |[x, y], _| [1e-8 * (x % 16 + 2 * y) as f32; 3]),
    ("jumps between blocks", |[x, y], _| [(x / 16 * 3 + y / 16) as f32; 3]),
    ("a few bright pixels", |_, random| [[0.5, 9.0][usize::from(random.value() > 0.999)]; 3]),
    ("zeros of either sign", |[x, y], _| [[0.0, -0.0][(x + y) as usize % 2]; 3]),
];

#[test]
fn activity_equals_the_reference_for_every_picture_and_size() {
    let cases = PAINTS.iter().flat_map(|paint| SIZES.map(|size| (paint.0, paint.1, size)));
    let (mut clean, mut blocks) = (0, 0);
    run_cases(cases, |&(_, paint, size)| {
        let image = image(size, paint);
        let setup = Setup::whole(size);
        let found = run(&image, &setup);
        clean += found.clean.iter().filter(|&&clean| clean).count();
        blocks += found.clean.len();
        compare(&found, &image, &setup)
    });
    assert!(clean > blocks / 4 && clean < blocks * 3 / 4, "{clean} of {blocks} are clean");
}

/// A mean of 0.003 after exposure with 30 % noise bends a curve like that of `Log` by less than the
/// threshold, yet is visible.
#[test]
fn noise_in_the_dark_is_noise_whatever_the_networks_encoding() {
    let size = [100, 70];
    let noise = image(size, |_, random| [0; 3].map(|_| 0.008 * (1.0 + 0.3 * random.value())));
    let gray = image(size, |_, _| [0.008; 3]);
    let curves = TransferFunction::ALL.map(|transfer_function| Encoding {
        transfer_function,
        unbounded: true,
        ..Encoding::default()
    });
    run_cases(curves, |&encoding| {
        let setup = Setup { encoding, ..Setup::whole(size) };
        for (image, clean) in [(&noise, false), (&gray, true)] {
            let found = run(image, &setup);
            compare(&found, image, &setup)?;
            let all = found.clean.iter().all(|&flag| flag == clean);
            all.then_some(()).ok_or_else(|| format!("not all are {clean}: {:?}", found.clean))?;
        }
        Ok(())
    });
}

#[test]
fn one_firefly_or_negative_pixel_makes_one_block_active_and_a_bad_one_none() {
    let bad = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 1e30];
    let places = [[0, 0], [15, 15], [70, 31], [99, 69]];
    let cases = bad.into_iter().flat_map(|bad| places.map(|place| (bad, place)));
    run_cases(cases, |&(bad, [x, y])| {
        let mut image = image([100, 70], |_, _| [0.5; 3]);
        image.pixels_mut()[(y * 100 + x) as usize][(x % 3) as usize] = bad;
        let setup = Setup::whole([100, 70]);
        let found = run(&image, &setup);
        let noisy = u32::from(bad.is_finite());
        let found_noisy = found.clean.iter().filter(|&&clean| !clean).count();
        assert_eq!(found_noisy, noisy as usize, "{bad} at {x}, {y}");
        let here = found.map[0][y as usize / 16][x as usize / 16];
        assert_eq!(here == 0, noisy == 1, "{bad} at {x}, {y}");
        compare(&found, &image, &setup)
    });
}

#[test]
fn a_tile_sees_its_own_part_and_only_what_it_stores_is_active() {
    let image = image([200, 150], |[x, y], random| match (x / 16 + y / 16) % 5 {
        0 => [random.value().abs(); 3],
        _ => [0.5; 3],
    });
    let rect = |begin, end| Rect { begin, end };
    let tiles = [
        ([48, 32], [96, 80], rect([70, 60], [110, 81])),
        ([128, 96], [96, 96], rect([140, 100], [200, 150])),
        ([0, 0], [256, 192], rect([16, 16], [17, 17])),
    ];
    let cases = tiles.iter().flat_map(|tile| [true, false].map(|skip| (tile, skip)));
    run_cases(cases, |&(&(origin, tile, stores), skip)| {
        let placed = PlacedTile { origin, stores };
        for color in [Layout::packed(200), Layout::new(11, 1203, 4)] {
            for radius in [0, 2, 7] {
                let encoding = Encoding::default();
                let setup = Setup { placed, tile, radius, skip, color, encoding };
                compare(&run(&image, &setup), &image, &setup)?;
            }
        }
        Ok(())
    });
}

#[test]
fn distances_grow_by_one_from_what_is_active() {
    let found = three_spots();
    let seen: BTreeSet<u32> = found.map[0].iter().flatten().copied().collect();
    assert_eq!(Vec::from_iter(seen), [0, 1, 2, 3, 4, 5, 6, 7, FAR]);
    // Beyond the radius there is one more step, as far as neighbors are concerned.
    let d = |[x, y]: [usize; 2]| found.map[0][y][x].min(RADIUS + 1);
    for ([x, y], clean) in blocks().zip(&found.clean) {
        assert_eq!(d([x, y]) == 0, !clean, "{x}, {y}");
        let mut near = blocks().filter(|[u, v]| u.abs_diff(x) <= 1 && v.abs_diff(y) <= 1);
        assert!(near.all(|block| d(block).abs_diff(d([x, y])) <= 1), "{x}, {y}");
    }
}

#[test]
fn every_further_layer_has_the_minima_of_the_first() {
    let map = three_spots().map;
    assert_eq!(map.len(), LAYERS as usize);
    for (m, layer) in map.iter().enumerate() {
        let size = [layer[0].len(), layer.len()];
        assert_eq!(size, [25, 19].map(|side: usize| side.div_ceil(1 << m)), "layer {m}");
        for [x, y] in blocks().filter(|[x, y]| *x < size[0] && *y < size[1]) {
            let below = blocks().filter(|[u, v]| [u >> m, v >> m] == [x, y]);
            let least = below.map(|[u, v]| map[0][v][u]).min();
            assert_eq!(Some(layer[y][x]), least, "layer {m}, {x}, {y}");
        }
    }
}

/// An image of 25×19 blocks, three of them with a bright pixel.
fn three_spots() -> reference::Activity {
    let image = image([400, 290], |at, _| match at {
        [30, 40] | [31, 250] | [130, 5] => [9.0; 3],
        _ => [0.5; 3],
    });
    run(&image, &Setup::whole([400, 290]))
}

fn blocks() -> impl Iterator<Item = [usize; 2]> {
    (0..25 * 19).map(|i| [i % 25, i / 25])
}

#[test]
fn what_is_black_beside_noise_is_clean_only_where_albedo_and_normal_are() {
    let size = [100, 70];
    // The fourth column of blocks is noisy; two of the other six are next to it.
    let black = image(size, |[x, _], random| match x / 16 {
        3 => [random.value().abs(); 3],
        _ => [0.0; 3],
    });
    let surface = image(size, |[x, y], random| match (x / 16 + y / 16) % 2 {
        0 => [random.value(); 3],
        _ => [0.0; 3],
    });
    let images = [None, Some(&surface)];
    let cases = images.into_iter().flat_map(|albedo| images.map(|normal| (albedo, normal)));
    for (albedo, normal) in cases {
        let frame = alone(&black).albedo(albedo).normal(normal);
        let found = run_frame(&frame, &Setup::whole(size));
        let clean = found.clean.iter().filter(|&&clean| clean).count();
        let given = albedo.or(normal).is_some();
        assert_eq!(clean, if given { 24 } else { 20 }, "{:?}", found.clean);
        compare_frame(&found, &frame, &Setup::whole(size)).unwrap();
    }
}

/// One tile of an image, and the settings to run it with.
#[derive(Clone, Copy)]
struct Setup {
    placed: PlacedTile,
    tile: [u32; 2],
    radius: u32,
    skip: bool,
    color: Layout,
    encoding: Encoding,
}

impl Setup {
    fn whole(size: [u32; 2]) -> Self {
        Self {
            placed: PlacedTile { origin: [0, 0], stores: Rect { begin: [0, 0], end: size } },
            tile: size.map(|side| side.next_multiple_of(16)),
            radius: RADIUS,
            skip: true,
            color: Layout::packed(size[0]),
            encoding: Encoding::default(),
        }
    }
}

fn image([width, height]: [u32; 2], paint: fn([u32; 2], &mut Random) -> [f32; 3]) -> Image {
    let mut random = Random::new(u64::from(width * height));
    let pixel = |i| paint([i % width, i / width], &mut random);
    Image::new(width, height, (0..width * height).map(pixel).collect()).expect("the count is right")
}

/// Values whose encoding is at most `most` away from `v`.
fn encoded(v: f64, random: &mut Random, most: f64) -> [f32; 3] {
    [0; 3].map(|_| decode(v + most * f64::from(random.value())))
}

/// A parabola in each block, with second differences of `of_threshold · T`.
fn bent(of_threshold: f64, x: u32) -> [f32; 3] {
    let x = f64::from(x % 16);
    [0.2, 0.4, decode(0.5 + of_threshold * T * x * x / 2.0)]
}

fn decode(v: f64) -> f32 {
    (reference::pu_inverse(v) / f64::from(SCALE)) as f32
}

fn alone(color: &Image) -> Frame<'_> {
    Frame::new(color)
}

fn compare(found: &reference::Activity, image: &Image, setup: &Setup) -> Result<(), String> {
    compare_frame(found, &alone(image), setup)
}

fn compare_frame(
    found: &reference::Activity,
    frame: &Frame<'_>,
    setup: &Setup,
) -> Result<(), String> {
    let Setup { placed, tile, radius, skip, encoding, .. } = setup;
    let view = View { color: frame.color, albedo: frame.albedo, normal: frame.normal };
    let tile = TileOfView { origin: placed.origin, size: *tile, stores: placed.stores };
    let expected = reference::activity(&view, *encoding, SCALE, &tile, *radius, *skip);
    let message = || format!("found {found:?}, expected {expected:?}");
    (*found == expected).then_some(()).ok_or_else(message)
}

fn run(image: &Image, setup: &Setup) -> reference::Activity {
    run_frame(&alone(image), setup)
}

/// The kernels' results for the second of two tiles in the uniform buffer.
fn run_frame(frame: &Frame<'_>, setup: &Setup) -> reference::Activity {
    let context = context(Precision::F32);
    let (width, height) = frame.color.size();
    let PlacedTile { origin, stores } = setup.placed;
    let tile = Tile {
        image_size: [width, height],
        origin,
        begin: stores.begin,
        end: stores.end,
        color: setup.color,
        albedo: setup.color,
        normal: setup.color,
        ..Tile::default()
    };
    let mut tiles = vec![0; 256];
    tiles.extend(bytemuck::bytes_of(&tile));
    let upload =
        |image: &Image| buffer(context, bytemuck::cast_slice(&laid_out(image, setup.color)));
    let [albedo, normal] = [frame.albedo, frame.normal].map(|image| image.map(upload));
    let color = upload(frame.color);
    let sources = Sources {
        tiles: &buffer(context, &tiles),
        color: (&color).into(),
        albedo: albedo.as_ref().map(Into::into),
        normal: normal.as_ref().map(Into::into),
        unorm_normal: false,
        input_scale: &buffer(context, bytemuck::bytes_of(&SCALE)),
        encoding: setup.encoding,
    };
    let (activity, calls) = activity(context, &sources, setup.tile, setup.radius, setup.skip);
    submit(context, |pass| calls.iter().for_each(|call| call.record_at(pass, 256)));
    reference::Activity { clean: clean(&activity), map: map(&activity) }
}

/// The image's elements, NaN in every gap.
fn laid_out(image: &Image, layout: Layout) -> Vec<f32> {
    let (width, height) = image.size();
    let mut elements = vec![f32::NAN; layout.elements(width, height) as usize];
    for (i, pixel) in (0..).zip(image.pixels()) {
        let [x, y] = [i % width, i / width];
        let at = layout.offset + y * layout.row_stride + x * layout.pixel_stride;
        elements[at as usize..][..3].copy_from_slice(pixel);
    }
    elements
}

fn clean(activity: &Activity) -> Vec<bool> {
    let size = activity.clean.size() / 2;
    let bytes = read_back(context(Precision::F32), size, |encoder, target| {
        encoder.copy_buffer_to_buffer(&activity.clean, 0, target, 0, size);
    });
    let flags: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
    assert!(flags.iter().all(|&flag| flag <= 1), "{flags:?}");
    flags.into_iter().map(|flag| flag == 1).collect()
}

/// The part of each layer that belongs to blocks.
fn map(activity: &Activity) -> Vec<Vec<Vec<u32>>> {
    let texture = activity.map.texture();
    let (columns, rows) = (texture.width() as usize, texture.height() as usize);
    let stride = (4 * columns).next_multiple_of(256);
    let size = stride * rows * LAYERS as usize;
    let bytes = read_back(context(Precision::F32), size as u64, |encoder, buffer| {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(stride as u32),
            rows_per_image: Some(rows as u32),
        };
        let target = wgpu::TexelCopyBufferInfo { buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
    });
    let texels = |row: &[u8], count| bytemuck::pod_collect_to_vec::<_, u32>(&row[..4 * count]);
    let layer = |(m, bytes): (usize, &[u8])| {
        let [columns, rows] = [columns, rows].map(|blocks| blocks.div_ceil(1 << m));
        bytes.chunks(stride).take(rows).map(|row| texels(row, columns)).collect()
    };
    bytes.chunks(stride * rows).enumerate().map(layer).collect()
}
