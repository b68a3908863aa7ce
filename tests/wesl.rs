//! The shaders are valid WESL: an independent compiler builds the same kernels from them.

use std::collections::BTreeSet;

use wesl::syntax::{ModulePath, PathOrigin};
use wesl::{CompileOptions, Feature, Features, ManglerKind, VirtualResolver, Wesl};
use wgdenoise::Precision;
use wgdenoise::internals::gpu::kernel::KernelSpec;
use wgdenoise::internals::ops::all_specs;
use wgdenoise::internals::shader::{LIBRARY, ShaderRoot};

#[test]
fn the_wesl_compiler_makes_the_same_kernels() {
    let mut wrong = Vec::new();
    for spec in all_specs() {
        for precision in [Precision::F32, Precision::F16] {
            let ours = spec.wgsl(precision).unwrap_or_else(|e| panic!("{}: {e}", spec.name));
            let theirs = kernel(&spec, precision).and_then(|text| interface(&text));
            if theirs != interface(&ours) {
                wrong.push(format!("{} {precision:?}: {theirs:?}", spec.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{} kernels:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn the_wesl_compiler_accepts_every_file_by_itself() {
    for (name, _) in LIBRARY.modules {
        compile(&path(name), library(), &[], ManglerKind::Escape, true)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn the_wesl_compiler_refuses_what_is_not_wesl() {
    let text = "import package::common::tile::nothing;\nconst a = nothing;";
    let mut modules = library();
    modules.add_module(path("generated"), text.into());
    compile(&path("generated"), modules, &[], ManglerKind::Escape, true).unwrap_err();
}

fn path(module: &str) -> ModulePath {
    ModulePath::new(PathOrigin::Absolute, module.split('/').map(Into::into).collect())
}

fn library() -> VirtualResolver<'static> {
    let mut modules = VirtualResolver::new();
    for (name, text) in LIBRARY.modules {
        modules.add_module(path(name), (*text).into());
    }
    modules
}

/// The WESL compiler's output for a kernel. The compiler does not know wgpu's cooperative matrix
/// functions, so it skips function lookup in kernels that use them; naga does it instead.
fn kernel(spec: &KernelSpec, precision: Precision) -> Result<String, String> {
    let mut modules = library();
    let (root, is_matrix) = match &spec.source {
        ShaderRoot::Module(name) => (path(name), false),
        ShaderRoot::Generated(text) => {
            modules.add_module(path("generated"), text.clone().into());
            (path("generated"), text.contains("coopLoad"))
        }
    };
    let mut features = spec.features.to_vec();
    features.extend((precision == Precision::F16).then_some("tensor_f16"));
    compile(&root, modules, &features, ManglerKind::None, !is_matrix)
}

/// Compiles a module with all its imports, whether used or not.
fn compile(
    root: &ModulePath,
    modules: VirtualResolver<'_>,
    enabled: &[&str],
    mangler: ManglerKind,
    validate: bool,
) -> Result<String, String> {
    let flags = LIBRARY.features.iter().map(|f| (f.to_string(), enabled.contains(f).into()));
    let features = Features { default: Feature::Error, flags: flags.collect() };
    let options =
        CompileOptions { strip: false, lazy: false, validate, features, ..Default::default() };
    let mut compiler = Wesl::new("shaders").set_custom_resolver(modules);
    compiler.set_options(options).set_mangler(mangler);
    compiler.compile(root).map(|module| module.to_string()).map_err(|e| e.to_string())
}

/// Names and kinds of everything that a module declares, if naga can parse it.
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
