//! The receptive field of an output pixel: the tile overlap that makes tiling exact.

use crate::model::operators::Interval;
use crate::model::{INPUT, Network};

/// Side in pixels of the blocks that [`reach`] and the operator `activity` count in.
pub const BLOCK: u32 = 16;

/// How far around a bad pixel the repair looks (`shaders/common/fill.wgsl`).
pub const REPAIR: i64 = 2;

/// The number of pixels by which a tile must extend beyond its stored pixels, on every side, so
/// that these equal the whole image's result bit for bit. A multiple of the network's alignment.
///
/// Walks from an aligned block of output layer by layer towards the input, tracking the interval of
/// pixels needed, and adds the pixels that bad ones are repaired from. The blocks that decide
/// whether one is clean (`activity`) lie within the halo as well.
#[must_use]
pub fn halo(network: &Network) -> u32 {
    let align = network.alignment();
    let (begin, end) = needed(network, (0, i64::from(align)))[INPUT];
    let reach = (-begin).max(end - i64::from(align)) + REPAIR;
    (reach as u32).max(constant_radius(network) * BLOCK).next_multiple_of(align)
}

/// How many blocks around a block must be the same constant for it to skip the network, counting
/// diagonal steps. A kernel pyramid gathers its color from no further, so its result is that
/// constant. For other networks, this is as far as they see, but at most three.
#[must_use]
pub fn constant_radius(network: &Network) -> u32 {
    // The logits of full resolution are needed as far as the color is gathered from.
    let reach = reach(network);
    if network.has_pyramid() { reach[network.outputs[0]] } else { reach[INPUT].min(3) }
}

/// For each [`TensorId`](crate::model::TensorId), how many blocks of 16×16 pixels around a block of
/// output the tensor must be correct in, counting diagonal steps: everything the output block needs
/// from it lies within that distance. Blocks are counted from a multiple of the network's
/// alignment.
#[must_use]
pub fn reach(network: &Network) -> Vec<u32> {
    // If the alignment exceeds a block, blocks differ in what they need.
    let blocks = (0..i64::from(network.alignment().max(BLOCK))).step_by(BLOCK as usize);
    let reaches: Vec<_> = blocks.map(|first| reach_of(network, first)).collect();
    let furthest = |tensor: usize| reaches.iter().map(|reach| reach[tensor]).max().unwrap_or(0);
    (0..network.shapes.len()).map(furthest).collect()
}

/// [`reach`] of the block whose first pixel is `first`.
fn reach_of(network: &Network, first: i64) -> Vec<u32> {
    let last = first + i64::from(BLOCK);
    let blocks = |((begin, end), level): ((i64, i64), u32)| {
        let pixels = (first - (begin << level)).max((end << level) - last).max(0);
        (pixels as u32).div_ceil(BLOCK)
    };
    let levels = network.shapes.iter().map(|shape| shape.level);
    needed(network, (first, last)).into_iter().zip(levels).map(blocks).collect()
}

/// The interval of pixels that each tensor needs for an interval of the image, each at its own
/// level. Both axes behave the same.
fn needed(network: &Network, image: Interval) -> Vec<Interval> {
    let mut needed = vec![NOTHING; network.shapes.len()];
    let levels = network.outputs.len();
    let of_outputs = if network.has_pyramid() { pyramid(levels, image) } else { vec![image] };
    for (&output, interval) in network.outputs.iter().zip(of_outputs) {
        needed[output] = interval;
    }
    for (i, layer) in network.layers.iter().enumerate().rev() {
        let output = needed[i + 1];
        for (place, &input) in layer.inputs.iter().enumerate() {
            needed[input] = hull(needed[input], (layer.op.facts().sees)(place, output));
        }
    }
    needed
}

