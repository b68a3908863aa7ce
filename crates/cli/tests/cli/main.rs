//! The real binary on files as renderers write them; `tests/data` has the script that made them.

mod budget;
mod commands;
mod denoise;
mod failures;
#[cfg(target_os = "linux")]
mod faults;
#[cfg(target_os = "linux")]
mod hostile;
mod ldr;
mod oidn;
#[cfg(target_os = "linux")]
mod outputs;
mod pipelines;
mod preview;
mod report;
mod sequence;
mod support;
