//! The registry of operators: one row each, which holds all that weights files, plans, costs and
//! fusing need to know. `docs/adding-an-operator.md` walks through a new one.

use super::params::Params;

/// Passes every row on to the macro `$then`: module, variant of [`Op`] with its fields, facts.
/// The floors above call the module of that name: `reference::<module>::apply` and
/// `ops::<module>::operator`.
macro_rules! for_each_operator {
    ($then:ident) => {
        $then! {
            /// 3×3 convolution, zero padding of 1, then bias, then `max(0, ·)` if `relu`.
            conv3x3: Conv3x3 {
                /// Whether negative results become 0.
                relu: bool
            } = Facts {
                weights: Some(Axes::OutputInput([3, 3])),
                sees: |_, output| around(output),
                macs: |inputs, output| 9 * inputs[0] * output,
                ..POINTWISE
            };
            /// Maximum over 2×2 pixels; halves both sides.
            max_pool: MaxPool = Facts {
                level: 1,
                sees: |_, (begin, end)| (2 * begin, 2 * end),
                ..POINTWISE
            };
            /// Transposed convolution, 2×2 kernel, stride 2, plus bias; doubles both sides.
            conv_transpose: ConvTranspose = Facts {
                weights: Some(Axes::InputOutput([2, 2])),
                level: -1,
                sees: |_, output| halved(output),
                // Of the four taps each output pixel sees one.
                macs: |inputs, output| inputs[0] * output,
                upsampling: Some(|params, _| params.clone()),
                ..POINTWISE
            };
            /// Every pixel four times, as 2×2; doubles both sides.
            upsample: Upsample = Facts {
                level: -1,
                sees: |_, output| halved(output),
                upsampling: Some(|_, channels| Params::identity(channels, 4)),
                ..POINTWISE
            };
            /// The channels of the first input, then those of the second.
            concat: Concat = Facts { joins: true, ..POINTWISE };
            /// `Conv3x3` over `Concat` of the first input and `ConvTranspose` of the second. Its
            /// weights are those of the transposed convolution, then those of the 3×3 convolution.
            up_conv: UpConv {
                /// Channels that the transposed convolution makes.
                ups: usize,
                /// Whether negative results become 0.
                relu: bool
            } = Facts {
                weights: Some(Axes::Fused),
                level: -1,
                sees: |input, output| match input {
                    0 => around(output),
                    _ => halved(around(output)),
                },
                macs: |inputs, output| (9 * inputs[0] + 4 * inputs[1]) * output,
                ..POINTWISE
            };
            /// 1×1 convolution plus bias.
            conv1x1: Conv1x1 = Facts {
                weights: Some(Axes::OutputInput([1, 1])),
                macs: |inputs, output| inputs[0] * output,
                ..POINTWISE
            };
            /// `1 / (1 + exp(−x))`.
            sigmoid: Sigmoid = POINTWISE;
        }
    };
}
pub(crate) use for_each_operator;

macro_rules! define_op {
    ($($(#[$doc:meta])* $module:ident: $variant:ident $({
        $($(#[$field_doc:meta])* $field:ident: $type:ty),*
    })? = $facts:expr;)*) => {
        /// What a layer computes.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Op {
            $($(#[$doc])* $variant $({ $($(#[$field_doc])* $field: $type),* })?,)*
        }

        impl Op {
            /// The module of the operator in `reference/` and `ops/`, and the stem of its shader.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant { .. } => stringify!($module),)*
                }
            }

            /// What the registry says of it.
            #[must_use]
            pub fn facts(self) -> Facts {
                match self {
                    $(Self::$variant { .. } => $facts,)*
                }
            }

            /// The names of all operators.
            pub const NAMES: &[&str] = &[$(stringify!($module)),*];
        }
    };
}
for_each_operator!(define_op);

/// An interval of pixels along an axis: the first, and one past the last.
pub type Interval = (i64, i64);

/// What is known of an operator, whatever its weights.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// The axes of its weight; `None` if it has neither weight nor bias.
    pub weights: Option<Axes>,
    /// By how much both sides are halved, counted from the last input: 1, 0 or −1.
    pub level: i32,
    /// The pixels of input `i` that an interval of output pixels depends on.
    pub sees: fn(usize, Interval) -> Interval,
    /// Multiply-accumulates per output pixel, from the channels of each input and of the output.
    pub macs: fn(&[usize], usize) -> usize,
    /// Whether its inputs lie side by side in the output's texture, so that no kernel runs.
    pub joins: bool,
    /// For upsamplings by 2: the same as a transposed convolution, from the layer's parameters and
    /// its number of channels. These can be fused into the 3×3 convolution that follows.
    pub upsampling: Option<fn(&Params, usize) -> Params>,
}

/// The order of a weight's axes in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// `[output][input][ky][kx]`, with the kernel's height and width.
    OutputInput([usize; 2]),
    /// `[input][output][ky][kx]`, likewise.
    InputOutput([usize; 2]),
    /// Those of the operators that it is fused from: no file has it.
    Fused,
}

impl Op {
    /// Whether a layer of this kind has a weight and a bias.
    #[must_use]
    pub fn has_weights(self) -> bool {
        self.facts().weights.is_some()
    }
}

/// Every output pixel depends on the same pixel of every input, without weights.
const POINTWISE: Facts = Facts {
    weights: None,
    level: 0,
    sees: |_, output| output,
    macs: |_, _| 0,
    joins: false,
    upsampling: None,
};

/// A pixel more on both sides.
fn around((begin, end): Interval) -> Interval {
    (begin - 1, end + 1)
}

/// The pixels of half the resolution that cover an interval.
fn halved((begin, end): Interval) -> Interval {
    (begin.div_euclid(2), (end + 1).div_euclid(2))
}
