//! The guarantees of plans, for random sizes, limits and networks.

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::halo::{constant_radius, halo, reach};
use super::memory::Footprint;
use super::storage::{Placement, Storage};
use super::tiles::{Constraints, PlacedTile, TilePlan};
use crate::model::{INPUT, Network, OidnSize, Op, TensorId};
use crate::plan::tiles::MAX_SIDE;

fn area(size: [u32; 2]) -> u64 {
    u64::from(size[0]) * u64::from(size[1])
}

/// Sizes up to the largest; if both sides are long, tiles must be large.
fn sizes() -> impl Strategy<Value = [u32; 2]> {
    let (long, short) = (1..=MAX_SIDE, 1_u32..300);
    prop_oneof![
        (1_u32..1000, 1_u32..1000).prop_map(<[u32; 2]>::from),
        (long.clone(), short.clone()).prop_map(<[u32; 2]>::from),
        (short, long).prop_map(<[u32; 2]>::from),
    ]
}

/// Limits from unsatisfiable to none.
fn limits() -> impl Strategy<Value = Constraints> {
    let sides = prop_oneof![0_u32..1000, Just(16384), Just(u32::MAX), any::<u32>()];
    let pixels = prop_oneof![0_u64..1 << 20, Just(u64::MAX), any::<u64>()];
    (1_u32..=8, 0_u32..12, sides, pixels).prop_map(|(level, halo, max_side, max_pixels)| {
        let alignment = 1 << level;
        Constraints { alignment, halo: halo * alignment, max_side, max_pixels }
    })
}

/// The smallest tile that satisfies both axes.
fn smallest(size: [u32; 2], limits: &Constraints) -> [u32; 2] {
    let Constraints { alignment, halo, .. } = *limits;
    size.map(|side| side.next_multiple_of(alignment).min(2 * halo + alignment))
}

fn fits(tile: [u32; 2], limits: &Constraints) -> bool {
    tile[0].max(tile[1]) <= limits.max_side && area(tile) <= limits.max_pixels
}

/// Along one axis, the stored spans follow one another from the first pixel to the last, and each
/// lies a halo inside its tile unless the image ends there.
fn check_axis(axis: usize, line: &[PlacedTile], side: u32, tile: u32, limits: &Constraints) {
    let Constraints { alignment, halo, .. } = *limits;
    let padded = side.next_multiple_of(alignment);
    let mut next = 0;
    for placed in line {
        let (from, to) = (placed.origin[axis], placed.origin[axis] + tile);
        let (begin, end) = (placed.stores.begin[axis], placed.stores.end[axis]);
        assert!(begin == next && begin < end, "{placed:?} after {next}");
        assert!(from % alignment == 0 && to <= padded, "{placed:?}");
        assert!(from <= begin && end <= to, "{placed:?} stores beyond itself");
        assert!(from == 0 || from + halo <= begin, "{placed:?} sees too little before");
        assert!(to == padded || end + halo <= to, "{placed:?} sees too little behind");
        next = end;
    }
    assert_eq!(next, side);
}

fn check_plan(size: [u32; 2], plan: &TilePlan, limits: &Constraints) {
    assert!(fits(plan.tile, limits) && plan.tile.iter().all(|side| side % limits.alignment == 0));
    let first = plan.tiles[0];
    let columns = plan.tiles.iter().take_while(|t| t.origin[1] == first.origin[1]).count();
    let top: Vec<_> = plan.tiles[..columns].to_vec();
    let left: Vec<_> = plan.tiles.iter().step_by(columns).copied().collect();
    check_axis(0, &top, size[0], plan.tile[0], limits);
    check_axis(1, &left, size[1], plan.tile[1], limits);
    // Every other tile lies at the intersection of its row and column.
    assert_eq!(plan.tiles.len(), top.len() * left.len());
    for (tile, (row, column)) in
        plan.tiles.iter().zip(left.iter().flat_map(|row| top.iter().map(move |top| (row, top))))
    {
        assert_eq!(tile.origin, [column.origin[0], row.origin[1]]);
        assert_eq!(tile.stores.begin, [column.stores.begin[0], row.stores.begin[1]]);
        assert_eq!(tile.stores.end, [column.stores.end[0], row.stores.end[1]]);
    }
}

