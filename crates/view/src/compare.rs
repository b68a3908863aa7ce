//! Figures for the noisy and the denoised image: the error against a reference, and a no-reference
//! score of how noisy they look.

use wgdenoise::Image;
use wgdenoise_metrics::{Metrics, brisque, compare, exposure};

/// A table with a row for each figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Figures {
    errors: Option<Errors>,
    /// Scores of the noisy and the denoised image; `None` if an image has no score.
    scores: [Option<f64>; 2],
}

/// Errors against a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Errors {
    noisy: Metrics,
    denoised: Option<Metrics>,
}

/// A named figure with a hint on how to read it.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) hint: &'static str,
    pub(crate) noisy: String,
    pub(crate) denoised: String,
}

impl Figures {
    /// Compares both images with the reference, if any, and scores them once there is a result.
    ///
    /// # Errors
    /// If the sizes differ.
    pub(crate) fn of(
        noisy: &Image,
        denoised: Option<&Image>,
        reference: Option<&Image>,
    ) -> Result<Self, String> {
        let errors = reference.map(|reference| Errors::of(noisy, denoised, reference));
        // Both use one exposure, that of the cleaner image.
        let exposure = exposure(denoised.unwrap_or(noisy));
        let score = |image: Option<&Image>| brisque(image?, exposure).ok();
        let scores = denoised.map(|denoised| [Some(noisy), Some(denoised)].map(score));
        Ok(Self { errors: errors.transpose()?, scores: scores.unwrap_or_default() })
    }

    /// The rows for all known figures.
    pub(crate) fn rows(&self) -> Vec<Row> {
        let errors = self.errors.iter().flat_map(Errors::rows);
        let shown = |score: Option<f64>| score.map_or_else(|| "…".into(), |s| format!("{s:.0}"));
        let [noisy, denoised] = self.scores.map(shown);
        let brisque = Row { name: "BRISQUE", hint: BRISQUE, noisy, denoised };
        errors.chain(self.scores[1].map(|_| brisque)).collect()
    }
}

/// The row of the mean visible errors.
pub(crate) fn flip_row(means: [f64; 2]) -> Row {
    let [noisy, denoised] = means.map(|mean| format!("{mean:.4}"));
    Row { name: "FLIP", hint: FLIP, noisy, denoised }
}

const FLIP: &str = "mean of how much an eye notices at this exposure when image and reference are shown \
                    in turn: 0 is nothing, 1 the most";

const BRISQUE: &str = "how noisy the picture looks, without a reference: 0 is best, 100 worst. It \
                       tells plainly noisier pictures of one view apart. It cannot say which of two \
                       similar pictures is better, does not see wrong brightness or lost detail, and \
                       scores of different views do not compare";

impl Errors {
    fn of(noisy: &Image, denoised: Option<&Image>, reference: &Image) -> Result<Self, String> {
        let against = |image| compare(image, reference).map_err(|error| error.to_string());
        Ok(Self { noisy: against(noisy)?, denoised: denoised.map(against).transpose()? })
    }

    fn rows(&self) -> [Row; 4] {
        let row = |name, hint, shown: fn(&Metrics) -> String| Row {
            name,
            hint,
            noisy: shown(&self.noisy),
            denoised: self.denoised.as_ref().map_or_else(|| "…".into(), shown),
        };
        [
            row("L1", "mean difference of display values; lower is better", |m| {
                format!("{:.4}", m.l1)
            }),
            row("PSNR", "of display values; higher is better", |m| format!("{:.1} dB", m.psnr)),
            row("SSIM", "structural similarity; 1 is the same", |m| format!("{:.3}", m.ssim)),
            row("relMSE", "of linear light; lower is better", |m| format!("{:.4}", m.relmse)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::open::Opened;

    #[test]
    fn both_images_are_compared_and_other_sizes_refused() {
        let image = |v| Image::filled(16, 16, [v; 3]).unwrap();
        let figures = Figures::of(&image(0.3), Some(&image(0.2)), Some(&image(0.2))).unwrap();
        let rows = figures.rows();
        let [l1, psnr, ..] = rows.as_slice() else { panic!("{} rows", rows.len()) };
        assert_eq!((l1.denoised.as_str(), psnr.denoised.as_str()), ("0.0000", "120.0 dB"));
        assert_ne!(l1.noisy, "0.0000");
        assert_eq!(rows.len(), 4, "a picture of one color has no score");
        let small = Image::filled(2, 2, [0.0; 3]).unwrap();
        let error = Figures::of(&image(0.3), None, Some(&small)).unwrap_err();
        assert!(error.contains("16×16"), "{error}");
    }

    #[test]
    fn without_a_reference_the_noisier_picture_has_the_worse_score() {
        let sample = |name: &str| {
            let path = format!("{}/../../samples/{name}", env!("CARGO_MANIFEST_DIR"));
            Opened::reference(Path::new(&path)).unwrap().view().color().clone()
        };
        let (noisy, clean) = (sample("still_life_8spp.exr"), sample("still_life_reference.exr"));
        assert_eq!(Figures::of(&noisy, None, None).unwrap().rows().len(), 0);
        let figures = Figures::of(&noisy, Some(&clean), None).unwrap();
        let scores = figures.scores.map(Option::unwrap);
        assert!(scores[0] > scores[1] + 10.0, "{scores:?}");
        let rows = figures.rows();
        assert_eq!((rows.len(), rows[0].name), (1, "BRISQUE"));
    }
}
