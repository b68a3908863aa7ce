//! What can be wrong with shader modules.

/// Why a kernel could not be composed.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("shader module {module}: {problem}")]
pub struct ComposeError {
    /// The module at fault, as a path below `shaders/`.
    pub module: String,
    /// What is wrong with it.
    pub problem: Problem,
}

/// What can be wrong with a module.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// A bracket, comment or statement has no end, or a bracket has no beginning.
    #[error("unbalanced brackets, or a comment or statement without an end")]
    Unbalanced,
    /// A condition that is not made of features, `!`, `&&`, `||` and parentheses.
    #[error("malformed condition `{0}`")]
    Condition(String),
    /// A feature that is not declared.
    #[error("unknown feature `{0}`")]
    UnknownFeature(String),
    /// An `@elif` or `@else` that does not follow an `@if` or `@elif`.
    #[error("`@elif` or `@else` without `@if`")]
    NoIf,
    /// An import that is not `import package::path::name;` or `import package::path::{a, b};`.
    #[error("malformed import `{0}`")]
    Import(String),
    /// It is imported and does not exist.
    #[error("no such module")]
    UnknownModule,
    /// An import of a name that its module does not declare under the enabled features.
    #[error("imports `{name}`, which `{module}` does not declare")]
    UnknownName {
        /// The imported module.
        module: String,
        /// The missing name.
        name: String,
    },
}
