//! Compares every operator on the adapter with its CPU reference.

mod accumulate;
mod accumulate_layer;
mod activity;
mod autoexposure;
mod concat;
mod conv1x1;
mod conv3x3;
mod conv_logits;
mod conv_transpose;
mod film;
mod finest;
mod gather;
mod head;
mod image;
mod input_conv;
mod input_process;
mod max_pool;
mod output_process;
mod pyramid;
mod repair;
mod self_test;
mod sequences;
mod sigmoid;
mod up_conv;
mod upsample;
