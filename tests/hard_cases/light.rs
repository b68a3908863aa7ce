//! Every built-in tier preserves light of any hue, brightness and pattern.

use wgdenoise::{Precision, Quality};

use crate::weights;
use wgdenoise_testing::gpu::gpu;
use wgdenoise_testing::hard_cases::cases::{By, noisy};
use wgdenoise_testing::hard_cases::engines::engine;
use wgdenoise_testing::hard_cases::light::light;
use wgdenoise_testing::hard_cases::measure::measure;
use wgdenoise_testing::run_cases;

#[test]
fn every_tier_keeps_light() {
    for quality in Quality::ALL {
        let denoise = engine(gpu(), &weights(quality), Precision::F16, None);
        let sound = denoise(&noisy());
        run_cases(light(), |case| {
            let bound = case.bound(By::F16);
            let found = measure(case, &denoise(&case.color), &sound);
            // `<=` rather than `>`, because comparisons with NaN are false.
            let name = quality.name();
            if found <= bound {
                Ok(())
            } else {
                Err(format!("{name}: {found:e}, at most {bound:e}"))
            }
        });
    }
}
