//! The error of the noisy and of the denoised image against a reference.

use wgdenoise::Image;
use wgdenoise_metrics::{Metrics, compare};

/// A table with a row for each figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Figures {
    noisy: Metrics,
    denoised: Option<Metrics>,
}

/// A figure by its name, with a word on how to read it.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) hint: &'static str,
    pub(crate) noisy: String,
    pub(crate) denoised: String,
}

impl Figures {
    /// Compares both images with the reference.
    ///
    /// # Errors
    /// If the sizes differ.
    pub(crate) fn of(
        noisy: &Image,
        denoised: Option<&Image>,
        reference: &Image,
    ) -> Result<Self, String> {
        let against = |image| compare(image, reference).map_err(|error| error.to_string());
        Ok(Self { noisy: against(noisy)?, denoised: denoised.map(against).transpose()? })
    }

    pub(crate) fn rows(&self) -> [Row; 4] {
        let row = |name, hint, shown: fn(&Metrics) -> String| Row {
            name,
            hint,
            noisy: shown(&self.noisy),
            denoised: self.denoised.as_ref().map_or_else(|| "…".into(), shown),
        };
        [
            row("L1", "mean difference of display values; less is better", |m| {
                format!("{:.4}", m.l1)
            }),
            row("PSNR", "of display values; more is better", |m| format!("{:.1} dB", m.psnr)),
            row("SSIM", "structural similarity; 1 is the same", |m| format!("{:.3}", m.ssim)),
            row("relMSE", "of linear light; less is better", |m| format!("{:.4}", m.relmse)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_images_are_compared_and_other_sizes_refused() {
        let image = |v| Image::filled(16, 16, [v; 3]).unwrap();
        let figures = Figures::of(&image(0.3), Some(&image(0.2)), &image(0.2)).unwrap();
        let [l1, psnr, ..] = figures.rows();
        assert_eq!((l1.denoised.as_str(), psnr.denoised.as_str()), ("0.0000", "120.0 dB"));
        assert_ne!(l1.noisy, "0.0000");
        let small = Image::filled(2, 2, [0.0; 3]).unwrap();
        let error = Figures::of(&image(0.3), None, &small).unwrap_err();
        assert!(error.contains("16×16"), "{error}");
    }
}