/// The intervals of pixels that an interval of the image needs in each level of a kernel pyramid,
/// and so in its logits.
fn pyramid(levels: usize, image: Interval) -> Vec<Interval> {
    // Bilinear upsampling reads the coarser pixels on both sides of a pixel's center.
    let coarser =
        |&(begin, end): &Interval| Some(((begin - 1).div_euclid(2), end.div_euclid(2) + 1));
    let results = std::iter::successors(Some(image), coarser).take(levels);
    let mut needed: Vec<_> = results.map(|(begin, end)| (begin - 1, end + 1)).collect();
    for level in (1..levels).rev() {
        let (begin, end) = needed[level];
        needed[level - 1] = hull(needed[level - 1], (2 * begin, 2 * end));
    }
    needed
}

/// An interval without pixels.
const NOTHING: Interval = (i64::MAX, i64::MIN);

/// The smallest interval that holds both.
fn hull(a: Interval, b: Interval) -> Interval {
    (a.0.min(b.0), a.1.max(b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thesis_network_sees_96_pixels_far() {
        // An aligned block needs, to its left, 4 pixels at the bottom = 8 at level 3, plus two
        // convs there = 10, and so on: 22 at level 2, 46 at level 1, 94 at full size, plus 2 for
        // the repair.
        assert_eq!(halo(&Network::unet(9, &[4, 4, 4, 4, 4])), 96);
    }

    #[test]
    fn a_kernel_pyramid_sees_128_pixels_far_and_gathers_color_from_32() {
        // Upsampling needs pixel −1 of level 4, whose 3×3 taps reach −2: −32 at full size. From
        // there the confidence sees 94 further, plus 2 for the repair.
        let network = Network::kernel_pyramid(9, &[4, 4, 4, 4, 4]);
        assert_eq!((halo(&network), constant_radius(&network)), (128, 2));
        // Two levels: −1 at level 1 is gathered from −2, so from −4 at full size.
        assert_eq!(constant_radius(&Network::kernel_pyramid(9, &[4, 4])), 1);
    }

    #[test]
    fn a_single_level_by_hand() {
        // Two convs at full size (2), aligned at half size: begin −2 → −1, two convs: −3, pooled
        // from −6, two convs: −8; with the repair, 10: less than the block that decides about
        // skipping.
        assert_eq!(halo(&Network::unet(3, &[4, 4])), 16);
    }

    #[test]
    fn blocks_that_a_network_of_one_level_reaches_by_hand() {
        // Two convs of one pixel each, so one block: input, conv, conv, 1×1, sigmoid.
        assert_eq!(reach(&Network::unet(3, &[4])), [1, 1, 0, 0, 0]);
    }

    #[test]
    fn blocks_that_the_thesis_network_reaches_by_hand() {
        let network = Network::unet(9, &[4, 4, 4, 4, 4]);
        let reach = reach(&network);
        let of = |name: &str| {
            let layer = network.layers.iter().position(|layer| layer.name == name);
            reach[layer.expect("the layer exists") + 1]
        };
        // In pixels at full size: 0 and 2 in the last decoder level, then 2 · 2 + 2 = 6, 2 · 4 + 8
        // = 16, 2 · 8 + 16 = 32, each with the level above rounded out to whole pixels; 48 and 64
        // at the bottom; 64 + 16, 80 + 8, 88 + 4, 92 + 2 in the encoder.
        let names = ["dec_conv0b", "dec_up0", "dec_up1", "dec_up2", "dec_up3", "mid_convb"];
        assert_eq!(names.map(of), [0, 1, 1, 1, 2, 2]);
        assert_eq!(["mid_conva", "pool3", "pool2", "pool1", "pool0"].map(of), [3, 4, 5, 6, 6]);
        assert_eq!((reach[INPUT], halo(&network), constant_radius(&network)), (6, 96, 3));
    }

    #[test]
    fn no_layer_reaches_further_than_what_it_reads() {
        for widths in [&[4][..], &[4; 2], &[4; 3], &[4; 5], &[4; 6], &[4; 7]] {
            let network = Network::unet(3, widths);
            let reach = reach(&network);
            for (i, layer) in network.layers.iter().enumerate() {
                let nearer = layer.inputs.iter().all(|&input| reach[input] >= reach[i + 1]);
                assert!(nearer, "{} of {widths:?}: {reach:?}", layer.name);
            }
            assert_eq!(reach[network.last()], 0);
        }
    }
}
