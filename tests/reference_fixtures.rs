//! Compares the CPU reference with `PyTorch`'s results, stored by `training/make_fixtures.py`.
//!
//! Both compute in 64 bits and round to 32, so operators may differ by one rounding and no more.

use wgdenoise::internals::model::Weights;
use wgdenoise::internals::model::fold::{BatchNorm, fold};
use wgdenoise::internals::reference::{self, LARGEST, Light, Repaired, Tensor};
use wgdenoise::{Image, Result};
use wgdenoise_testing::fixture::Fixture;
use wgdenoise_testing::{Tolerance, image_tensor};

/// For operators that only move values.
const EXACT: Tolerance = Tolerance { absolute: 0.0, relative: 0.0 };
/// The two 64-bit results may lie on either side of a 32-bit rounding boundary; near 0, sums of
/// values around 1 differ by their own 64-bit rounding.
const ONE_ROUNDING: Tolerance = Tolerance { absolute: 1e-14, relative: f32::EPSILON };
/// Folding rounds each of a sum's 45 weights to 32 bits, with an error of up to 2⁻²⁴ of a product
/// of about 1; such errors grow like the square root of their number.
const FOLDED: Tolerance = Tolerance { absolute: 1e-6, relative: 0.0 };
/// About ten layers, each of which rounds its folded weights and its results to 32 bits; the
/// sigmoid then reduces the error to at most a quarter. It is below 1e-7 for this file.
const WHOLE_NETWORK: Tolerance = Tolerance { absolute: 5e-7, relative: 0.0 };

/// As in [`WHOLE_NETWORK`], without a sigmoid; a logit's error is the relative error of a weight.
const KERNEL_PYRAMID: Tolerance = Tolerance { absolute: 0.0, relative: 5e-6 };

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

/// Holes, suns, fireflies and negative light. In both implementations, the mean of up to 24 values
/// of at most 1e35, and a scale, round a few times.
#[test]
fn repair() -> Result<()> {
    let f = Fixture::open("repair");
    let scale = f.values("scale")[0];
    let Repaired { color, valid } = reference::repair(&f.image("color")?, scale, 256.0);
    f.expect("expected", &image_tensor(&color), Tolerance { absolute: 1e-6, relative: 1e-6 });
    let valid = Tensor::from_fn(1, 12, 16, |_, y, x| f32::from(u8::from(valid[y * 16 + x])));
    f.expect("valid", &valid, EXACT);
    Ok(())
}

#[test]
fn pyramid() {
    let f = Fixture::open("pyramid");
    let (color, valid) = color(&f.tensor("light"));
    let level0 = reference::finest(&color, &valid, &f.tensor("logits0"));
    f.expect("expected0", &flat(&level0), ONE_ROUNDING);
    f.expect("expected1", &flat(&reference::pyramid(&level0, &f.tensor("logits1"))), ONE_ROUNDING);
}

#[test]
fn gather() {
    let f = Fixture::open("gather");
    let (light, logits) = (light(&f.tensor("light")), f.tensor("logits"));
    f.expect("expected_bottom", &flat(&reference::gather(&light, &logits, None)), ONE_ROUNDING);
    let coarser = self::light(&f.tensor("coarser"));
    f.expect("expected", &flat(&reference::gather(&light, &logits, Some(&coarser))), ONE_ROUNDING);
}

/// The image and the valid pixels in `[4, h, w]`.
fn color(light: &Tensor) -> (Image, Vec<bool>) {
    let pixels = light_pixels(light);
    let (colors, valid) = pixels.iter().map(|p| ([p[0], p[1], p[2]], p[3] == 1.0)).unzip();
    let (width, height) = (light.width as u32, light.height as u32);
    (Image::new(width, height, colors).expect("the sizes match"), valid)
}

fn light_pixels(light: &Tensor) -> Vec<[f32; 4]> {
    let place = |i: usize| std::array::from_fn(|c| light.at(c, i / light.width, i % light.width));
    (0..light.width * light.height).map(place).collect()
}

fn light(light: &Tensor) -> Light {
    let pixels = light_pixels(light).iter().map(|pixel| pixel.map(f64::from)).collect();
    Light { width: light.width, height: light.height, pixels }
}

fn flat(light: &Light) -> Tensor {
    Tensor::from_fn(4, light.height, light.width, |c, y, x| light.at(x as i64, y as i64)[c] as f32)
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

/// A kernel pyramid from its weights file. Colors lie between 0.01 and 100.
#[test]
fn a_whole_kernel_pyramid_from_its_weights_file() -> Result<()> {
    let weights = Weights::from_bytes(&Fixture::open("kernel_tiny").bytes)?;
    let f = Fixture::open("kernel_tiny_io");
    let (network, params) = (weights.network(), |layer: &str| weights.params(layer));
    let logits = reference::run_by(network, params, &f.tensor("input"), reference::apply);
    let (color, valid) = color(&f.tensor("light"));
    let found = image_tensor(&reference::kernel_pyramid(&logits, &color, &valid, None));
    f.expect("expected", &found, KERNEL_PYRAMID);
    Ok(())
}

/// The gathered albedo has the same error as light, and so has the texture, at most.
const DEMODULATING: Tolerance =
    Tolerance { absolute: 0.0, relative: 2.0 * KERNEL_PYRAMID.relative };

/// Three levels, with sides that are not multiples of 4.
#[test]
fn a_demodulating_kernel_pyramid_from_its_weights_file() -> Result<()> {
    let weights = Weights::from_bytes(&Fixture::open("demodulating_tiny").bytes)?;
    let f = Fixture::open("demodulating_tiny_io");
    let network = weights.network();
    let input = padded(&f.tensor("input"), network.alignment() as usize);
    let logits =
        reference::run_by(network, |layer| weights.params(layer), &input, reference::apply);
    let (color, valid) = color(&f.tensor("light"));
    let pixel = |i: u32| {
        let (x, y) = ((i % color.width()) as usize, (i / color.width()) as usize);
        [3, 4, 5].map(|c| input.at(c, y, x))
    };
    let pixels = (0..color.width() * color.height()).map(pixel).collect();
    let albedo = Image::new(color.width(), color.height(), pixels)?;
    let found = reference::kernel_pyramid(&logits, &color, &valid, Some(&albedo));
    f.expect("expected", &image_tensor(&found), DEMODULATING);
    Ok(())
}

/// Pads a tensor to multiples of `alignment` by repeating its last column and row.
fn padded(tensor: &Tensor, alignment: usize) -> Tensor {
    let [height, width] = [tensor.height, tensor.width];
    let [rows, columns] = [height, width].map(|side| side.next_multiple_of(alignment));
    Tensor::from_fn(tensor.channels, rows, columns, |c, y, x| {
        tensor.at(c, y.min(height - 1), x.min(width - 1))
    })
}
