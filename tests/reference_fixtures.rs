//! Compares the CPU reference with `PyTorch`, whose results `training/make_fixtures.py` stored.
//!
//! Both compute in 64 bits and round to 32, so operators may differ by one rounding and no more.

use wgdenoise::Result;
use wgdenoise::internals::model::Weights;
use wgdenoise::internals::model::fold::{BatchNorm, fold};
use wgdenoise::internals::reference::{self, LARGEST, Tensor};
use wgdenoise_testing::Tolerance;
use wgdenoise_testing::fixture::Fixture;

/// For operators that only move values.
const EXACT: Tolerance = Tolerance { absolute: 0.0, relative: 0.0 };
/// The two 64-bit results may lie on either side of a 32-bit rounding boundary; near 0, sums of
/// values around 1 differ by their own 64-bit rounding.
const ONE_ROUNDING: Tolerance = Tolerance { absolute: 1e-14, relative: f32::EPSILON };
/// Folding rounds each of the 45 weights of a sum to 32 bits, with an error of up to 2⁻²⁴ of a
/// product of about 1; such errors add up with the square root of their number.
const FOLDED: Tolerance = Tolerance { absolute: 1e-6, relative: 0.0 };
/// About ten layers, each of which rounds its folded weights and its results to 32 bits; the
/// sigmoid then reduces the error to at most a quarter. It is below 1e-7 for this file.
const WHOLE_NETWORK: Tolerance = Tolerance { absolute: 5e-7, relative: 0.0 };

#[test]
fn conv3x3() {
    let f = Fixture::open("conv3x3");
    let (input, weight, bias) = (f.tensor("input"), f.values("weight"), f.values("bias"));
    f.expect("expected", &reference::conv3x3(&input, &weight, &bias, false), ONE_ROUNDING);
    f.expect("expected_relu", &reference::conv3x3(&input, &weight, &bias, true), ONE_ROUNDING);
}

#[test]
fn conv3x3_with_a_folded_batch_norm() {
    let f = Fixture::open("conv3x3");
    let mut weight = f.values("weight");
    let norm = BatchNorm {
        weight: &f.values("norm.weight"),
        bias: &f.values("norm.bias"),
        mean: &f.values("norm.running_mean"),
        variance: &f.values("norm.running_var"),
        eps: 1e-5,
    };
    let mut bias = vec![0.0; norm.bias.len()];
    fold(&mut weight, &mut bias, &norm);
    let found = reference::conv3x3(&f.tensor("input"), &weight, &bias, true);
    f.expect("expected_norm_relu", &found, FOLDED);
}

#[test]
fn conv1x1() {
    let f = Fixture::open("conv1x1");
    let found = reference::conv1x1(&f.tensor("input"), &f.values("weight"), &f.values("bias"));
    f.expect("expected", &found, ONE_ROUNDING);
}

#[test]
fn conv_transpose() {
    let f = Fixture::open("conv_transpose");
    let (weight, bias) = (f.values("weight"), f.values("bias"));
    let found = reference::conv_transpose(&f.tensor("input"), &weight, &bias);
    f.expect("expected", &found, ONE_ROUNDING);
}

#[test]
fn max_pool() {
    let f = Fixture::open("max_pool");
    f.expect("expected", &reference::max_pool(&f.tensor("input")), EXACT);
}

#[test]
fn concat() {
    let f = Fixture::open("concat");
    f.expect("expected", &reference::concat(&f.tensor("first"), &f.tensor("second")), EXACT);
}

#[test]
fn sigmoid() {
    let f = Fixture::open("sigmoid");
    f.expect("expected", &reference::sigmoid(&f.tensor("input")), ONE_ROUNDING);
}

#[test]
fn transfer_function_and_its_inverse() {
    let f = Fixture::open("transfer");
    let map = |name, function: fn(f64) -> f64| {
        let tensor = f.tensor(name);
        Tensor::from_fn(tensor.channels, tensor.height, tensor.width, |c, y, x| {
            function(f64::from(tensor.at(c, y, x))) as f32
        })
    };
    f.expect("expected", &map("input", |y| reference::pu(y.min(LARGEST))), ONE_ROUNDING);
    f.expect("inverse_expected", &map("inverse_input", reference::pu_inverse), ONE_ROUNDING);
}

#[test]
fn autoexposure() -> Result<()> {
    let f = Fixture::open("autoexposure");
    for (input, expected) in [("input", "expected"), ("black_input", "black_expected")] {
        let found = Tensor::new(1, 1, 1, vec![reference::autoexposure(&f.image(input)?)]);
        f.expect(expected, &found, ONE_ROUNDING);
    }
    Ok(())
}

#[test]
fn a_whole_network_from_its_weights_file() -> Result<()> {
    let weights = Weights::from_bytes(&Fixture::open("unet_tiny").bytes)?;
    let f = Fixture::open("unet_tiny_io");
    let params = |layer: &str| weights.params(layer);
    let found = reference::run(weights.network(), params, &f.tensor("input"));
    f.expect("expected", &found, WHOLE_NETWORK);
    Ok(())
}
