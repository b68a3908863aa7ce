use super::*;

const TILE: &str = "struct Tile { origin: vec2<u32> }
@group(0) @binding(0) var<uniform> tile: Tile;
@if(half) alias Element = f16;
@elif(!half && (wide || false)) alias Element = f64;
@else alias Element = f32;";

fn compose(root: &str, enabled: &[&str]) -> Result<String, ComposeError> {
    let modules = [("common/tile", TILE), ("a", "import package::b::b;\nconst a = 1;"), ("b", B)];
    let library = Library { modules: &modules, features: &["half", "wide"] };
    library.compose(&ShaderRoot::Generated(root.into()), enabled)
}

const B: &str = "import package::a::a;\nimport package::common::tile::tile;\nconst b = a;";

/// The problem of a root module, and that it is its own.
fn problem(root: &str) -> Problem {
    let error = compose(root, &[]).expect_err(root);
    assert_eq!(error.module, "generated", "{root}");
    error.problem
}

fn lines(root: &str, enabled: &[&str]) -> Vec<String> {
    let text = compose(root, enabled).unwrap_or_else(|e| panic!("{e}"));
    text.lines().filter(|line| !line.is_empty()).map(Into::into).collect()
}

#[test]
fn imported_modules_are_included_once_also_where_they_import_each_other() {
    let root = "import package::a::a;\nimport package::b::{ b, };\nconst c = a + b;";
    let text = compose(root, &[]).unwrap();
    for declaration in ["const a = 1;", "const b = a;", "const c = a + b;", "struct Tile {"] {
        assert_eq!(text.matches(declaration).count(), 1, "{declaration} in {text}");
    }
    assert!(!text.contains("import"), "{text}");
}

#[test]
fn a_module_that_imports_its_root_is_not_included_twice() {
    let modules = [("root", "import package::shared::f;\nconst r = 1;"), ("shared", SHARED)];
    let library = Library { modules: &modules, features: &[] };
    let text = library.compose(&ShaderRoot::Module("root"), &[]).unwrap();
    assert_eq!(text, "const r = 1;\n\nfn f() -> i32 { return r; }\n");
}

const SHARED: &str = "import package::root::r;\nfn f() -> i32 { return r; }";

#[test]
fn one_branch_of_a_chain_is_kept() {
    let element = |enabled: &[&str]| {
        let text = compose("import package::common::tile::Element;", enabled).unwrap();
        let found: Vec<_> = text.lines().filter(|line| line.contains("alias")).collect();
        assert!(!text.contains("@if") && found.len() == 1, "{text}");
        found[0].to_string()
    };
    assert_eq!(element(&["half"]), "alias Element = f16;");
    assert_eq!(element(&["half", "wide"]), "alias Element = f16;");
    assert_eq!(element(&["wide"]), "alias Element = f64;");
    assert_eq!(element(&[]), "alias Element = f32;");
}

#[test]
fn statements_and_the_conditions_inside_them_are_chosen() {
    let root = "fn f() {
        @if(half) if x { a(); @if(wide) b(); } else if y { c(); } else { d(); }
        @else for (var i = 0; i < 3; i++) { e(); }
        @if(wide) { let elsewhere = 1; }
        elsewhere = 2;
    }";
    let has = |enabled: &[&str]| {
        let text = compose(root, enabled).unwrap();
        ["a();", "b();", "c();", "d();", "e();", "= 1;", "= 2;"].map(|s| text.contains(s))
    };
    assert_eq!(has(&["half"]), [true, false, true, true, false, false, true]);
    assert_eq!(has(&["half", "wide"]), [true, true, true, true, false, true, true]);
    assert_eq!(has(&[]), [false, false, false, false, true, false, true]);
}

