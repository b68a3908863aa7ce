//! Every shader variant is valid and matches the host's declarations.

use naga::valid::Capabilities;
use naga::{
    AddressSpace, Expression, ImageClass, Literal, StorageAccess, StorageFormat, TypeInner,
};
use wgdenoise::internals::gpu::kernel::{Binding, KernelSpec};
use wgdenoise::internals::gpu::matrix_shape::SUBGROUPS;
use wgdenoise::internals::model::{Encoding, TransferFunction};
use wgdenoise::internals::ops::autoexposure::Band;
use wgdenoise::internals::ops::conv3x3;
use wgdenoise::internals::ops::convolution::Tiling;
use wgdenoise::internals::ops::matrix;
use wgdenoise::internals::ops::need::NeedUniform;
use wgdenoise::internals::ops::tile::Tile;
use wgdenoise::internals::ops::{activity, all_specs, conv_logits, convolution};
use wgdenoise::internals::plan::halo;
use wgdenoise::internals::reference;
use wgdenoise::{Factor, Layout, MatrixShape, Precision, wgpu};

type Checked = (naga::Module, naga::valid::ModuleInfo);

/// Validates with only the capabilities that the host requests from an adapter.
fn check(source: &str) -> Result<Checked, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|e| e.emit_to_string(source))?;
    let flags = naga::valid::ValidationFlags::all();
    let info = naga::valid::Validator::new(flags, capabilities(source))
        .validate(&module)
        .map_err(|e| e.emit_to_string(source))?;
    Ok((module, info))
}

/// The capabilities behind `required_features`. Only the half kernels and matrices of 16-bit floats
/// use `SHADER_F16`, and only matrices use those of their shape. Every backend converts 16-bit
/// floats from and to words.
fn capabilities(source: &str) -> Capabilities {
    let mut all = Capabilities::SUBGROUP | Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    all.set(Capabilities::COOPERATIVE_MATRIX, is_matrix(source));
    let is_half = source.contains("Number = f16");
    let has_halves = is_half || is_matrix(source) && source.contains("Factor = f16");
    all.set(Capabilities::SHADER_FLOAT16, has_halves);
    all
}

fn is_matrix(source: &str) -> bool {
    source.contains("enable wgpu_cooperative_matrix;")
}

fn wgsl(spec: &KernelSpec, precision: Precision) -> String {
    spec.wgsl(precision).unwrap_or_else(|e| panic!("{}: {e}", spec.name))
}

fn parse(source: &str) -> Result<naga::Module, String> {
    check(source).map(|(module, _)| module)
}

/// Runs a check on every variant in both precisions.
fn for_every_module(check: impl Fn(&KernelSpec, Precision, &naga::Module)) {
    let specs = all_specs();
    assert!(specs.len() >= 27, "only {} variants are listed", specs.len());
    for spec in specs {
        for precision in [Precision::F32, Precision::F16] {
            let module = parse(&wgsl(&spec, precision));
            check(&spec, precision, &module.unwrap_or_else(|e| panic!("{}: {e}", spec.name)));
        }
    }
}

#[test]
fn bindings_are_what_the_host_declares() {
    for_every_module(|spec, precision, module| {
        let mut found: Vec<_> = module
            .global_variables
            .iter()
            .filter_map(|(_, v)| Some((v.binding.as_ref()?, describe(module, v))))
            .collect();
        found.sort_by_key(|(at, _)| (at.group, at.binding));
        let places: Vec<_> = found.iter().map(|(at, _)| (at.group, at.binding)).collect();
        let expected: Vec<_> = (0..spec.bindings.len() as u32).map(|i| (0, i)).collect();
        assert_eq!(places, expected, "bindings of {}", spec.name);
        for ((at, found), binding) in found.iter().zip(spec.bindings.iter()) {
            let expected = declared(*binding, precision);
            assert_eq!(*found, expected, "{} binding {}", spec.name, at.binding);
        }
    });
}