proptest! {
    #[test]
    fn a_plan_keeps_all_limits_and_stores_every_pixel_once(size in sizes(), limits in limits()) {
        match TilePlan::new(size, &limits) {
            Some(plan) => check_plan(size, &plan, &limits),
            None => prop_assert!(!fits(smallest(size, &limits), &limits)),
        }
    }

    #[test]
    fn the_smallest_tile_that_there_can_be_is_always_accepted(size in sizes(), limits in limits()) {
        let tile = smallest(size, &limits);
        let max_side = tile[0].max(tile[1]);
        let limits = Constraints { max_side, max_pixels: area(tile), ..limits };
        let plan = TilePlan::new(size, &limits);
        check_plan(size, &plan.expect("the smallest tile fits"), &limits);
    }

    #[test]
    fn the_largest_images_are_planned(
        width in 60_000..=MAX_SIDE, height in 60_000..=MAX_SIDE, max_pixels in 1_u64 << 18..1 << 34,
        whole in any::<bool>(),
    ) {
        // As one tile, the largest image has 2³² pixels.
        let size = if whole { [MAX_SIDE; 2] } else { [width, height] };
        let (max_side, max_pixels) = if whole { (u32::MAX, u64::MAX) } else { (16384, max_pixels) };
        let limits = Constraints { alignment: 16, halo: 96, max_side, max_pixels };
        check_plan(size, &TilePlan::new(size, &limits).unwrap(), &limits);
    }

    #[test]
    fn short_dispatches_never_ask_for_more_than_before(limits in limits(), macs in any::<f64>()) {
        let short = limits.with_short_dispatches(macs.abs());
        prop_assert!(short.max_pixels <= limits.max_pixels);
        let smallest = u64::from(2 * limits.halo + limits.alignment).pow(2);
        prop_assert!(short.max_pixels >= smallest.min(limits.max_pixels));
    }
}

proptest! {
    #[test]
    fn no_pixel_more_fits_the_memory_and_none_less(
        tensors in 1_u64..1 << 20, images in 0_u64..100, least in 0_u64..1 << 26,
        picture in 0_u64..1 << 40, bytes in 0_u64..1 << 44,
    ) {
        let (per_pixel, buffer_per_pixel) = (tensors + images, images);
        let footprint = Footprint { per_pixel, buffer_per_pixel, buffer_least: least, picture };
        let most = footprint.most_pixels(bytes);
        prop_assert!(footprint.bytes(most) <= bytes || most == 0, "{most} pixels do not fit");
        prop_assert!(footprint.bytes(most + 1) > bytes, "more than {most} pixels fit");
    }

    #[test]
    fn a_memory_without_bounds_is_no_error(tensors in 1_u64..1 << 20, bytes in any::<u64>()) {
        let per_pixel = tensors + 24;
        let footprint = Footprint { per_pixel, buffer_per_pixel: 24, buffer_least: 1 << 26, picture: 0 };
        prop_assert!(footprint.most_pixels(bytes) <= bytes / per_pixel);
    }
}

fn networks() -> impl Strategy<Value = Network> {
    let widths = prop::collection::vec(1_usize..40, 1..=8);
    let unet = (1_usize..10, widths).prop_map(|(inputs, widths)| Network::unet(inputs, &widths));
    let widths = prop::collection::vec(1_usize..40, 2..=5);
    let pyramid = (1_usize..10, widths)
        .prop_map(|(inputs, widths)| Network::kernel_pyramid(inputs, &widths).demodulating());
    let oidn = |size: OidnSize| {
        let widths = prop::collection::vec(1_usize..40, size.convolutions() - 1);
        (1_usize..10, widths).prop_map(move |(i, widths)| Network::oidn(i, size, &widths))
    };
    prop_oneof![unet, pyramid, oidn(OidnSize::Base), oidn(OidnSize::Large)]
}

/// The pixels of each tensor that some output pixels depend on along one axis, listed one by one.
fn seen(network: &Network, output: std::ops::Range<i64>) -> Vec<BTreeSet<i64>> {
    let mut seen = vec![BTreeSet::new(); network.shapes.len()];
    if network.has_pyramid() {
        for (&logits, pixels) in network.outputs.iter().zip(gathered(network.outputs.len(), output))
        {
            seen[logits] = pixels;
        }
    } else {
        seen[network.outputs[0]] = output.collect();
    }
    for (i, layer) in network.layers.iter().enumerate().rev() {
        let of = |x: i64| match layer.op {
            Op::Conv3x3 { .. } => vec![x - 1, x, x + 1],
            Op::MaxPool => vec![2 * x, 2 * x + 1],
            Op::ConvTranspose | Op::Upsample => vec![x.div_euclid(2)],
            Op::Concat | Op::Conv1x1 | Op::Sigmoid => vec![x],
            Op::UpConv { .. } | Op::ConvLogits => unreachable!("these networks are not fused"),
        };
        let read: BTreeSet<_> = seen[i + 1].iter().copied().flat_map(of).collect();
        layer.inputs.iter().for_each(|&input| seen[input].extend(&read));
    }
    seen
}

