//! Every operator on the adapter against its CPU reference.

#[path = "../common/mod.rs"]
mod common;

mod concat;
mod conv1x1;
mod conv3x3;
mod conv_transpose;
mod max_pool;
mod sigmoid;
