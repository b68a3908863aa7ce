//! The shaders are valid WESL: an independent compiler builds the same kernels from them.

use std::collections::BTreeSet;

use wesl::syntax::{ModulePath, PathOrigin};
use wesl::{Feature, ManglerKind, VirtualResolver, Wesl};
use wgdenoise::Precision;
use wgdenoise::internals::gpu::kernel::KernelSpec;
use wgdenoise::internals::ops::all_specs;
use wgdenoise::internals::shader::{LIBRARY, Source};

#[test]
fn the_wesl_compiler_makes_the_same_kernels() {
    let mut wrong = Vec::new();
    for spec in all_specs() {
        for precision in [Precision::F32, Precision::F16] {
            let ours = spec.wgsl(precision).unwrap_or_else(|e| panic!("{}: {e}", spec.name));
            let theirs = compile(&spec, precision).and_then(|text| interface(&text));
            if theirs != interface(&ours) {
                wrong.push(format!("{} {precision:?}: {theirs:?}", spec.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{} kernels:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn the_wesl_compiler_refuses_what_is_not_wesl() {
    let spec = KernelSpec {
        source: Source::Generated(
            "import package::common::tile::nothing;\nconst a = nothing;".into(),
        ),
        ..wgdenoise::internals::ops::max_pool::SPEC
    };
    compile(&spec, Precision::F32).unwrap_err();
}

fn path(module: &str) -> ModulePath {
    ModulePath::new(PathOrigin::Absolute, module.split('/').map(Into::into).collect())
}

/// The WESL compiler's output for a kernel, with everything its modules declare.
fn compile(spec: &KernelSpec, precision: Precision) -> Result<String, String> {
    let mut modules = VirtualResolver::new();
    for (name, text) in LIBRARY.modules {
        modules.add_module(path(name), (*text).into());
    }
    let root = match &spec.source {
        Source::Module(name) => path(name),
        Source::Generated(text) => {
            modules.add_module(path("generated"), text.into());
            path("generated")
        }
    };
    let mut compiler = Wesl::new("shaders").set_custom_resolver(modules);
    compiler.set_mangler(ManglerKind::None).use_stripping(false);
    compiler.set_missing_feature_behavior(Feature::Error);
    for feature in LIBRARY.features {
        let is_half = *feature == "tensor_f16" && precision == Precision::F16;
        compiler.set_feature(feature, is_half || spec.features.contains(feature));
    }
    compiler.compile(&root).map(|module| module.to_string()).map_err(|e| e.to_string())
}

/// Names and kinds of everything a module declares, if naga can read it.
fn interface(text: &str) -> Result<BTreeSet<String>, String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
    let ctx = module.to_ctx();
    let globals = module.global_variables.iter().map(|(_, v)| {
        let size = module.types[v.ty].inner.try_size(ctx);
        format!("{:?} {:?} {:?} of {size:?} bytes", v.name, v.binding, v.space)
    });
    let entries = module.entry_points.iter().map(|e| format!("{} {:?}", e.name, e.workgroup_size));
    let functions = module.functions.iter().map(|(_, f)| format!("{:?}", f.name));
    let overrides = module.overrides.iter().map(|(_, o)| format!("{:?}", o.name));
    let constants = module.constants.iter().map(|(_, c)| format!("{:?}", c.name));
    let names = globals.chain(entries).chain(functions).chain(overrides).chain(constants);
    let names: BTreeSet<_> = names.collect();
    if names.is_empty() { Err("an empty module".into()) } else { Ok(names) }
}
