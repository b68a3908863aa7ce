//! The engine's layers: imports only point downward, files form no cycle, and every operator is
//! complete. Reads the `use` lines and paths in `src/`, including unit tests.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use wgdenoise::internals::model::Op;
use wgdenoise_testing::{check_cases, run_cases};

/// The layers from the bottom up. Modules of one layer must not use each other.
const FLOORS: &[&[&str]] = &[
    &["error", "panics"],
    &["image"],
    &["model", "shader"],
    &["plan", "reference"],
    &["gpu"],
    &["ops"],
    &["network"],
    &["denoiser"],
    &["measure", "tza"],
    &["internals", "lib"],
];

/// A file as a module path: `ops::conv3x3`, or `lib` for the root.
type Module = String;

/// The engine's imports: for each module, the modules it uses.
struct Imports(BTreeMap<Module, BTreeSet<Module>>);

impl Imports {
    fn of_engine() -> Self {
        Self::of("src")
    }

    /// The imports of the package whose sources are in this folder of the repository.
    fn of(folder: &str) -> Self {
        let sources = sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder));
        let files: BTreeSet<_> = sources.iter().map(|source| source.module.clone()).collect();
        let mut named: BTreeMap<Module, BTreeMap<String, String>> = BTreeMap::new();
        for Source { module, place, text } in &sources {
            named.entry(module.clone()).or_default().extend(exports(place, text));
        }
        let mut imports: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
        for Source { module, place, text } in &sources {
            let used =
                paths(place, text).into_iter().filter_map(|path| file(&path, &files, &named));
            imports.entry(module.clone()).or_default().extend(used.filter(|used| used != module));
        }
        Self(imports)
    }

    /// Imports from a higher layer or the same one.
    fn upward(&self) -> Vec<String> {
        let floor = |module: &str| {
            let room = module.split("::").next().unwrap_or(module);
            let floor = FLOORS.iter().position(|rooms| rooms.contains(&room));
            (floor.unwrap_or_else(|| panic!("`{room}` stands on no floor")), room.to_string())
        };
        let mut found = Vec::new();
        for (module, used) in self.0.iter().flat_map(|(m, all)| all.iter().map(move |u| (m, u))) {
            let ((from, room), (to, other)) = (floor(module), floor(used));
            if to >= from && room != other {
                found.push(format!("{module} uses {used}"));
            }
        }
        found
    }

    /// Modules that use themselves indirectly.
    fn circles(&self) -> Vec<String> {
        let reached = |from: &Module| {
            let mut seen: BTreeSet<&Module> = BTreeSet::new();
            let mut next: Vec<&Module> = self.0[from].iter().collect();
            while let Some(module) = next.pop() {
                if seen.insert(module) {
                    next.extend(self.0.get(module).into_iter().flatten());
                }
            }
            seen
        };
        let reach: BTreeMap<_, _> = self.0.keys().map(|module| (module, reached(module))).collect();
        let circular = |module: &&Module| reach[module].contains(module);
        let with = |module: &Module| {
            let others = reach[module].iter().filter(|other| reach[*other].contains(module));
            format!("{module} and {:?}", others.collect::<Vec<_>>())
        };
        self.0.keys().filter(circular).map(with).collect()
    }
}

/// A file, or the unit tests in it or next to it (`x_test.rs`), which belong to its module.
struct Source {
    module: Module,
    /// The module that `super` and `self` refer to.
    place: String,
    text: String,
}

/// All files below `src/`.
fn sources(root: &Path) -> Vec<Source> {
    let mut sources = Vec::new();
    for path in files(root) {
        let inner = path.strip_prefix(root).expect("it is below").with_extension("");
        let name = inner.to_string_lossy().replace('/', "::");
        let text = fs::read_to_string(&path).expect("a source file is text");
        let module = name.trim_end_matches("::mod").trim_end_matches("_test").to_string();
        let (code, tests) = match text.split_once("#[cfg(test)]\nmod tests {") {
            _ if name.ends_with("_test") => ("", text.as_str()),
            Some(both) => both,
            None => (text.as_str(), ""),
        };
        let place = format!("{module}::tests");
        sources.push(Source { module: module.clone(), place: module.clone(), text: code.into() });
        sources.push(Source { module, place, text: tests.into() });
    }
    sources
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the folder exists");
    let paths = entries.map(|entry| entry.expect("it can be read").path());
    let (folders, files): (Vec<_>, Vec<_>) = paths.partition(|path| path.is_dir());
    let below = folders.iter().flat_map(|folder| self::files(folder));
    files
        .into_iter()
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .chain(below)
        .collect()
}

/// The statements `use …;` and `pub use …;` in a text, one path each, and whether each is public.
fn uses(text: &str) -> Vec<(bool, String)> {
    let mut found = Vec::new();
    let mut lines = text.lines().map(|line| line.split("//").next().unwrap_or(""));
    while let Some(line) = lines.next() {
        let is_public = line.trim_start().starts_with("pub");
        let statement =
            line.trim_start().trim_start_matches("pub(crate) ").trim_start_matches("pub ");
        let Some(begin) = statement.strip_prefix("use ") else { continue };
        let mut tree = begin.to_string();
        while !tree.contains(';') {
            tree += lines.next().expect("a statement ends").trim();
        }
        let tree = tree.split(';').next().unwrap_or("");
        found.extend(expand(tree).into_iter().map(|path| (is_public, path)));
    }
    found
}

