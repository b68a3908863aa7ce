//! Inputs that break denoisers, the denoisers to test, and what to measure.

pub mod cases;
pub mod engines;
pub mod growth;
pub mod light;
pub mod measure;
