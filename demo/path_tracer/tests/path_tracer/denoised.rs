//! The pass in the renderer's own submission: better than many more samples, and with the schedule
//! converging to the plain samples.

use std::sync::OnceLock;

use wgdenoise::{Quality, Schedule};

use crate::support::{Bench, Shot, bench, draw};
use path_tracer::denoise::{Denoised, denoiser};
use path_tracer::renderer::pixels::read;
use path_tracer::renderer::scenes::SceneName;
use path_tracer::renderer::{Method, Renderer};

const SIZE: [u32; 2] = [96, 72];

/// The mean absolute difference after x ↦ x / (1 + x), which keeps bright pixels from dominating.
fn error(found: &[[f32; 4]], reference: &[[f32; 4]]) -> f64 {
    assert_eq!(found.len(), reference.len());
    let shown = |v: f32| f64::from(v / (1.0 + v));
    let of_pixel = |(a, b): (&[f32; 4], &[f32; 4])| -> f64 {
        (0..3).map(|c| (shown(a[c]) - shown(b[c])).abs()).sum()
    };
    found.iter().zip(reference).map(of_pixel).sum::<f64>() / (3 * found.len()) as f64
}

/// Plain samples of the default scene. Pictures and the reference have different seeds.
fn plain(samples: u32, seed: u32) -> Vec<[f32; 4]> {
    let shot = Shot { size: SIZE, samples, seed };
    draw(&SceneName::StillLife.build(), Method::default(), shot).color
}

fn reference() -> &'static [[f32; 4]] {
    static REFERENCE: OnceLock<Vec<[f32; 4]>> = OnceLock::new();
    REFERENCE.get_or_init(|| plain(1024, 99))
}

/// Noisy and denoised color, traced and denoised in one encoder, blended if there is a schedule.
fn denoised(samples: u32, schedule: Option<Schedule>) -> [Vec<[f32; 4]>; 2] {
    let Bench { device, queue, kernels } = bench();
    let scene = SceneName::StillLife.build();
    let renderer = Renderer::new(device, queue, kernels, &scene, Method::default());
    let mut film = renderer.film(SIZE, 1).expect("a small film");
    let denoiser = denoiser(device, queue, Quality::default()).expect("the device works");
    let denoised = Denoised::new(&denoiser, device, &film).expect("the film fits");
    while film.samples < samples {
        let mut encoder = device.create_command_encoder(&Default::default());
        let more = samples - film.samples;
        renderer.encode(&mut encoder, &mut film, &scene.camera, more, None);
        if film.samples == samples {
            match schedule {
                None => denoised.encode(&mut encoder),
                Some(by) => denoised.encode_blended(by.blend(samples), &mut encoder),
            }
        }
        queue.submit([encoder.finish()]);
    }
    [&film.color, &denoised.output].map(|image| read(device, queue, image).expect("it can be read"))
}

#[test]
fn four_denoised_samples_are_closer_to_the_truth_than_thirty_two_plain_ones() {
    let [noisy, found] = denoised(4, None);
    let [before, after, many] =
        [&noisy, &found, &plain(32, 2)].map(|image| error(image, reference()));
    assert!(after < many && many < before, "4: {before}, denoised: {after}, 32: {many}");
    assert!(noisy.iter().zip(&found).all(|(a, b)| a[3] == b[3]), "alpha is carried over");
}

/// The network's bias does not vanish with more samples; the schedule's result converges to the
/// accumulation.
#[test]
fn with_many_samples_the_output_tends_to_them() {
    let schedule = Schedule { every: 1, half_life: 16.0 };
    let away = |samples| {
        let [noisy, found] = denoised(samples, Some(schedule));
        error(&found, &noisy)
    };
    let [noisy, network] = denoised(256, None);
    let (few, many, bias) = (away(16), away(256), error(&network, &noisy));
    // The denoised share is a half at 16 samples and a seventeenth at 256.
    assert!(many < bias / 10.0 && many < few / 4.0, "16: {few}, 256: {many}, network: {bias}");
}
