//! Inputs that break denoisers: what they are, what denoises them, and what is measured.

pub mod cases;
pub mod engines;
pub mod growth;
pub mod measure;
