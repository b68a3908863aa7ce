//! Every shader variant is valid and matches the host's declarations.

use naga::valid::Capabilities;
use naga::{AddressSpace, ImageClass, StorageAccess, StorageFormat, TypeInner};
use wgdenoise::internals::gpu::kernel::{Binding, KernelSpec};
use wgdenoise::internals::ops::all_specs;
use wgdenoise::{Precision, wgpu};

mod host_values;

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
