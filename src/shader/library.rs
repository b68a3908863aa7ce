//! All modules of `shaders/`, and the features of their variants.

use super::composer::Library;

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../shaders/", $name, ".wgsl")))),*]
    };
}

/// Every module of `shaders/`.
pub const LIBRARY: Library<'static> = Library { modules: MODULES, features: FEATURES };

#[rustfmt::skip]
const MODULES: &[(&str, &str)] = modules![
    "accumulate", "accumulate_layer", "activity", "autoexposure", "common/albedo", "common/beauty", "common/block", "common/clean", "common/color",
    "common/conv_bias", "common/conv_input", "common/conv_logits", "common/conv_output",
    "common/conv_sums", "common/conv_tile", "common/demodulation", "common/depth",
    "common/encoded", "common/encoding", "common/fill", "common/finest", "common/gathered",
    "common/half", "common/head", "common/history", "common/images", "common/inputs", "common/layer", "common/layout",
    "common/light", "common/limits", "common/logits", "common/matrix", "common/mean", "common/motion", "common/need", "common/normal",
    "common/output", "common/patch", "common/place", "common/reflectance", "common/repair", "common/result", "common/scale", "common/seen",
    "common/simd", "common/simd_input", "common/spline", "common/staged_light", "common/sums", "common/tensor", "common/tile", "common/weighted",
    "conv1x1", "conv3x3", "conv3x3_matrix", "conv3x3_tiled", "conv_logits_matrix",
    "conv_logits_simd", "conv_logits_tiled",
    "conv_transpose", "gather", "head", "input_conv_tiled", "input_process", "max_pool",
    "output_process", "pyramid", "sigmoid", "up_conv_matrix", "up_conv_simd",
    "up_conv_tiled", "upsample",
];

const FEATURES: &[&str] = &[
    // Tensors have 16 bits instead of 32.
    "tensor_f16",
    // Images are textures or buffers of 16-bit floats. Without either, buffers of 32-bit floats.
    "color_f16",
    "color_texture",
    "albedo_f16",
    "albedo_texture",
    "normal_f16",
    "normal_texture",
    "motion_f16",
    "motion_texture",
    "depth_f16",
    "depth_texture",
    "output_f16",
    "output_rgba16float",
    "output_rgba32float",
    // The kernel filters a further layer of the image with the weights of its beauty.
    "layer",
    "beauty_f16",
    "beauty_texture",
    // The kernel reads albedo and normal as well as color.
    "auxiliary",
    // The kernel pyramid's image, or its coarsest level.
    "finest",
    "bottom",
    // The kernel stores level 0 of the pyramid, or reads it instead of computing it.
    "level0",
    "stored_finest",
    // The pyramid also carries the albedo, to demodulate light.
    "demodulates",
    // The convolution also computes the max-pool of its output.
    "pools",
    // A workgroup of the tiled kernels computes 32×8 pixels instead of 16×16 and stages eight input
    // channels at a time instead of four.
    "wide",
    // The tiled kernels multiply in 16-bit floats and sum a chunk of input channels in them.
    "half",
    // The kernel of this name has bindings of its own.
    "accumulate",
    "gather",
    "input_conv",
    "up_conv",
    // Matrices: 16-bit factors instead of 32-bit; 16×16 instead of 8×8; 32 output channels instead
    // of 16.
    "factor_f16",
    "side_16",
    "channels_32",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_folder_is_in_the_library() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
        let mut files = Vec::new();
        for folder in ["", "common/"] {
            for entry in std::fs::read_dir(root.join(folder)).expect("the folder exists") {
                let name = entry.expect("it can be listed").file_name();
                let name = name.to_string_lossy();
                files.extend(name.strip_suffix(".wgsl").map(|stem| format!("{folder}{stem}")));
            }
        }
        files.sort();
        let listed: Vec<_> = LIBRARY.modules.iter().map(|(name, _)| *name).collect();
        assert_eq!(listed, files);
    }
}