#[test]
fn bindings_are_as_few_as_every_device_has() {
    let limits = wgpu::Limits::default();
    for spec in all_specs() {
        let count = |is: fn(&&Binding) -> bool| spec.bindings.iter().filter(is).count();
        let textures = count(|binding| {
            use Binding::{
                ActivityOut, ImageOut, LightIn, LightOut, TensorIn, TensorOut, WeightTexture,
            };
            matches!(
                binding,
                TensorIn
                    | TensorOut
                    | LightIn
                    | LightOut
                    | WeightTexture
                    | ActivityOut
                    | ImageOut(_)
            )
        });
        let buffers = count(|binding| matches!(binding, Binding::Buffer | Binding::BufferMut));
        let most = [
            limits.max_storage_textures_per_shader_stage,
            limits.max_storage_buffers_per_shader_stage,
        ];
        let fits = textures <= most[0] as usize && buffers <= most[1] as usize;
        assert!(fits, "{} has {textures} and {buffers} of {most:?}", spec.name);
    }
}

#[test]
fn workgroup_memory_is_within_what_every_device_has() {
    let most = wgpu::Limits::default().max_compute_workgroup_storage_size;
    for_every_module(|spec, _, module| {
        let shared = module.global_variables.iter().map(|(_, variable)| variable);
        let shared = shared.filter(|v| v.space == AddressSpace::WorkGroup);
        let sizes = shared.map(|v| module.types[v.ty].inner.size(module.to_ctx()));
        let bytes: u32 = sizes.sum();
        assert!(bytes <= most, "{} takes {bytes} bytes of {most}", spec.name);
    });
}

/// Tests Metal and DX12 as far as possible without them: naga must write every variant for both,
/// except matrices for DX12, where no adapter offers them, and 16×16 ones for Metal, which has
/// none.
#[test]
fn every_variant_can_be_written_for_the_backends_that_run_it() {
    for spec in all_specs() {
        for precision in [Precision::F32, Precision::F16] {
            let text = wgsl(&spec, precision);
            let (module, info) = check(&text).expect("it is valid");
            let constants = spec.overrides.iter().map(|name| (name.to_string(), 1.0)).collect();
            let (module, info) =
                naga::back::pipeline_constants::process_overrides(&module, &info, None, &constants)
                    .unwrap_or_else(|e| panic!("{}: {e}", spec.name));
            to_vulkan(&module, &info).unwrap_or_else(|e| panic!("{}: {e}", spec.name));
            to_metal(&module, &info).unwrap_or_else(|e| panic!("{}: {e}", spec.name));
            if !is_matrix(&text) {
                to_dx12(&module, &info).unwrap_or_else(|e| panic!("{}: {e}", spec.name));
            }
        }
    }
}

fn to_vulkan(module: &naga::Module, info: &naga::valid::ModuleInfo) -> Result<(), String> {
    let options = naga::back::spv::Options { lang_version: (1, 3), ..Default::default() };
    naga::back::spv::write_vec(module, info, &options, None).map(|_| ()).map_err(|e| e.to_string())
}

fn to_metal(module: &naga::Module, info: &naga::valid::ModuleInfo) -> Result<(), String> {
    let options = naga::back::msl::Options { lang_version: (2, 4), ..Default::default() };
    let written = naga::back::msl::write_string(module, info, &options, &Default::default());
    written.map(|_| ()).map_err(|e| e.to_string())
}

fn to_dx12(module: &naga::Module, info: &naga::valid::ModuleInfo) -> Result<(), String> {
    // 16-bit floats need 6.2; wgpu asks DX12 for the highest available.
    let shader_model = naga::back::hlsl::ShaderModel::V6_2;
    let options = naga::back::hlsl::Options { shader_model, ..Default::default() };
    let mut text = String::new();
    let pipeline = naga::back::hlsl::PipelineOptions::default();
    let mut writer = naga::back::hlsl::Writer::new(&mut text, &options, &pipeline);
    writer.write(module, info, None).map(|_| ()).map_err(|e| e.to_string())
}

#[test]
fn overrides_and_workgroup_sizes_are_what_the_host_declares() {
    for_every_module(|spec, _, module| {
        let names = module.overrides.iter().map(|(_, o)| o.name.clone().unwrap_or_default());
        let mut found: Vec<_> = names.collect();
        found.sort();
        assert_eq!(found, spec.overrides, "overrides of {}", spec.name);
        let entry = module.entry_points.iter().find(|e| e.name == spec.entry);
        let entry = entry.unwrap_or_else(|| panic!("{} has no {}", spec.name, spec.entry));
        assert_eq!(entry.workgroup_size, spec.workgroup, "workgroup of {}", spec.name);
    });
}

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
        Expression::Literal(Literal::F32(value)) => Some(value.into()),
        ref other => panic!("{name} is {other:?}"),
    }
}

