//! Decides when a progressive renderer denoises and how much noisy color it keeps.

/// A denoising schedule for a progressive renderer, which shows the denoised image while samples
/// are few and the plain accumulation once they are many.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// Denoise one frame in this many; 0 counts as 1. In between, the output keeps its last image.
    pub every: u32,
    /// Samples per pixel at which noisy and denoised color have equal shares, at least 0.
    /// [`f32::INFINITY`] always shows the denoised image.
    pub half_life: f32,
}

impl Default for Schedule {
    /// Every frame, with equal shares at 256 samples per pixel: there, `fast` and the plain samples
    /// are equally far from the truth in the still life of the example `path_tracer`.
    fn default() -> Self {
        Self { every: 1, half_life: 256.0 }
    }
}

impl Schedule {
    /// Whether to denoise this frame, counted from 0 at the start of the accumulation. The first
    /// frame always is.
    #[must_use]
    pub fn due(&self, frame: u32) -> bool {
        frame.is_multiple_of(self.every.max(1))
    }

    /// The share of noisy color for [`Pass::set_blend`](crate::Pass::set_blend) after `samples`
    /// samples per pixel: `n / (n + half_life)`.
    ///
    /// The denoiser's bias hardly depends on `n`, while the variance of the noise falls with `1/n`.
    /// Among all mixtures of an estimate with squared bias `b²` and an independent, unbiased one
    /// with variance `s²/n`, this one has the least mean squared error if `half_life = s²/b²`. It
    /// converges to the accumulation, so no bias remains.
    #[must_use]
    pub fn blend(&self, samples: u32) -> f32 {
        let samples = samples as f32;
        if self.half_life.is_finite() && self.half_life + samples > 0.0 {
            samples / (samples + self.half_life.max(0.0))
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_third_frame_is_due_from_the_first_on() {
        let schedule = Schedule { every: 3, ..Schedule::default() };
        let due: Vec<_> = (0..7).filter(|&frame| schedule.due(frame)).collect();
        assert_eq!(due, [0, 3, 6]);
        assert!(Schedule { every: 0, ..schedule }.due(5), "0 counts as 1");
    }

    #[test]
    fn the_noisy_share_is_half_at_the_half_life_and_tends_to_one() {
        let schedule = Schedule { every: 1, half_life: 64.0 };
        assert_eq!([0, 64, 192].map(|n| schedule.blend(n)), [0.0, 0.5, 0.75]);
        assert!(schedule.blend(1 << 20) > 0.9999);
        let never = Schedule { half_life: f32::INFINITY, ..schedule };
        assert_eq!(never.blend(u32::MAX), 0.0);
        let at_once = Schedule { half_life: 0.0, ..schedule };
        assert_eq!([0, 1].map(|n| at_once.blend(n)), [0.0, 1.0]);
    }
}