/// The pixels of each level of a kernel pyramid that some output pixels depend on.
fn gathered(levels: usize, output: std::ops::Range<i64>) -> Vec<BTreeSet<i64>> {
    let mut result: BTreeSet<_> = output.collect();
    let mut seen = Vec::new();
    for _ in 0..levels {
        seen.push(result.iter().flat_map(|x| [x - 1, *x, x + 1]).collect::<BTreeSet<_>>());
        // The pixels of half the resolution on both sides of a pixel's center.
        result =
            result.iter().flat_map(|x| [(x - 1).div_euclid(2), (x + 1).div_euclid(2)]).collect();
    }
    for level in (1..levels).rev() {
        let finer: Vec<_> = seen[level].iter().flat_map(|x| [2 * x, 2 * x + 1]).collect();
        seen[level - 1].extend(finer);
    }
    seen
}

/// Whether two tensors share any bytes.
fn overlap(a: &Placement, b: &Placement) -> bool {
    let ends = [a, b].map(|place| place.first_quad + place.quads);
    a.slot == b.slot && a.first_quad < ends[1] && b.first_quad < ends[0]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_halo_is_what_an_aligned_block_sees_around_it(network in networks()) {
        let align = i64::from(network.alignment());
        let input = &seen(&network, 0..align)[INPUT];
        // Adds the two pixels from which bad ones are filled. The halo covers at least the blocks
        // that decide whether this one is skipped.
        let blocks = 16 * i64::from(constant_radius(&network));
        let first = (*input.first().unwrap() - 2).min(-blocks);
        let last = (*input.last().unwrap() + 2).max(align - 1 + blocks);
        let halo = i64::from(halo(&network));
        prop_assert!(-halo <= first && last < align + halo, "{first}..={last} and {halo}");
        let less = halo - align;
        prop_assert!(first < -less || last >= align + less, "{halo} is too much");
    }

    #[test]
    fn blocks_within_reach_hold_all_that_a_block_sees(network in networks(), nth in 0_i64..64) {
        let first = nth * 16;
        let reach = reach(&network);
        for (tensor, pixels) in seen(&network, first..first + 16).iter().enumerate() {
            let level = network.shapes[tensor].level;
            let (side, pixels) = (16 * i64::from(reach[tensor]), pixels.iter());
            for (begin, end) in pixels.map(|x| (x << level, (x + 1) << level)) {
                prop_assert!(begin >= first - side && end <= first + 16 + side, "tensor {tensor}");
            }
        }
    }

    #[test]
    fn no_tensor_is_written_over_while_it_is_read(network in networks(), input_quads in 1_u32..10) {
        let least = network.shapes[INPUT].channels.div_ceil(4) as u32;
        let Storage { slots, placements } = Storage::plan(&network, input_quads.max(least));
        let last_read = |t: TensorId| network.layers.iter().rposition(|l| l.inputs.contains(&t));
        for (tensor, place) in placements.iter().enumerate() {
            let slot = slots[place.slot];
            prop_assert_eq!(slot.level, network.shapes[tensor].level);
            prop_assert!(place.quads > 0 && place.first_quad + place.quads <= slot.quads);
            let channels = 4 * place.quads as usize;
            prop_assert!(tensor == INPUT || network.shapes[tensor].channels <= channels);
        }
        // Concat writes nothing: its inputs already lie side by side.
        for (i, _) in network.layers.iter().enumerate().filter(|(_, l)| l.op != Op::Concat) {
            for read in (0..=i).filter(|&t| last_read(t) >= Some(i)) {
                prop_assert!(!overlap(&placements[i + 1], &placements[read]), "{i} over {read}");
            }
        }
    }

    #[test]
    fn bytes_grow_with_the_pixels_and_never_overflow(
        widths in prop::collection::vec(1_usize..=1024, 2..=8), texel in 1_u64..=16,
        columns in 1_u32..=256, rows in 1_u32..=256,
    ) {
        let network = Network::unet(9, &widths);
        let storage = Storage::plan(&network, 3);
        let align = network.alignment();
        let block = storage.bytes(align, align, texel);
        let tile = storage.bytes(columns * align, rows * align, texel);
        prop_assert_eq!(tile, block * area([columns, rows]));
        prop_assert!(storage.bytes(MAX_SIDE, MAX_SIDE, texel) >= tile);
    }
}
