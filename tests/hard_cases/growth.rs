//! Growth of rounding errors through the layers.

use wgdenoise::{Precision, Quality, Weights};
use wgdenoise_testing::hard_cases::growth::{growth, inputs_to_grow, rounding};

/// Each layer adds its own rounding to its input's error, as in a random walk, and passes on an
/// error of about the same size. A layer may reach eight times the length of that walk, since sums
/// that cancel amplify the relative error.
#[test]
fn rounding_grows_no_faster_than_a_random_walk() {
    let weights = Weights::builtin(Quality::Fast).expect("they are built in");
    for precision in [Precision::F32, Precision::F16] {
        for (name, color) in inputs_to_grow() {
            for (steps, (layer, error)) in (1..).zip(growth(&weights, &color, precision)) {
                let walk = f64::from(steps).sqrt() * rounding(precision);
                println!("{precision:?} {name}: {layer} {:.2}", error / walk);
                assert!(error <= 8.0 * walk, "{precision:?}, {name}, {layer}: {error:e}");
            }
        }
    }
}
