//! The outlier repair preserves the highlights of renders.

use std::path::Path;

use wgdenoise::internals::reference;
use wgdenoise::{Image, Quality, Weights};
use wgdenoise_files::{LayerChoice, Picture};

/// Rec. 709 luminance.
fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.212_671 * f64::from(r) + 0.715_160 * f64::from(g) + 0.072_169 * f64::from(b)
}

fn sample(name: &str, finished: bool) -> Image {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(name);
    let choice = LayerChoice { finished, ..LayerChoice::default() };
    Picture::open(&path, &choice).expect("the sample is shipped").first().color().clone()
}

/// The light in the one percent of the pixels whose reference is brightest.
fn light_of_highlights(image: &Image, reference: &Image) -> f64 {
    let mut brightest: Vec<usize> = (0..reference.pixels().len()).collect();
    brightest.sort_by(|&a, &b| {
        luminance(reference.pixels()[b]).total_cmp(&luminance(reference.pixels()[a]))
    });
    brightest.truncate(reference.pixels().len() / 100);
    brightest.iter().map(|&i| luminance(image.pixels()[i])).sum()
}

#[test]
fn the_highlights_of_a_render_keep_their_light() {
    let weights = Weights::builtin(Quality::default()).expect("they are built in");
    let encoding = weights.metadata().encoding();
    let reference = sample("still_life_reference.exr", true);
    for (name, finished, least) in
        [("still_life_reference.exr", true, 0.999), ("still_life_8spp.exr", false, 0.99)]
    {
        let noisy = sample(name, finished);
        let repaired =
            reference::repair_in(encoding, &noisy, reference::autoexposure(&noisy)).color;
        let [before, after] = [&noisy, &repaired].map(|i| light_of_highlights(i, &reference));
        let changed = noisy.pixels().iter().zip(repaired.pixels()).filter(|(a, b)| a != b).count();
        println!("{name}: {changed} pixels changed, light {}", after / before);
        assert!(after / before >= least, "{name}: {} of the light is left", after / before);
    }
}
