//! The operator registry. One row per operator holds everything that weights files, plans, costs
//! and fusion need to know. `docs/adding-an-operator.md` walks through adding one.

use super::params::Params;

/// Passes all rows to the macro `$then`: module, variant of [`Op`] with its fields, facts. Code
/// elsewhere calls `reference::<module>::apply` and `ops::<module>::operator` by these names.
macro_rules! for_each_operator {
    ($then:ident) => {
        $then! {
            /// 3×3 convolution, zero padding of 1, then bias, then `max(0, ·)` if `relu`.
            conv3x3: Conv3x3 {
                /// Whether negative results become 0.
                relu: bool
            } = Facts {
                weights: Some(Axes::OutputInput([3, 3])),
                may_have_norm: true,
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
                // Each output pixel sees one of the four taps.
                macs: |inputs, output| inputs[0] * output,
                upsampling: Some(|params, _| params.clone()),
                ..POINTWISE
            };
            /// Nearest upsampling: repeats every pixel as 2×2; doubles both sides.
            upsample: Upsample = Facts {
                level: -1,
                sees: |_, output| halved(output),
                upsampling: Some(|_, channels| Params::identity(channels, 4)),
                ..POINTWISE
            };
            /// The channels of the first input, followed by those of the second.
            concat: Concat = Facts { joins: true, ..POINTWISE };
            /// `Conv3x3` over the `Concat` of the first input and the `ConvTranspose` of the
            /// second. The transposed convolution's weights come first, then the 3×3 convolution's.
            up_conv: UpConv {
                /// Output channels of the transposed convolution.
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
            /// `Conv3x3` with ReLU that keeps the number of channels, then `Conv1x1`. The 3×3
            /// convolution's weights come first.
            conv_logits: ConvLogits = Facts {
                weights: Some(Axes::Fused),
                sees: |_, output| around(output),
                macs: |inputs, output| (9 * inputs[0] + output) * inputs[0],
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
            /// The operator's module in `reference/` and `ops/`, and the stem of its shader.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant { .. } => stringify!($module),)*
                }
            }

            /// The operator's row in the registry.
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

/// An interval of pixels along one axis: the first, and one past the last.
pub type Interval = (i64, i64);

/// The facts about an operator that do not depend on its weights.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// The axes of its weight; `None` if it has no weight and no bias.
    pub weights: Option<Axes>,
    /// Whether a file may hold a batch norm after it, to be folded into its weight and bias.
    pub may_have_norm: bool,
    /// How many times both sides are halved relative to the last input: 1, 0 or −1.
    pub level: i32,
    /// The pixels of input `i` that an interval of output pixels depends on.
    pub sees: fn(usize, Interval) -> Interval,
    /// Multiply-accumulates per output pixel, given the channels of each input and of the output.
    pub macs: fn(&[usize], usize) -> usize,
    /// Whether its inputs lie side by side in the output's texture, so that no kernel has to run.
    pub joins: bool,
    /// For upsamplings by 2: the equivalent transposed convolution, from the layer's parameters and
    /// its channel count. It can be fused into the 3×3 convolution that follows.
    pub upsampling: Option<fn(&Params, usize) -> Params>,
}

/// The axis order of a weight in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// `[output][input][ky][kx]`, with the kernel's height and width.
    OutputInput([usize; 2]),
    /// `[input][output][ky][kx]`, with the kernel's height and width.
    InputOutput([usize; 2]),
    /// The axes of the operators it is fused from; never in a file.
    Fused,
}

impl Op {
    /// Whether a layer of this kind has a weight and a bias.
    #[must_use]
    pub fn has_weights(self) -> bool {
        self.facts().weights.is_some()
    }
}

/// Each output pixel depends on the same pixel of every input, without weights.
const POINTWISE: Facts = Facts {
    weights: None,
    may_have_norm: false,
    level: 0,
    sees: |_, output| output,
    macs: |_, _| 0,
    joins: false,
    upsampling: None,
};

/// One pixel more on both sides.
fn around((begin, end): Interval) -> Interval {
    (begin - 1, end + 1)
}

/// The half-resolution pixels that cover an interval.
fn halved((begin, end): Interval) -> Interval {
    (begin.div_euclid(2), (end + 1).div_euclid(2))
}
