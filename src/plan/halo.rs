//! How far an output pixel sees: the tile overlap that makes tiling exact.

use crate::model::{Network, Op};

/// Pixels that a tile must reach beyond what it stores, on every side, so that what it stores
/// equals the whole image's result bit for bit. A multiple of the network's alignment.
///
/// Follows the interval of pixels that an aligned block of output needs, layer by layer
/// towards the input.
#[must_use]
pub fn halo(network: &Network) -> u32 {
    let align = i64::from(network.alignment());
    let mut needed = vec![(i64::MAX, i64::MIN); network.shapes.len()];
    needed[network.output()] = (0, align);
    for (i, layer) in network.layers.iter().enumerate().rev() {
        let (begin, end) = needed[i + 1];
        let (begin, end) = match layer.op {
            Op::Conv3x3 { .. } => (begin - 1, end + 1),
            Op::MaxPool => (begin * 2, end * 2),
            Op::ConvTranspose => (begin.div_euclid(2), (end + 1).div_euclid(2)),
            Op::Concat | Op::Conv1x1 | Op::Sigmoid => (begin, end),
        };
        for &input in &layer.inputs {
            let seen = &mut needed[input];
            *seen = (seen.0.min(begin), seen.1.max(end));
        }
    }
    let (begin, end) = needed[crate::model::INPUT];
    let reach = (-begin).max(end - align).max(0);
    (reach as u32).next_multiple_of(network.alignment())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thesis_network_sees_94_pixels_far() {
        // An aligned block needs, left of it, 4 pixels at the bottom = 8 at level 3, plus two
        // convs there = 10, and so on: 22 at level 2, 46 at level 1, 94 at full size.
        assert_eq!(halo(&Network::unet(9, &[4, 4, 4, 4, 4])), 96);
    }

    #[test]
    fn a_single_level_by_hand() {
        // Two convs at full size (2), the aligned half size: begin −2 → −1, two convs: −3,
        // pooled from −6, two convs: −8; already a multiple of 2.
        assert_eq!(halo(&Network::unet(3, &[4, 4])), 8);
    }
}
