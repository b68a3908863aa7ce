//! Picks the built-in weights that meet a time budget on a device.

use std::time::Duration;

use super::frames::measure;
use crate::denoiser::Denoiser;
use crate::denoiser::options::Options;
use crate::error::Result;
use crate::model::{Quality, Weights};

/// The time of a frame: a fixed part plus a part per pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Seconds per frame, independent of its size.
    pub fixed: f64,
    /// Seconds per pixel.
    pub per_pixel: f64,
}

/// The cost of the built-in weights on one device, with one precision and kernel set.
///
/// This is plain data. Measure it once per adapter and driver, and keep it:
///
/// ```
/// use std::time::Duration;
/// use wgdenoise::{Calibration, Cost, Quality};
///
/// let cost = |ms: f64| Cost { fixed: 0.5e-3, per_pixel: ms * 1e-3 / 1e6 };
/// // On a device of the caller's: Calibration::measure(&device, &queue, &Options::default())?
/// let calibration = Calibration::new([
///     (Quality::Fast, cost(5.0)),
///     (Quality::Balanced, cost(12.0)),
///     (Quality::High, cost(30.0)),
/// ]);
/// let (quality, predicted) = calibration.choose(Duration::from_millis(33), 1920, 1080).unwrap();
/// assert_eq!(quality, Quality::Balanced);
/// assert!(predicted < Duration::from_millis(26));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Sorted by rising quality.
    costs: Vec<(Quality, Cost)>,
}

/// Sides of the measured square frames. Two sizes separate the fixed part from the part per pixel;
/// larger ones do so better, but a CPU driver takes seconds for the last one.
const SIDES: [u32; 3] = [256, 512, 1024];

/// A frame that takes this many seconds is large enough to measure the cost per pixel.
const LONG: f64 = 0.1;

/// Runs at each size; the median counts.
const RUNS: u32 = 3;

impl Calibration {
    /// Measures [`Denoiser::denoise`] on whole frames of color, albedo and normal, upload and
    /// readback included, after a warm-up run. Blocks, for half a minute or more on a CPU driver.
    /// Ignores the memory budget and tile size in `options`; they keep their defaults. Each frame
    /// allocates its memory, as a single one does.
    ///
    /// A [`Pass`](crate::Pass) takes less, as it neither uploads nor reads back. The first frame of
    /// a process takes more, as the driver compiles the kernels. Without albedo and normal, the
    /// operations drop by 1 to 4 %.
    ///
    /// # Errors
    /// Fails if the kernels do not run on the device, or if the device fails.
    pub fn measure(device: &wgpu::Device, queue: &wgpu::Queue, options: &Options) -> Result<Self> {
        let default = Options::default();
        let options =
            options.clone().memory_bytes(default.memory_bytes).tile(None).keep_memory(false);
        let cost = |quality| {
            let weights = Weights::builtin(quality)?;
            let cost = Cost::measure(&Denoiser::new(device, queue, &weights, &options)?)?;
            Ok((quality, cost))
        };
        let costs = Quality::built_in().into_iter().map(cost).collect::<Result<Vec<_>>>()?;
        Ok(Self::new(costs))
    }

    /// A calibration from earlier measurements. If a quality appears twice, its last cost counts.
    #[must_use]
    pub fn new(costs: impl IntoIterator<Item = (Quality, Cost)>) -> Self {
        let given: Vec<_> = costs.into_iter().collect();
        let of = |quality| given.iter().rev().find(|(q, _)| *q == quality).copied();
        Self { costs: Quality::ALL.into_iter().filter_map(of).collect() }
    }

    /// The costs, sorted by rising quality.
    #[must_use]
    pub fn costs(&self) -> &[(Quality, Cost)] {
        &self.costs
    }

    /// The cost of built-in weights; `None` if they were not measured.
    #[must_use]
    pub fn cost(&self, quality: Quality) -> Option<Cost> {
        self.costs.iter().find(|(q, _)| *q == quality).map(|(_, cost)| *cost)
    }

    /// The best weights predicted to take at most `budget` per frame of this size, with the
    /// prediction. If none fit, the cheapest, whose prediction exceeds the budget. `None` if
    /// nothing was measured.
    ///
    /// Frames cut into several tiles take longer than predicted: see [`Cost::predict`].
    #[must_use]
    pub fn choose(&self, budget: Duration, width: u32, height: u32) -> Option<(Quality, Duration)> {
        let pixels = u64::from(width) * u64::from(height);
        let of = |(quality, cost): &(Quality, Cost)| (*quality, cost.predict(pixels));
        let best = self.costs.iter().rev().map(of).find(|(_, time)| *time <= budget);
        best.or_else(|| self.costs.first().map(of))
    }
}

