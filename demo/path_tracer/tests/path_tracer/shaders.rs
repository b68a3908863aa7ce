//! The shaders run on every backend: they need no features, and naga translates them for each.

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, back};

use path_tracer::renderer::{MOTION, PATH_TRACE, RESOLVE};

const PRESENT: &str = include_str!("../../src/window/present.wgsl");

fn check(source: &str) -> Result<(Module, ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|e| e.emit_to_string(source))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|e| e.emit_to_string(source))?;
    Ok((module, info))
}

#[test]
fn shaders_need_no_feature_and_can_be_written_for_metal_and_dx12() {
    for (name, source) in
        [("path_trace", PATH_TRACE), ("resolve", RESOLVE), ("motion", MOTION), ("present", PRESENT)]
    {
        let (module, info) = check(source).unwrap_or_else(|e| panic!("{name}: {e}"));
        let metal = back::msl::Options { lang_version: (2, 4), ..Default::default() };
        back::msl::write_string(&module, &info, &metal, &Default::default())
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        let shader_model = back::hlsl::ShaderModel::V6_0;
        let dx12 = back::hlsl::Options { shader_model, ..Default::default() };
        let (mut text, pipeline) = (String::new(), back::hlsl::PipelineOptions::default());
        back::hlsl::Writer::new(&mut text, &dx12, &pipeline)
            .write(&module, &info, None)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn a_broken_shader_does_not_pass() {
    check(&PATH_TRACE.replace("found.albedo", "found.color")).unwrap_err();
}
