//! Shared test code: comparisons, single operators on the adapter, images in every format, and the
//! hard cases. `tests/harness.rs` shows that each comparison can fail.

#![allow(
    missing_docs,
    clippy::missing_errors_doc,
    clippy::missing_panics_doc,
    clippy::must_use_candidate,
    reason = "not published: its users are the tests beside it, and a panic is how a test fails"
)]

pub mod fixture;
pub mod gpu;
pub mod hard_cases;
pub mod image;
pub mod pixels;
pub mod random;
pub mod run;

pub use random::Random;

use std::fmt::Debug;
use wgdenoise::Image;
use wgdenoise::internals::reference::Tensor;

/// The allowed distance from the expected value: `absolute + relative · |expected|`.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    pub absolute: f32,
    pub relative: f32,
}

/// Fails with the worst element, unless all are within the tolerance.
#[track_caller]
pub fn assert_close(name: &str, found: &Tensor, expected: &Tensor, tolerance: Tolerance) {
    if let Err(message) = compare(found, expected, tolerance) {
        panic!("{name}: {message}");
    }
}

/// Like [`assert_close`], but returns the message.
///
/// NaN and infinity never match anything, themselves included. Empty tensors never match either,
/// since nothing was compared.
pub fn compare(found: &Tensor, expected: &Tensor, tolerance: Tolerance) -> Result<(), String> {
    if found.shape() != expected.shape() {
        return Err(format!("shape {:?}, expected {:?}", found.shape(), expected.shape()));
    }
    if found.data.len() != expected.data.len() || found.data.is_empty() {
        let counts = (found.data.len(), expected.data.len());
        return Err(format!("{} values against {}: nothing to compare", counts.0, counts.1));
    }
    let excess = |i: usize| excess(found.data[i], expected.data[i], tolerance);
    // Tests for "not close" rather than "too far": every comparison with NaN is false.
    let close = |i: usize| excess(i) <= 0.0;
    let wrong = (0..found.data.len()).filter(|&i| !close(i));
    let (count, worst) = wrong.fold((0, None), |(count, worst), i| {
        (count + 1, worst.filter(|&w| excess(w).is_nan() || excess(w) >= excess(i)).or(Some(i)))
    });
    match worst {
        None => Ok(()),
        Some(i) => Err(describe(found, expected, tolerance, i, count)),
    }
}

/// How far the error exceeds the tolerance; NaN or ∞ if either value is not finite.
fn excess(found: f32, expected: f32, tolerance: Tolerance) -> f64 {
    let (found, expected) = (f64::from(found), f64::from(expected));
    let allowed = f64::from(tolerance.absolute) + f64::from(tolerance.relative) * expected.abs();
    // Subtracting before comparing turns ∞ − ∞ into NaN.
    (found - expected).abs() - allowed
}

fn describe(
    found: &Tensor,
    expected: &Tensor,
    tolerance: Tolerance,
    worst: usize,
    count: usize,
) -> String {
    let (x, y) = (worst % found.width, worst / found.width % found.height);
    let channel = worst / (found.width * found.height);
    let (all, found, expected) = (found.data.len(), found.data[worst], expected.data[worst]);
    format!(
        "{count} of {all} values are off; the worst is at channel {channel}, row {y}, \
         column {x}: found {found:?}, expected {expected:?}, error {:e}, {tolerance:?}",
        (found - expected).abs()
    )
}

/// Runs every case of a table, then fails with a list of the failed ones.
#[track_caller]
pub fn run_cases<C: Debug>(
    cases: impl IntoIterator<Item = C>,
    check: impl FnMut(&C) -> Result<(), String>,
) {
    if let Err(message) = check_cases(cases, check) {
        panic!("{message}");
    }
}

/// Like [`run_cases`], but returns the message. A table without cases fails too.
pub fn check_cases<C: Debug>(
    cases: impl IntoIterator<Item = C>,
    mut check: impl FnMut(&C) -> Result<(), String>,
) -> Result<(), String> {
    let mut failures = Vec::new();
    let mut count = 0;
    for case in cases {
        count += 1;
        if let Err(message) = check(&case) {
            failures.push(format!("  {case:?}: {message}"));
        }
    }
    match (count, failures.len()) {
        (0, _) => Err("the table has no cases, so nothing was tested".into()),
        (_, 0) => Ok(()),
        (_, failed) => Err(format!("{failed} of {count} cases failed:\n{}", failures.join("\n"))),
    }
}

/// Converts an image to a tensor `[3, height, width]`, for comparisons.
pub fn image_tensor(image: &Image) -> Tensor {
    let (width, height) = image.size();
    Tensor::from_fn(3, height as usize, width as usize, |c, y, x| image.row(y as u32)[x][c])
}
