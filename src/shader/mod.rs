//! Composes the modules of `shaders/` into the WGSL of one kernel.
//!
//! Modules are written in a subset of [WESL](https://wesl-lang.dev): `import` of declarations by
//! name, and `@if`, `@elif` and `@else` on imports, declarations and statements. `shaders/README.md`
//! describes the subset. Names are never changed, so a name means one thing in a whole kernel.

mod composer;
mod conditions;
mod library;
mod problem;
mod syntax;

pub use composer::{Library, ShaderRoot};
pub use library::LIBRARY;
pub use problem::{ComposeError, Problem};
