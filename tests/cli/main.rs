//! The real binary on files as renderers write them; `tests/data` says how they were made.
#![cfg(feature = "cli")]

mod budget;
mod commands;
mod denoise;
mod failures;
mod ldr;
mod oidn;
mod pipelines;
mod report;
mod support;
