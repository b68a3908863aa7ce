//! The networks of Open Image Denoise as layer tables.

use super::operators::Op;
use super::topology::Network;

/// The sizes of Open Image Denoise's networks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OidnSize {
    /// 16 convolutions: the base and small networks, which differ only in their widths.
    Base,
    /// 19 convolutions.
    Large,
}

/// Convolution names of the encoder's five levels and the decoder's four.
type OidnBlocks = ([&'static [&'static str]; 5], [&'static [&'static str]; 4]);

const OIDN_BASE: OidnBlocks = (
    [
        &["enc_conv0", "enc_conv1"],
        &["enc_conv2"],
        &["enc_conv3"],
        &["enc_conv4"],
        &["enc_conv5a", "enc_conv5b"],
    ],
    [
        &["dec_conv4a", "dec_conv4b"],
        &["dec_conv3a", "dec_conv3b"],
        &["dec_conv2a", "dec_conv2b"],
        &["dec_conv1a", "dec_conv1b", "dec_conv0"],
    ],
);

const OIDN_LARGE: OidnBlocks = (
    [
        &["enc_conv1a", "enc_conv1b"],
        &["enc_conv2a", "enc_conv2b"],
        &["enc_conv3a", "enc_conv3b"],
        &["enc_conv4a", "enc_conv4b"],
        &["enc_conv5a", "enc_conv5b"],
    ],
    [
        &["dec_conv4a", "dec_conv4b"],
        &["dec_conv3a", "dec_conv3b"],
        &["dec_conv2a", "dec_conv2b"],
        &["dec_conv1a", "dec_conv1b", "dec_conv1c"],
    ],
);

impl OidnSize {
    fn blocks(self) -> OidnBlocks {
        match self {
            Self::Base => OIDN_BASE,
            Self::Large => OIDN_LARGE,
        }
    }

    /// The names of the convolutions, first to last.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        let (encoder, decoder) = self.blocks();
        encoder.into_iter().chain(decoder).flatten().copied()
    }

    /// The number of convolutions.
    #[must_use]
    pub fn convolutions(self) -> usize {
        self.names().count()
    }
}

impl Network {
    /// The network of Open Image Denoise. Each encoder level has convolutions and a pool, the
    /// bottom has convolutions, and each decoder level has an upsampling, the skip and
    /// convolutions. The skips are the pools' outputs, and the network's input at full resolution.
    /// `widths` are the output channels of all convolutions in order, except the last, which has 3.
    ///
    /// # Panics
    /// Panics if the number of widths is not [`OidnSize::convolutions`] less one.
    #[must_use]
    pub fn oidn(in_channels: usize, size: OidnSize, widths: &[usize]) -> Self {
        assert_eq!(widths.len() + 1, size.convolutions(), "widths of {size:?}");
        let mut net = Self::empty(in_channels);
        let mut widths = widths.iter().copied().chain([3]);
        let mut convs = |net: &mut Self, names: &[&str]| {
            for (&name, width) in names.iter().zip(&mut widths) {
                net.push(name.into(), Op::Conv3x3 { relu: true }, &[], width);
            }
            net.shapes[net.last()].channels
        };
        let ([levels @ .., bottom], decoder) = size.blocks();
        let mut skips = Vec::new();
        for (l, names) in (1..).zip(levels) {
            skips.push(net.last());
            let width = convs(&mut net, names);
            net.push(format!("pool{l}"), Op::MaxPool, &[], width);
        }
        let mut width = convs(&mut net, bottom);
        for (l, (names, skip)) in (1..=4).rev().zip(decoder.iter().zip(skips.into_iter().rev())) {
            let up = net.push(format!("upsample{l}"), Op::Upsample, &[], width);
            let both = net.shapes[skip].channels + width;
            net.push(format!("concat{l}"), Op::Concat, &[skip, up], both);
            width = convs(&mut net, names);
        }
        net.outputs = vec![net.last()];
        net
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::TensorId;

    #[test]
    fn the_networks_of_oidn_have_the_parameters_that_they_are_known_for() {
        let base = [32, 32, 48, 64, 80, 96, 96, 112, 112, 96, 96, 64, 64, 64, 32];
        let small = [32, 32, 32, 32, 32, 32, 32, 64, 64, 64, 64, 64, 32, 32, 32];
        let large =
            [64, 64, 96, 96, 128, 128, 192, 192, 256, 256, 192, 192, 128, 128, 96, 96, 64, 64];
        let parameters = |size, widths: &[usize]| -> usize {
            let net = Network::oidn(9, size, widths);
            assert_eq!((net.alignment(), net.shapes[net.last()].channels), (16, 3));
            let convs = (1..).zip(&net.layers).filter(|(_, layer)| layer.op.has_weights());
            let channels = |t: TensorId| net.shapes[t].channels;
            convs.map(|(o, l)| (9 * channels(l.inputs[0]) + 1) * channels(o)).sum()
        };
        assert_eq!(parameters(OidnSize::Base, &small), 320_035);
        assert_eq!(parameters(OidnSize::Base, &base), 919_811);
        assert_eq!(parameters(OidnSize::Large, &large), 3_848_387);
    }
}
