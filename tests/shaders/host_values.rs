//! Structs and constants that shaders share with the host have the host's layout and values.

use naga::{Expression, Literal, TypeInner};
use wgdenoise::internals::gpu::kernel::KernelSpec;
use wgdenoise::internals::gpu::matrix_shape::SUBGROUPS;
use wgdenoise::internals::model::{Encoding, TransferFunction};
use wgdenoise::internals::ops::autoexposure::Band;
use wgdenoise::internals::ops::conv3x3;
use wgdenoise::internals::ops::convolution::Tiling;
use wgdenoise::internals::ops::gather;
use wgdenoise::internals::ops::matrix;
use wgdenoise::internals::ops::need::NeedUniform;
use wgdenoise::internals::ops::tile::Tile;
use wgdenoise::internals::ops::{activity, all_specs, conv_logits, convolution};
use wgdenoise::internals::plan::halo;
use wgdenoise::internals::reference;
use wgdenoise::{Factor, Layout, MatrixShape, Precision};

use crate::{parse, wgsl};

#[test]
fn structs_have_the_offsets_of_the_host() {
    use std::mem::offset_of;
    let tile = [
        ("image_size", offset_of!(Tile, image_size)),
        ("origin", offset_of!(Tile, origin)),
        ("begin", offset_of!(Tile, begin)),
        ("end", offset_of!(Tile, end)),
        ("color", offset_of!(Tile, color)),
        ("albedo", offset_of!(Tile, albedo)),
        ("normal", offset_of!(Tile, normal)),
        ("output", offset_of!(Tile, output)),
        ("beauty", offset_of!(Tile, beauty)),
        ("motion", offset_of!(Tile, motion)),
        ("depth", offset_of!(Tile, depth)),
    ];
    let layout = [
        ("offset", offset_of!(Layout, offset)),
        ("row_stride", offset_of!(Layout, row_stride)),
        ("pixel_stride", offset_of!(Layout, pixel_stride)),
        ("channels", size_of::<Layout>() - size_of::<u32>()),
    ];
    let band = [
        ("image_size", offset_of!(Band, image_size)),
        ("bins", offset_of!(Band, bins)),
        ("first_bin_row", offset_of!(Band, first_bin_row)),
        ("bin_rows", offset_of!(Band, bin_rows)),
        ("first_row", offset_of!(Band, first_row)),
        ("padding", offset_of!(Band, color) - size_of::<u32>()),
        ("color", offset_of!(Band, color)),
    ];
    let need = [
        ("layer", offset_of!(NeedUniform, layer)),
        ("shift", offset_of!(NeedUniform, shift)),
        ("reach", offset_of!(NeedUniform, reach)),
        ("padding", size_of::<NeedUniform>() - size_of::<u32>()),
    ];
    for shader in [
        "input_process",
        "input_conv_tiled",
        "output_process",
        "activity_classify",
        "head",
        "pyramid_layer0",
    ] {
        assert_eq!(members(shader, "Tile"), host(&tile), "{shader}");
        assert_eq!(members(shader, "Layout"), host(&layout), "{shader}");
    }
    assert_eq!(members("autoexposure_bins", "Band"), host(&band));
    assert_eq!(members("autoexposure_bins", "Layout"), host(&layout));
    for shader in
        ["conv3x3_tiled", "conv3x3_simd4", "up_conv_tiled", "up_conv_simd4", "input_conv_tiled"]
    {
        assert_eq!(members(shader, "Need"), host(&need), "{shader}");
    }
}

