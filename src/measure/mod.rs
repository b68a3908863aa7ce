//! How long denoising takes: whole frames, single kernel calls, and which built-in weights meet a
//! time budget.

mod calibration;
mod calls;
mod frames;
mod statistics;

pub use calibration::{Calibration, Cost};
pub use calls::CallProfile;
pub use frames::{Timing, measure, profile, test_card};
pub use statistics::{median, repeat};
