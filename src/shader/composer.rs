//! From a root module and all that it imports to one text.

use super::conditions::{Features, select};
use super::problem::{ComposeError, Problem};
use super::syntax::{declared_name, first_word, split_node, without_comments};

/// The text a kernel starts from: its root module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ShaderRoot {
    /// A file of `shaders/`, without `.wgsl`.
    Module(&'static str),
    /// Generated text, which imports files of `shaders/`.
    Generated(String),
}

impl ShaderRoot {
    fn name(&self) -> &str {
        match self {
            Self::Module(name) => name,
            Self::Generated(_) => "generated",
        }
    }
}

/// Modules that can import each other, and the features that their conditions can name.
#[derive(Clone, Copy, Debug)]
pub struct Library<'a> {
    /// Path below `shaders/` without `.wgsl`, and text.
    pub modules: &'a [(&'a str, &'a str)],
    /// Every feature.
    pub features: &'a [&'a str],
}

impl Library<'_> {
    /// The WGSL of `root` and all that it imports, each module once, for these features.
    ///
    /// # Errors
    /// The first problem found, with its module.
    pub fn compose(&self, root: &ShaderRoot, enabled: &[&str]) -> Result<String, ComposeError> {
        let features = Features { known: self.features, enabled };
        if let Some(unknown) = enabled.iter().find(|name| !self.features.contains(name)) {
            let problem = Problem::UnknownFeature(unknown.to_string());
            return Err(ComposeError { module: root.name().into(), problem });
        }
        let mut linked = vec![match root {
            ShaderRoot::Module(name) => self.module(name, features)?,
            ShaderRoot::Generated(text) => Module::parse(root.name(), text, features)?,
        }];
        let mut next = 0;
        while next < linked.len() {
            for import in linked[next].imports.clone() {
                if linked.iter().all(|module| module.name != import.module) {
                    linked.push(self.module(&import.module, features)?);
                }
            }
            next += 1;
        }
        check_imports(&linked)?;
        Ok(join(&linked))
    }

    fn module(&self, name: &str, features: Features<'_>) -> Result<Module, ComposeError> {
        match self.modules.iter().find(|(module, _)| *module == name) {
            Some((_, text)) => Module::parse(name, text, features),
            None => Err(ComposeError { module: name.into(), problem: Problem::UnknownModule }),
        }
    }
}

/// Every imported name must be declared by the module it is imported from.
fn check_imports(linked: &[Module]) -> Result<(), ComposeError> {
    let declares = |module: &str, name: &str| {
        let module = linked.iter().find(|m| m.name == module);
        module.is_some_and(|m| m.declarations.iter().any(|d| declared_name(d) == name))
    };
    for module in linked {
        for import in &module.imports {
            let missing = import.names.iter().find(|name| !declares(&import.module, name));
            if let Some(name) = missing.cloned() {
                let from = import.module.clone();
                return Err(module.error(Problem::UnknownName { module: from, name }));
            }
        }
    }
    Ok(())
}

/// Directives come before all declarations, each once.
fn join(linked: &[Module]) -> String {
    let mut parts: Vec<&str> = linked.iter().flat_map(|m| &m.directives).map(|d| &**d).collect();
    parts.sort_unstable();
    parts.dedup();
    parts.extend(linked.iter().flat_map(|m| &m.declarations).map(|d| &**d));
    parts.join("\n\n") + "\n"
}

#[derive(Clone)]
struct Import {
    module: String,
    names: Vec<String>,
}

/// A module after its conditions are resolved.
struct Module {
    name: String,
    imports: Vec<Import>,
    directives: Vec<String>,
    declarations: Vec<String>,
}

impl Module {
    fn parse(name: &str, text: &str, features: Features<'_>) -> Result<Self, ComposeError> {
        let mut module = Self {
            name: name.into(),
            imports: Vec::new(),
            directives: Vec::new(),
            declarations: Vec::new(),
        };
        match module.fill(text, features) {
            Ok(()) => Ok(module),
            Err(problem) => Err(module.error(problem)),
        }
    }

    fn fill(&mut self, text: &str, features: Features<'_>) -> Result<(), Problem> {
        let text = select(&without_comments(text)?, features)?;
        let mut rest = text.trim_start();
        while !rest.is_empty() {
            let (node, after) = split_node(rest)?;
            match first_word(node) {
                "import" => self.imports.push(parse_import(node)?),
                "enable" | "requires" | "diagnostic" => self.directives.push(node.into()),
                _ => self.declarations.push(node.into()),
            }
            rest = after.trim_start();
        }
        Ok(())
    }

    fn error(&self, problem: Problem) -> ComposeError {
        ComposeError { module: self.name.clone(), problem }
    }
}

fn parse_import(node: &str) -> Result<Import, Problem> {
    let malformed = || Problem::Import(node.into());
    let path = node.strip_prefix("import").and_then(|path| path.strip_suffix(';'));
    let path = path.and_then(|path| path.trim().strip_prefix("package::")).ok_or_else(malformed)?;
    let (module, names) = match path.strip_suffix('}') {
        Some(list) => list.split_once("::{").ok_or_else(malformed)?,
        None => path.rsplit_once("::").ok_or_else(malformed)?,
    };
    let names = names.split(',').map(str::trim).filter(|name| !name.is_empty());
    Ok(Import { module: module.replace("::", "/"), names: names.map(Into::into).collect() })
}

#[cfg(test)]
#[path = "composer_test.rs"]
mod tests;