#[test]
fn constants_have_the_values_of_the_host() {
    let bounded = Encoding { unbounded: false, ..Encoding::default() };
    let most = Encoding { unbounded: true, ..bounded }.brightest();
    let block = f64::from(activity::BLOCK);
    let half = Precision::F16.largest();
    same("activity_spread", "BLOCK", block);
    same("activity_spread", "FAR", f64::from(activity::FAR));
    same("activity_spread", "LAYERS", f64::from(activity::LAYERS));
    same("head", "BLOCK", block);
    same("input_process", "REPAIR", halo::REPAIR as f64);
    same("input_process", "GREY", reference::GREY);
    same("input_process", "MOST", f64::from(reference::MOST));
    same("input_process", "MOST", f64::from(most));
    for curve in TransferFunction::ALL {
        same("input_process", &curve.name().to_uppercase(), f64::from(curve as u8));
    }
    same("head", "LARGEST_F32", Precision::F32.largest());
    same("output_process f32 rgba16float", "LARGEST_F16", half);
    same("output_process f32 rgba32float", "LARGEST_F32", Precision::F32.largest());
    assert_eq!(f64::from(bounded.brightest()), half);
    assert_eq!(reference::LARGEST, half);
    for operator in ["conv3x3", "conv_logits", "input_conv", "up_conv"] {
        let names = ["tiled", "wide", "half"];
        for (tiling, suffix) in Tiling::ALL.into_iter().zip(names) {
            let shader = format!("{operator}_{suffix}");
            let [width, height] = tiling.size().map(f64::from);
            same(&shader, "WIDTH", width);
            same(&shader, "HEIGHT", height);
            same(&shader, "QUADS", convolution::TILED_QUADS as f64);
            same(&shader, "INVOCATIONS", f64::from(spec(&shader).workgroup[0]));
        }
    }
    same("conv_logits_tiled", "HELD", (conv_logits::CHANNELS / 4) as f64);
    let [width, height, _] = gather::LEVEL.workgroup;
    same("gather_finest", "GROUP_WIDTH", f64::from(gather::PIXELS * width));
    same("gather_finest", "GROUP_HEIGHT", f64::from(height));
    same("gather_finest", "INVOCATIONS", f64::from(width * height));
    same("gather_finest", "STEP", f64::from(gather::PIXELS));
    same("autoexposure_reduce", "LANES", f64::from(spec("autoexposure_reduce").workgroup[0]));
}

#[test]
fn matrices_have_the_sizes_of_the_host() {
    let shapes = [(8, Factor::F16), (8, Factor::F32), (16, Factor::F16)];
    for (shape, channels) in shapes.into_iter().flat_map(|s| [(s, 16), (s, 32)]) {
        let (side, factor) = shape;
        let shape = MatrixShape { side, factor, lanes: 32 };
        let spec = conv3x3::matrix_spec(shape, channels, false);
        let module = parse(&wgsl(&spec, Precision::F32)).expect("it is valid");
        let largest = if factor == Factor::F16 { Precision::F16 } else { Precision::F32 };
        for (name, expected) in [
            ("SIDE", f64::from(side)),
            ("CHANNELS", f64::from(channels)),
            ("WIDTH", f64::from(2 * side)),
            ("HEIGHT", f64::from(2 * SUBGROUPS)),
            ("SUBGROUPS", f64::from(SUBGROUPS)),
            ("SUMS", f64::from(matrix::SUMS)),
            ("LARGEST_FACTOR", largest.largest()),
        ] {
            assert_eq!(constant(&module, name), Some(expected), "{name} of {}", spec.name);
        }
    }
}

/// A constant declared in a shader must equal the host's, in 32-bit floats.
fn same(shader: &str, name: &str, host: f64) {
    let module = parse(&wgsl(&spec(shader), Precision::F32)).expect("the shader is valid");
    let found = constant(&module, name).map(|value| value as f32);
    assert_eq!(found, Some(host as f32), "{name} of {shader}");
}

fn constant(module: &naga::Module, name: &str) -> Option<f64> {
    let (_, constant) = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name))?;
    match module.global_expressions[constant.init] {
        Expression::Literal(Literal::U32(value)) => Some(value.into()),
        Expression::Literal(Literal::I32(value)) => Some(value.into()),
        Expression::Literal(Literal::F32(value)) => Some(value.into()),
        ref other => panic!("{name} is {other:?}"),
    }
}

/// The first variant whose name starts with the words of `shader`.
fn spec(shader: &str) -> KernelSpec {
    let begins = |s: &KernelSpec| format!("{} ", s.name).starts_with(&format!("{shader} "));
    all_specs().into_iter().find(begins).unwrap_or_else(|| panic!("{shader} is not listed"))
}

fn host(members: &[(&str, usize)]) -> Vec<(String, u32)> {
    members.iter().map(|&(name, offset)| (name.into(), offset as u32)).collect()
}

/// Member names and offsets of a struct in a shader.
fn members(shader: &str, name: &str) -> Vec<(String, u32)> {
    let module = parse(&wgsl(&spec(shader), Precision::F32)).expect("the shader is valid");
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    match &found.expect("the struct exists").1.inner {
        TypeInner::Struct { members, .. } => {
            members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect()
        }
        other => panic!("{name} is {other:?}"),
    }
}