/// The first variant whose name starts with the words of `shader`.
fn spec(shader: &str) -> KernelSpec {
    let begins = |s: &KernelSpec| format!("{} ", s.name).starts_with(&format!("{shader} "));
    all_specs().into_iter().find(begins).unwrap_or_else(|| panic!("{shader} is not listed"))
}

#[test]
fn every_shader_file_belongs_to_an_operator_with_a_reference_and_a_test() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let stems = |folder: &str| -> Vec<String> {
        let entries = std::fs::read_dir(root.join(folder)).expect("the folder exists");
        let paths = entries.map(|entry| entry.expect("it can be listed").path());
        paths.map(|p| p.file_stem().expect("a name").to_string_lossy().into_owned()).collect()
    };
    let mut shaders = stems("shaders");
    shaders.retain(|name| !["common", "README"].contains(&name.as_str()));
    assert!(shaders.len() >= 16, "{shaders:?}");
    for shader in shaders {
        // A variant's name is its operator's name plus its own suffix: `conv3x3_tiled`.
        let mut variants = ["_tiled", "_simd", "_matrix", "_layer"].into_iter();
        let operator = variants.find_map(|variant| shader.strip_suffix(variant));
        let operator = operator.unwrap_or(&shader).to_string();
        for folder in ["src/ops", "src/reference", "tests/ops"] {
            assert!(stems(folder).contains(&operator), "{folder} lacks {operator}");
        }
    }
}

#[test]
fn a_broken_shader_does_not_pass() {
    let broken = wgsl(&wgdenoise::internals::ops::max_pool::SPEC, Precision::F32);
    let broken = broken.replace("max(upper, lower)", "upper.xyz");
    parse(&broken).unwrap_err();
    let texts = all_specs().into_iter().map(|spec| wgsl(&spec, Precision::F32));
    let matrix = texts.into_iter().find(|text| is_matrix(text)).expect("it is listed");
    parse(&matrix).unwrap();
    let broken = matrix.replace("coop_mat8x8<f32, C>", "coop_mat8x8<f32, B>");
    parse(&broken).unwrap_err();
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

/// A shader's binding as comparable text.
fn describe(module: &naga::Module, variable: &naga::GlobalVariable) -> String {
    let inner = &module.types[variable.ty].inner;
    match (variable.space, inner) {
        (AddressSpace::Handle, TypeInner::Image { class, arrayed, .. }) => {
            if let ImageClass::Sampled { kind, .. } = class {
                return format!("texture of {kind:?}, array: {arrayed}");
            }
            let ImageClass::Storage { format, access } = class else { return format!("{class:?}") };
            texture(*format, access.contains(StorageAccess::STORE), *arrayed)
        }
        (AddressSpace::Storage { access }, _) => {
            format!("storage, written: {}", access.contains(StorageAccess::STORE))
        }
        (AddressSpace::Uniform, _) => format!("uniform of {} bytes", inner.size(module.to_ctx())),
        other => format!("{other:?}"),
    }
}

fn declared(binding: Binding, precision: Precision) -> String {
    let tensor = match precision {
        Precision::F32 => StorageFormat::Rgba32Float,
        Precision::F16 => StorageFormat::Rgba16Float,
    };
    match binding {
        Binding::TensorIn => texture(tensor, false, true),
        Binding::TensorOut => texture(tensor, true, true),
        Binding::LightOut => texture(StorageFormat::Rgba32Float, true, true),
        Binding::WeightTexture | Binding::LightIn => {
            texture(StorageFormat::Rgba32Float, false, true)
        }
        Binding::ActivityIn => "texture of Uint, array: true".into(),
        Binding::ActivityOut => texture(StorageFormat::R32Uint, true, true),
        Binding::Image => "texture of Float, array: false".into(),
        Binding::ImageOut(wgpu::TextureFormat::Rgba16Float) => {
            texture(StorageFormat::Rgba16Float, true, false)
        }
        Binding::ImageOut(_) => texture(StorageFormat::Rgba32Float, true, false),
        Binding::Buffer => "storage, written: false".into(),
        Binding::BufferMut => "storage, written: true".into(),
        Binding::Uniform { bytes, .. } => format!("uniform of {bytes} bytes"),
    }
}

fn texture(format: StorageFormat, written: bool, arrayed: bool) -> String {
    format!("{format:?} texture, array: {arrayed}, written: {written}")
}
