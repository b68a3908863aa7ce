//! Runs the real binary on files as renderers write them; `tests/data` has the script that made
//! them.

mod budget;
mod commands;
mod denoise;
mod failures;
mod farm;
#[cfg(target_os = "linux")]
mod faults;
#[cfg(target_os = "linux")]
mod hostile;
mod layers;
mod ldr;
#[cfg(target_os = "linux")]
mod names;
mod oidn;
#[cfg(target_os = "linux")]
mod outputs;
mod pipelines;
#[cfg(target_os = "linux")]
mod pipes;
mod preview;
mod report;
mod sequence;
#[cfg(target_os = "linux")]
mod stopped;
mod support;
mod temporal;
