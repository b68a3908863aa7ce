//! What a network costs: multiply-accumulates per pixel of the full-size image.

use super::topology::Network;

/// Multiply-accumulates of one layer per pixel of the full-size image.
#[must_use]
pub fn layer_macs_per_pixel(network: &Network, index: usize) -> f64 {
    let layer = &network.layers[index];
    let inputs: Vec<_> = layer.inputs.iter().map(|&input| network.shapes[input].channels).collect();
    let output = network.shapes[index + 1];
    let per_output = (layer.op.facts().macs)(&inputs, output.channels) as f64;
    per_output / f64::from(1_u32 << (2 * output.level))
}

/// Multiply-accumulates of the largest layer per pixel.
#[must_use]
pub fn largest_layer_macs_per_pixel(network: &Network) -> f64 {
    (0..network.layers.len()).map(|i| layer_macs_per_pixel(network, i)).fold(0.0, f64::max)
}

/// Multiply-accumulates of the whole network per pixel.
#[must_use]
pub fn macs_per_pixel(network: &Network) -> f64 {
    (0..network.layers.len()).map(|i| layer_macs_per_pixel(network, i)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::OidnSize;

    #[test]
    fn the_thesis_network_costs_about_0_18_b_squared_thousand_macs() {
        for base in [8_usize, 16, 32, 64] {
            let widths: Vec<_> = (0..5).map(|l| base << l).collect();
            let macs = macs_per_pixel(&Network::unet(9, &widths));
            let expected = 180.0 * (base * base) as f64;
            assert!((macs / expected - 1.0).abs() < 0.07, "base {base}: {macs}");
        }
    }

    #[test]
    fn oidns_networks_cost_what_its_weights_shapes_come_to() {
        let base = [32, 32, 48, 64, 80, 96, 96, 112, 112, 96, 96, 64, 64, 64, 32];
        let small = [32, 32, 32, 32, 32, 32, 32, 64, 64, 64, 64, 64, 32, 32, 32];
        let macs = |widths: &[usize]| macs_per_pixel(&Network::oidn(9, OidnSize::Base, widths));
        assert_eq!([macs(&small), macs(&base)].map(f64::round), [62_136.0, 125_406.0]);
    }

    #[test]
    fn a_two_level_network_by_hand() {
        // 3→2, 2→2 | 2→4, 4→4 at a quarter | up 4→2, 4→2, 2→2 | 2→3
        let full = 9 * (3 * 2 + 2 * 2) + 4 * 2 + 9 * (4 * 2 + 2 * 2) + 2 * 3;
        let quarter = 9 * (2 * 4 + 4 * 4);
        let expected = f64::from(full) + f64::from(quarter) / 4.0;
        let network = Network::unet(3, &[2, 4]);
        assert!((macs_per_pixel(&network) - expected).abs() < 1e-9);
        // The decoder's first convolution, 4→2 at full size.
        assert_eq!(largest_layer_macs_per_pixel(&network), 72.0);
    }
}
