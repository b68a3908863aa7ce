//! Builds the operator for a layer of the network.

use super::operator::{LayerRequest, Operator};
use super::{
    concat, conv_logits, conv_transpose, conv1x1, conv3x3, max_pool, sigmoid, up_conv, upsample,
};
use crate::model::Op;
use crate::model::operators::for_each_operator;

macro_rules! define_build {
    ($($(#[$doc:meta])* $module:ident: $variant:ident $({
        $($(#[$field_doc:meta])* $field:ident: $type:ty),*
    })? = $facts:expr;)*) => {
        /// The operator of a layer, with its kernel compiled and its weights uploaded.
        #[must_use]
        pub fn build(op: Op, layer: &LayerRequest<'_>) -> Box<dyn Operator> {
            match op {
                $(Op::$variant { $($($field),*)? } => {
                    Box::new($module::operator(layer $($(, $field)*)?))
                })*
            }
        }
    };
}
for_each_operator!(define_build);