impl Cost {
    /// Predicts the time of a frame with this many computed pixels. Tiles overlap, so a frame cut
    /// into several counts the pixels of all its tiles ([`Denoiser::tile_plan`]). A result that is
    /// not a duration, such as one from a negative cost, becomes [`Duration::MAX`].
    #[must_use]
    pub fn predict(&self, pixels: u64) -> Duration {
        let seconds = self.fixed + self.per_pixel * pixels as f64;
        Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
    }

    fn measure(denoiser: &Denoiser) -> Result<Self> {
        let mut points = Vec::new();
        for side in SIDES {
            let seconds = measure(denoiser, side, side, RUNS)?.median();
            points.push((f64::from(side).powi(2), seconds));
            if points.len() > 1 && seconds > LONG {
                break;
            }
        }
        Ok(Self::through(points[0], points[points.len() - 1]))
    }

    /// Fits the line through a small and a large frame, each `(pixels, seconds)`. Noise must not
    /// make a part negative: if the fit does, the other part takes everything.
    fn through(small: (f64, f64), large: (f64, f64)) -> Self {
        let per_pixel = ((large.1 - small.1) / (large.0 - small.0)).max(0.0);
        let fixed = large.1 - per_pixel * large.0;
        if fixed < 0.0 {
            return Self { fixed: 0.0, per_pixel: large.1 / large.0 };
        }
        Self { fixed, per_pixel }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fixed parts of 1, 10 and 100 ms; 1, 4 and 20 ms per megapixel.
    fn made_up() -> Calibration {
        let cost = |fixed, per_pixel| Cost { fixed, per_pixel };
        Calibration::new([
            (Quality::High, cost(100e-3, 20e-9)),
            (Quality::Fast, cost(1e-3, 1e-9)),
            (Quality::Balanced, cost(10e-3, 4e-9)),
        ])
    }

    fn chosen(budget_us: u64, width: u32, height: u32) -> (Quality, u128) {
        let budget = Duration::from_micros(budget_us);
        let (quality, time) = made_up().choose(budget, width, height).expect("there are costs");
        (quality, time.as_micros())
    }

    #[test]
    fn the_best_weights_within_the_budget_are_chosen() {
        assert_eq!(chosen(120_000, 1000, 1000), (Quality::High, 120_000));
        assert_eq!(chosen(119_999, 1000, 1000), (Quality::Balanced, 14_000));
        assert_eq!(chosen(120_000, 1001, 1000), (Quality::Balanced, 14_004));
        assert_eq!(chosen(13_999, 1000, 1000), (Quality::Fast, 2_000));
    }

    #[test]
    fn the_fastest_is_chosen_if_none_meets_the_budget() {
        assert_eq!(chosen(1_999, 1000, 1000), (Quality::Fast, 2_000));
        assert_eq!(chosen(0, 65_536, 65_536), (Quality::Fast, 4_295_967));
        let broken = Cost { fixed: f64::NAN, per_pixel: 0.0 };
        let both = [(Quality::Balanced, broken), (Quality::High, broken)];
        let broken = Calibration::new(made_up().costs().iter().copied().chain(both));
        let chosen = broken.choose(Duration::from_secs(9), 1, 1);
        assert_eq!(chosen.map(|(quality, _)| quality), Some(Quality::Fast));
        assert_eq!(Calibration::new([]).choose(Duration::MAX, 1, 1), None);
    }

    #[test]
    fn a_line_through_two_frames_gives_both_parts() {
        let cost = Cost::through((100.0, 3.0), (400.0, 6.0));
        assert!((cost.fixed - 2.0).abs() < 1e-12 && (cost.per_pixel - 0.01).abs() < 1e-12);
    }

    #[test]
    fn noise_makes_no_part_negative() {
        let superlinear = Cost { fixed: 0.0, per_pixel: 0.015 };
        assert_eq!(Cost::through((100.0, 1.0), (400.0, 6.0)), superlinear);
        let falling = Cost { fixed: 1.0, per_pixel: 0.0 };
        assert_eq!(Cost::through((100.0, 2.0), (400.0, 1.0)), falling);
    }
}