#[test]
fn imports_and_directives_can_depend_on_a_feature() {
    let root = "@if(half) import package::a::a;\n@if(half) enable f16;\nenable z;\nconst c = 1;";
    assert_eq!(lines(root, &[]), ["enable z;", "const c = 1;"]);
    assert_eq!(lines(root, &["half"])[..3], ["enable f16;", "enable z;", "const c = 1;"]);
    assert!(lines(root, &["half"]).contains(&"const a = 1;".into()));
}

#[test]
fn comments_are_no_code() {
    let root = "// import package::nowhere::x; }\n/* @else { /* } */ ( */const c = 6 / 2;// @if(";
    assert_eq!(compose(root, &[]).unwrap(), "const c = 6 / 2;\n");
    assert_eq!(problem("/* /* */ const c = 1;"), Problem::Unbalanced);
}

#[test]
fn every_kind_of_declaration_can_be_imported() {
    let text = "fn f() -> S { }\n@must_use fn g(x: i32) { }\nstruct S { x: f32 }\nalias A = S;
        const c: i32 = 1;\noverride o: f32;\n@id(1) override p = 2.0;
        @group(0) @binding(1) var<storage, read> v: array<u32>;\nvar<workgroup> w: array<f32, 4>;
        @group(0) @binding(2) var t: texture_2d<f32>;";
    let modules = [("m", text)];
    let library = Library { modules: &modules, features: &[] };
    for name in ["f", "g", "S", "A", "c", "o", "p", "v", "w", "t"] {
        let root = ShaderRoot::Generated(format!("import package::m::{name};"));
        library.compose(&root, &[]).unwrap_or_else(|e| panic!("{e}"));
    }
    for name in ["x", "i32", "group", "storage", "array", "must_use"] {
        let root = ShaderRoot::Generated(format!("import package::m::{name};"));
        library.compose(&root, &[]).expect_err(name);
    }
}

#[test]
fn what_is_wrong_is_named() {
    let unknown = compose("import package::nowhere::x;", &[]).unwrap_err();
    assert_eq!(unknown.to_string(), "shader module nowhere: no such module");
    assert_eq!(
        problem("import package::a::{a, z};"),
        Problem::UnknownName { module: "a".into(), name: "z".into() }
    );
    let excluded = compose("@if(wide) import package::a::z;", &["wide"]).unwrap_err();
    assert_eq!(excluded.problem, Problem::UnknownName { module: "a".into(), name: "z".into() });
    assert_eq!(problem("@if(hafl) const c = 1;"), Problem::UnknownFeature("hafl".into()));
    let later = "@if(true) const c = 1; @elif(hafl) const c = 2;";
    assert_eq!(problem(later), Problem::UnknownFeature("hafl".into()));
    let enabled = compose("const c = 1;", &["hafl"]).unwrap_err();
    assert_eq!(enabled.problem, Problem::UnknownFeature("hafl".into()));
    for root in ["fn f() { if x { }", "fn f() { } }", "fn f( { }", "const c = 1", "@if(half"] {
        assert_eq!(problem(root), Problem::Unbalanced, "{root}");
    }
    for root in
        ["@else const c = 1;", "@if(half) const c = 1; const d = 1; @elif(wide) const e = 1;"]
    {
        assert_eq!(problem(root), Problem::NoIf, "{root}");
    }
    assert_eq!(
        problem("@if(half) const a = 1; @else const b = 1; @else const c = 1;"),
        Problem::NoIf
    );
    for condition in ["()", "(half &&)", "(half wide)", "((half)", "(half | wide)", "(!)"] {
        let root = format!("@if{condition} const c = 1;");
        let problem = problem(&root);
        let malformed = matches!(problem, Problem::Condition(_) | Problem::Unbalanced);
        assert!(malformed, "{root}: {problem}");
    }
    for import in ["import a::b;", "import package::a;", "import package::a::{a;"] {
        let problem = problem(import);
        let malformed = matches!(problem, Problem::Import(_) | Problem::Unbalanced);
        assert!(malformed, "{import}: {problem}");
    }
}
