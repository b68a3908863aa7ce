//! The built-in weights, end to end, compared with `PyTorch`, which trained them.

use wgdenoise::internals::reference;
use wgdenoise::{Denoiser, Frame, Options, Precision, Quality, Result, Weights};

use crate::support::{F32, encoded};
use wgdenoise_testing::fixture::Fixture;
use wgdenoise_testing::gpu::gpu;
use wgdenoise_testing::{compare, run_cases};

const TIERS: [(&str, Quality); 3] =
    [("fast", Quality::Fast), ("balanced", Quality::Balanced), ("high", Quality::High)];

#[test]
fn every_tier_denoises_as_it_did_where_it_was_trained() -> Result<()> {
    let f = Fixture::open("shipped");
    let [color, albedo, normal] = ["color", "albedo", "normal"].map(|name| f.image(name));
    let (color, albedo, normal) = (color?, albedo?, normal?);
    let scale = reference::autoexposure(&color);
    let frame = Frame::new(&color).albedo(&albedo).normal(&normal);
    let options = Options::default().precision(Precision::F32);
    run_cases(TIERS, |&(name, quality)| {
        let weights = Weights::builtin(quality).map_err(|e| e.to_string())?;
        let (device, queue) = (&gpu().device, &gpu().queue);
        let denoiser =
            Denoiser::new(device, queue, &weights, &options).map_err(|e| e.to_string())?;
        let found = denoiser.denoise(&frame).map_err(|e| e.to_string())?;
        let expected = f.image(&format!("expected.{name}")).map_err(|e| e.to_string())?;
        compare(&encoded(&found, scale), &encoded(&expected, scale), F32)
    });
    Ok(())
}
