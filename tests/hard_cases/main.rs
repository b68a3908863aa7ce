//! Inputs that break denoisers, with bounds on the results. The table is in `cases.rs`;
//! `docs/hard-cases.md` compares the results with Open Image Denoise's.

mod growth;
mod highlights;
mod light;

use wgdenoise::{Image, Precision, Quality, Weights};

use wgdenoise_testing::gpu::{gpu, has_halves};
use wgdenoise_testing::hard_cases::cases::{By, Case, cases, noisy};
use wgdenoise_testing::hard_cases::engines::{engine, half_engine, on_cpu};
use wgdenoise_testing::hard_cases::measure::measure;
use wgdenoise_testing::run_cases;

fn weights(quality: Quality) -> Weights {
    Weights::builtin(quality).expect("they are built in")
}

/// Asserts that every case stays within its bound.
fn hold(by: By, denoise: impl Fn(&Image) -> Image) {
    hold_in(cases(), by, denoise);
}

fn hold_in(cases: Vec<Case>, by: By, denoise: impl Fn(&Image) -> Image) {
    let sound = denoise(&noisy());
    run_cases(cases, |case| {
        let (found, bound) = (measure(case, &denoise(&case.color), &sound), case.bound(by));
        // `<=` rather than `>`, because comparisons with NaN are false.
        if found <= bound { Ok(()) } else { Err(format!("{found:e}, at most {bound:e}")) }
    });
}

#[test]
fn every_case_holds_with_16_bit_tensors() {
    hold(By::F16, engine(gpu(), &weights(Quality::Balanced), Precision::F16, None));
}

#[test]
fn every_case_holds_with_32_bit_tensors() {
    hold(By::F32, engine(gpu(), &weights(Quality::Balanced), Precision::F32, None));
}

/// Uses images with light near or beyond the range of 16-bit floats.
#[test]
fn bright_cases_hold_in_16_bit_arithmetic() {
    let is_bright = |case: &Case| case.color.pixels().iter().flatten().any(|v| *v >= 65504.0);
    let bright: Vec<_> = cases().into_iter().filter(is_bright).collect();
    assert!(bright.len() > 10, "only {} cases are bright", bright.len());
    if has_halves() {
        hold_in(bright, By::F16, half_engine(gpu(), &weights(Quality::Balanced)));
    }
}

/// Uses the smallest weights, because the CPU reference is slow.
#[test]
fn every_case_holds_in_the_reference() {
    hold(By::FastReference, |color| on_cpu(&weights(Quality::Fast), color));
}

#[test]
fn tiles_make_the_same_bits_as_the_whole_image() {
    let [whole, tiled] =
        [None, Some(288)].map(|tile| engine(gpu(), &weights(Quality::Fast), Precision::F16, tile));
    let bits =
        |image: &Image| -> Vec<_> { image.pixels().iter().map(|p| p.map(f32::to_bits)).collect() };
    let mut cut = 0;
    run_cases(cases(), |case| {
        let color = repeated(&case.color);
        cut += usize::from(color.width().max(color.height()) > 288);
        let same = bits(&whole(&color)) == bits(&tiled(&color));
        if same { Ok(()) } else { Err("tiles change the result".into()) }
    });
    assert!(cut > 40, "only {cut} pictures are cut");
}

/// The image repeated three by three, to need several tiles.
fn repeated(image: &Image) -> Image {
    let (width, height) = image.size();
    let pixels = (0..3 * height).flat_map(|y| image.row(y % height).repeat(3)).collect();
    Image::new(3 * width, 3 * height, pixels).expect("the count is right")
}
