//! Errors in shader modules.

/// A kernel that cannot be composed, and why.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("shader module {module}: {problem}")]
pub struct ComposeError {
    /// The module at fault, as a path below `shaders/`.
    pub module: String,
    /// The problem with it.
    pub problem: Problem,
}

/// An error in a module.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// A bracket, comment or statement without an end, or a closing bracket without a start.
    #[error("unbalanced brackets, or a comment or statement without an end")]
    Unbalanced,
    /// A condition made of anything but features, `!`, `&&`, `||` and parentheses.
    #[error("malformed condition `{0}`")]
    Condition(String),
    /// An undeclared feature.
    #[error("unknown feature `{0}`")]
    UnknownFeature(String),
    /// An `@elif` or `@else` that does not follow an `@if` or `@elif`.
    #[error("`@elif` or `@else` without `@if`")]
    NoIf,
    /// An import not of the form `import package::path::name;` or `import package::path::{a, b};`.
    #[error("malformed import `{0}`")]
    Import(String),
    /// An imported module that does not exist.
    #[error("no such module")]
    UnknownModule,
    /// An imported name that its module does not declare with the enabled features.
    #[error("imports `{name}`, which `{module}` does not declare")]
    UnknownName {
        /// The imported module.
        module: String,
        /// The missing name.
        name: String,
    },
}