/// Expands `a::{b, c::{d, e}}` to `a::b`, `a::c::d` and `a::c::e`, without `as` names.
fn expand(tree: &str) -> Vec<String> {
    let Some(open) = tree.find('{') else {
        let path = tree.split(" as ").next().unwrap_or(tree).trim();
        return vec![path.trim_end_matches("::self").to_string()];
    };
    let (prefix, rest) =
        (tree[..open].trim(), &tree[open + 1..tree.rfind('}').unwrap_or(tree.len())]);
    let (mut depth, mut begin, mut parts) = (0, 0, Vec::new());
    for (i, c) in rest.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&rest[begin..i]);
                begin = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&rest[begin..]);
    let parts = parts.into_iter().map(str::trim).filter(|part| !part.is_empty());
    parts.flat_map(|part| expand(&format!("{prefix}{part}"))).collect()
}

/// All paths in a module's code, from the root: its imports, and paths in expressions that start
/// with `crate::`.
fn paths(module: &str, text: &str) -> Vec<String> {
    let mut all: Vec<_> = uses(text).into_iter().map(|(_, path)| absolute(module, &path)).collect();
    let code = text.lines().map(|line| line.split("//").next().unwrap_or(""));
    for line in code.filter(|line| !line.trim_start().starts_with("use ")) {
        for part in line.split("crate::").skip(1) {
            let end = part.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
            all.push(part[..end.unwrap_or(part.len())].trim_end_matches(':').to_string());
        }
    }
    all
}

/// Makes a module's path absolute. In a unit test's module, `super` is the file itself.
fn absolute(module: &str, path: &str) -> String {
    let mut place: Vec<&str> =
        if module == "lib" { Vec::new() } else { module.split("::").collect() };
    let mut parts: Vec<&str> = path.split("::").collect();
    match parts[0] {
        "crate" => return parts[1..].join("::"),
        "self" => {
            parts.remove(0);
        }
        "super" => {
            while parts.first() == Some(&"super") {
                parts.remove(0);
                place.pop();
            }
        }
        _ => {}
    }
    place.extend(parts);
    place.join("::")
}

/// The names a module re-exports, with their paths.
fn exports(module: &str, text: &str) -> BTreeMap<String, String> {
    let public = uses(text).into_iter().filter(|(is_public, _)| *is_public);
    let named = public.map(|(_, path)| {
        let path = absolute(module, &path);
        (path.rsplit("::").next().unwrap_or(&path).to_string(), path)
    });
    named.collect()
}

/// The file that a path leads to, following re-exports.
fn file(
    path: &str,
    files: &BTreeSet<Module>,
    exports: &BTreeMap<Module, BTreeMap<String, String>>,
) -> Option<Module> {
    let parts: Vec<&str> = path.split("::").collect();
    let longest =
        (0..=parts.len()).rev().map(|n| if n == 0 { "lib".into() } else { parts[..n].join("::") });
    let module = longest.into_iter().find(|prefix| files.contains(prefix))?;
    let depth = if module == "lib" { 0 } else { module.split("::").count() };
    let name = parts.get(depth).copied().unwrap_or("");
    match exports.get(&module).and_then(|names| names.get(name)) {
        Some(target) if target != path => file(target, files, exports),
        _ if module == "lib" => None,
        _ => Some(module),
    }
}

#[test]
fn imports_go_down_only() {
    let upward = Imports::of_engine().upward();
    assert!(upward.is_empty(), "{upward:#?}");
}

#[test]
fn files_form_no_circle() {
    let packages =
        ["", "crates/cli/", "crates/files/", "crates/metrics/", "crates/python/", "crates/view/"];
    run_cases(packages, |package| match Imports::of(&format!("{package}src")).circles() {
        none if none.is_empty() => Ok(()),
        circles => Err(format!("{circles:#?}")),
    });
}

/// The checks above must detect violations.
#[test]
fn an_import_that_goes_up_and_a_circle_are_found() {
    let imports = Imports::of_engine();
    let total: usize = imports.0.values().map(BTreeSet::len).sum();
    assert!(imports.0.len() > 60 && total > 200, "{} files, {total} imports", imports.0.len());
    let with = |from: &str, to: &str| {
        let mut imports = Imports::of_engine();
        assert!(imports.0.contains_key(to), "{to} is no file");
        imports.0.get_mut(from).expect(from).insert(to.into());
        imports
    };
    assert_eq!(with("plan::tiles", "ops::head").upward(), ["plan::tiles uses ops::head"]);
    let circle = with("model::operators", "model::fuse").circles();
    assert!(circle.iter().any(|modules| modules.starts_with("model::fuse and")), "{circle:?}");
    let text = "use crate::{a, b::{self, c}};\npub use super::d::E as F;";
    assert_eq!(paths("ops::x", text), ["a", "b", "b::c", "ops::d::E"]);
}

/// An operator consists of a shader, a host side, a reference and a test with the same name.
#[test]
fn every_operator_has_its_four_files() {
    run_cases(Op::NAMES, |name| four_files(name));
    check_cases(["no_such_operator"], |name| four_files(name)).expect_err("it has no file");
}

fn four_files(name: &str) -> Result<(), String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shader = [format!("shaders/{name}.wgsl"), format!("shaders/{name}_tiled.wgsl")];
    let ops = [format!("src/ops/{name}.rs"), format!("src/ops/{name}/mod.rs")];
    let reference = [format!("src/reference/{name}.rs")];
    let test = [format!("tests/ops/{name}.rs")];
    // Concat moves no data, so it has no kernel.
    let rooms: &[&[String]] = if name == "concat" {
        &[&ops, &reference, &test]
    } else {
        &[&shader, &ops, &reference, &test]
    };
    let missing = rooms.iter().filter(|files| !files.iter().any(|file| root.join(file).is_file()));
    match missing.map(|files| files[0].clone()).collect::<Vec<_>>() {
        none if none.is_empty() => Ok(()),
        missing => Err(format!("{missing:?} missing")),
    }
}
