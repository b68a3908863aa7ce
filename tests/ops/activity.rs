use std::collections::BTreeSet;

use wgdenoise::internals::ops::activity::{Activity, FAR, LAYERS, activity};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::plan::tiles::PlacedTile;
use wgdenoise::internals::reference::{self, TileOfImage};
use wgdenoise::{Image, Precision, Rect, wgpu};

use wgdenoise_testing::gpu::{buffer, context, read_back, submit};
use wgdenoise_testing::{Random, run_cases};

const RADIUS: u32 = 7;

/// Sizes of single-tile images: below, at and above one block, and one with room for every
/// distance.
const SIZES: [[u32; 2]; 6] = [[1, 1], [2, 40], [17, 33], [100, 70], [19, 50], [400, 290]];

/// The name of a pattern and a function for its pixels.
type Paint = (&'static str, fn([u32; 2], &mut Random) -> [f32; 3]);
const PAINTS: [Paint; 13] = [
    ("black", |_, _| [0.0; 3]),
    ("constant over all magnitudes", |_, _| [1e-42, -2.0, f32::MAX]),
    ("zeros of either sign", |[x, y], _| [[0.0, -0.0][(x + y) as usize % 2]; 3]),
    ("nothing finite", |_, _| [0.5, f32::INFINITY, 0.5]),
    ("noise", |_, random| [0; 3].map(|_| random.value().abs())),
    ("noise of 0.01 %", |_, random| [0; 3].map(|_| 0.7 * (1.0 + 1e-4 * random.value()))),
    ("a ramp", |[x, y], _| [0.5, 0.5, 0.5 + 1e-6 * (x + y) as f32]),
    ("denormal steps", |[x, _], _| [f32::from_bits(x); 3]),
    ("a few bright pixels", |_, random| [[0.5, 9.0][usize::from(random.value() > 0.999)]; 3]),
    ("a few bad pixels", |[x, y], _| [[0.5, f32::NAN][usize::from((x, y) == (18, 1))]; 3]),
    ("jumps between blocks", |[x, y], _| [(x / 16 * 3 + y / 16) as f32; 3]),
    ("one jump", |[x, _], _| [[0.2, 0.5][(x / 160).min(1) as usize]; 3]),
    ("noise between bars", |[_, y], random| match y {
        96..=200 => [random.value().abs(); 3],
        _ => [0.0; 3],
    }),
];

#[test]
fn activity_equals_the_reference_for_every_picture_size_and_radius() {
    let radii = [None, Some(0), Some(1), Some(3)];
    let cases = PAINTS.iter().flat_map(|paint| {
        SIZES.into_iter().flat_map(move |size| radii.map(|r| (paint.0, paint.1, size, r)))
    });
    let (mut clean, mut blocks) = (0, 0);
    run_cases(cases, |&(_, paint, size, constant_radius)| {
        let image = image(size, paint);
        let setup = Setup { constant_radius, ..Setup::whole(size) };
        let found = run(&image, &setup);
        clean += found.clean.iter().filter(|&&clean| clean).count();
        blocks += found.clean.len();
        compare(&found, &image, &setup)
    });
    assert!(clean > blocks / 5 && clean < blocks * 4 / 5, "{clean} of {blocks} are clean");
}

/// Nearly constant areas must run through the network: a threshold would show as squares.
#[test]
fn noise_of_any_contrast_and_ramps_are_never_skipped() {
    let size = [400, 290];
    run_cases([1e-2_f32, 1e-3, 1e-4, 1e-5], |&contrast| {
        let mut random = Random::new(3);
        let mut noise = |v: f32| [0; 3].map(|_| v * (1.0 + contrast * random.value()));
        let sky = (0..400 * 290).map(|_| noise(0.7)).collect();
        let ramp = (0..400 * 290_u32).map(|i| [0.5 + contrast * (i % 400) as f32; 3]).collect();
        for pixels in [sky, ramp] {
            let image = Image::new(size[0], size[1], pixels).expect("the count is right");
            let found = run(&image, &Setup::whole(size));
            let clean = found.clean.iter().filter(|&&clean| clean).count();
            if clean > 0 {
                return Err(format!("{clean} blocks are clean"));
            }
        }
        Ok(())
    });
}

/// A 400×290 image with letterbox bars of six block rows, of which the three next to the picture
/// are not clean.
#[test]
fn letterboxes_are_skipped_up_to_the_radius_around_the_picture() {
    let bars = image([400, 290], PAINTS[12].1);
    let found = run(&bars, &Setup::whole([400, 290]));
    let rows: Vec<_> = found.clean.chunks(25).map(|row| row.iter().all(|&clean| clean)).collect();
    let expected: Vec<_> = (0..19).map(|row| !(3..16).contains(&row)).collect();
    assert_eq!(rows, expected);
}

#[test]
fn one_odd_pixel_makes_all_blocks_within_the_radius_active() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.5_f32.next_up(), 1e30];
    let places = [[0, 0], [15, 15], [170, 131], [399, 289]];
    let cases = odd.into_iter().flat_map(|odd| places.map(|place| (odd, place)));
    run_cases(cases, |&(odd, [x, y])| {
        let mut image = image([400, 290], |_, _| [0.5; 3]);
        image.pixels_mut()[(y * 400 + x) as usize][(x % 3) as usize] = odd;
        let found = run(&image, &Setup::whole([400, 290]));
        let near =
            |[u, v]: [usize; 2]| u.abs_diff(x as usize / 16).max(v.abs_diff(y as usize / 16)) <= 3;
        let same = blocks().zip(&found.clean).all(|(block, &clean)| clean != near(block));
        same.then_some(()).ok_or_else(|| format!("{:?}", found.clean))
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
    let radii = [None, Some(0), Some(1)];
    let cases = tiles.iter().flat_map(|tile| radii.map(|constant_radius| (tile, constant_radius)));
    run_cases(cases, |&(&(origin, tile, stores), constant_radius)| {
        let placed = PlacedTile { origin, stores };
        for color in [Layout::packed(200), Layout::new(11, 1203, 4)] {
            for radius in [0, 2, 7] {
                let setup = Setup { placed, tile, radius, constant_radius, color };
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
    // As seen by neighbors, distances beyond the radius are one step more than it.
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

/// An image of 25×19 blocks, three of which have a bright pixel.
fn three_spots() -> reference::Activity {
    let image = image([400, 290], |at, _| match at {
        [30, 40] | [31, 250] | [130, 5] => [9.0; 3],
        _ => [0.5; 3],
    });
    run(&image, &Setup { constant_radius: Some(0), ..Setup::whole([400, 290]) })
}

fn blocks() -> impl Iterator<Item = [usize; 2]> {
    (0..25 * 19).map(|i| [i % 25, i / 25])
}

/// One tile of an image, and its settings.
#[derive(Clone, Copy)]
struct Setup {
    placed: PlacedTile,
    tile: [u32; 2],
    radius: u32,
    constant_radius: Option<u32>,
    color: Layout,
}

impl Setup {
    fn whole(size: [u32; 2]) -> Self {
        Self {
            placed: PlacedTile { origin: [0, 0], stores: Rect { begin: [0, 0], end: size } },
            tile: size.map(|side| side.next_multiple_of(16)),
            radius: RADIUS,
            constant_radius: Some(3),
            color: Layout::packed(size[0]),
        }
    }
}

fn image([width, height]: [u32; 2], paint: fn([u32; 2], &mut Random) -> [f32; 3]) -> Image {
    let mut random = Random::new(u64::from(width * height));
    let pixel = |i| paint([i % width, i / width], &mut random);
    Image::new(width, height, (0..width * height).map(pixel).collect()).expect("the count is right")
}

fn compare(found: &reference::Activity, image: &Image, setup: &Setup) -> Result<(), String> {
    let Setup { placed, tile, radius, constant_radius, .. } = setup;
    let tile = TileOfImage { origin: placed.origin, size: *tile, stores: placed.stores };
    let expected = reference::activity(image, &tile, *radius, *constant_radius);
    let message = || format!("found {found:?}, expected {expected:?}");
    (*found == expected).then_some(()).ok_or_else(message)
}

/// The kernels' results for the second of two tiles in the uniform buffer.
fn run(image: &Image, setup: &Setup) -> reference::Activity {
    let context = context(Precision::F32);
    let (width, height) = image.size();
    let PlacedTile { origin, stores } = setup.placed;
    let tile = Tile {
        image_size: [width, height],
        origin,
        begin: stores.begin,
        end: stores.end,
        color: setup.color,
        ..Tile::default()
    };
    let mut tiles = vec![0; 256];
    tiles.extend(bytemuck::bytes_of(&tile));
    let tiles = buffer(context, &tiles);
    let color = buffer(context, bytemuck::cast_slice(&laid_out(image, setup.color)));
    let Setup { tile, radius, constant_radius, .. } = *setup;
    let (activity, calls) =
        activity(context, &tiles, (&color).into(), tile, radius, constant_radius);
    submit(context, |pass| calls.iter().for_each(|call| call.record_at(pass, 256)));
    reference::Activity { clean: clean(&activity), map: map(&activity) }
}

/// The image's elements, with NaN in every gap.
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

/// The part of each layer that holds blocks.
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
