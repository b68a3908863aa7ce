//! Weights of one layer.

/// Weight and bias of one layer, with its batch norm folded in.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Params {
    /// Convolution: `[output][input][ky][kx]`; transposed: `[input][output][ky][kx]`.
    pub weight: Vec<f32>,
    /// One value per output channel.
    pub bias: Vec<f32>,
}

impl Params {
    /// These weights and biases with those of the next layer appended.
    #[must_use]
    pub(super) fn followed_by(mut self, next: Self) -> Self {
        self.weight.extend(next.weight);
        self.bias.extend(next.bias);
        self
    }

    /// The identity on `channels` channels, at each of `taps` taps.
    #[must_use]
    pub fn identity(channels: usize, taps: usize) -> Self {
        let same = |i: usize| i / taps / channels == i / taps % channels;
        let weight = (0..channels * channels * taps).map(|i| f32::from(u8::from(same(i))));
        Self { weight: weight.collect(), bias: vec![0.0; channels] }
    }
}
