//! The host side of the operators: their kernels, for the planner, the tests and the benches. Each
//! operator has a shader and a CPU function of the same name.

pub mod accumulate;
pub mod accumulate_layer;
pub mod activity;
pub mod autoexposure;
pub mod build;
pub mod channel_map;
pub mod concat;
pub mod conv1x1;
pub mod conv3x3;
pub mod conv_logits;
pub mod conv_transpose;
pub mod convolution;
pub mod demodulation;
pub mod elementwise;
pub mod gather;
pub mod head;
pub mod image;
pub mod input_conv;
pub mod input_process;
pub mod matrix;
pub mod max_pool;
pub mod need;
pub mod operator;
pub mod output_process;
pub mod packing;
pub mod pyramid;
pub mod sigmoid;
pub mod simd;
pub mod tile;
mod tiled_weights;
pub mod up_conv;
pub mod upsample;

use self::convolution::Tiling;
use self::demodulation::{demodulating, reading_albedo};
use self::image::{Element, ImageFormat};
use crate::gpu::kernel::KernelSpec;
use crate::gpu::matrix_shape::Factor::{F16, F32};
use crate::gpu::matrix_shape::MatrixShape;

/// All shader variants, for the test that compares declarations with sources.
#[must_use]
pub fn all_specs() -> Vec<KernelSpec> {
    let mut specs = vec![max_pool::SPEC, sigmoid::SPEC, upsample::SPEC];
    specs.extend([conv3x3::PLAIN, conv_transpose::PLAIN, conv1x1::PLAIN]);
    for tiling in Tiling::ALL {
        specs.extend([false, true].map(|pools| conv3x3::tiled_spec(tiling, pools)));
        specs.extend([up_conv::tiled_spec(tiling), conv_logits::tiled_spec(tiling)]);
    }
    let levels = [pyramid::LEVEL, gather::BOTTOM, gather::LEVEL];
    specs.extend(levels.iter().cloned().map(demodulating));
    specs.extend(levels);
    specs.extend(simd::SimdKernel::Conv3x3.all_quads().map(conv3x3::simd_spec));
    specs.extend(simd::SimdKernel::Conv1x1.all_quads().map(conv1x1::simd_spec));
    specs.extend(simd::SimdKernel::UpConv.all_quads().map(up_conv::simd_spec));
    specs.extend(simd::SimdKernel::ConvLogits.all_quads().map(conv_logits::simd_spec));
    for shape in matrix_shapes() {
        for (channels, pools) in [(16, false), (16, true), (32, false), (32, true)] {
            specs.push(conv3x3::matrix_spec(shape, channels, pools));
        }
        specs.extend([16, 32].map(|channels| up_conv::matrix_spec(shape, channels)));
        specs.push(conv_logits::matrix_spec(shape));
    }
    specs.extend(image_specs());
    specs
}

/// The shapes that adapters may report.
fn matrix_shapes() -> impl Iterator<Item = MatrixShape> {
    let shapes = [(8, F16), (8, F32), (16, F16)].into_iter();
    shapes.map(|(side, factor)| MatrixShape { side, factor, lanes: 32 })
}

/// The variants for every image format.
fn image_specs() -> Vec<KernelSpec> {
    use wgpu::TextureFormat::{Rgba16Float, Rgba32Float};
    let f16 = ImageFormat::Buffer(Element::F16);
    let textures = [Rgba16Float, Rgba32Float].map(ImageFormat::Texture);
    let [source, _] = textures;
    let mut specs = Vec::new();
    for color in [ImageFormat::F32, f16, source] {
        let images = [color, source, f16];
        specs.extend([autoexposure::bins_spec(color), autoexposure::reduce_spec(color)]);
        specs.extend(
            [activity::classify_spec, activity::settle_spec, activity::spread_spec]
                .map(|s| s(color)),
        );
        specs.push(input_process::spec(images));
        specs.extend(Tiling::ALL.map(|tiling| input_conv::tiled_spec(tiling, images)));
        specs.extend(matrix_shapes().map(|shape| input_conv::matrix_spec(shape, images)));
        specs.extend([pyramid::level0_spec(color), pyramid::finest_spec(color)]);
        for other in [ImageFormat::F32, f16, source] {
            specs.push(pyramid::layer0_spec(color, other));
            specs.push(reading_albedo(pyramid::level0_spec(color), other));
            specs.push(reading_albedo(pyramid::finest_spec(color), other));
        }
        for output in [ImageFormat::F32, f16].into_iter().chain(textures) {
            specs.push(accumulate::spec([color, source, f16, color], output));
            specs.push(accumulate::spec([color, ImageFormat::F32, source, f16], output));
            specs.extend(
                [accumulate_layer::soften_spec, accumulate_layer::average_spec]
                    .map(|s| s(color, output)),
            );
            specs.push(output_process::spec(color, output));
            specs.extend([head::spec(color, output), head::simd_spec(color, output)]);
            let stored = [gather::stored_spec, gather::layer_spec].map(|spec| spec(color, output));
            specs.extend(stored.iter().cloned().map(demodulating));
            specs.extend(stored);
            let computed = gather::computed_spec(color, output);
            let albedos = [ImageFormat::F32, f16, source];
            specs.extend(albedos.map(|albedo| reading_albedo(computed.clone(), albedo)));
            specs.push(computed);
        }
    }
    specs
}
