//! The pass in the renderer's own submission: it beats many more samples, and with the schedule it
//! converges to the plain samples.

use std::sync::OnceLock;

use wgdenoise::{Quality, Schedule};

use crate::support::{Bench, Shot, bench, draw, error};
use path_tracer::denoise::{Denoised, denoiser};
use path_tracer::renderer::pixels::read;
use path_tracer::renderer::scenes::SceneName;
use path_tracer::renderer::{Method, Renderer};

const SIZE: [u32; 2] = [96, 72];

/// Plain samples of the default scene. Images and the reference use different seeds.
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
    let denoised = Denoised::new(&denoiser, device, &film, None).expect("the film fits");
    while film.samples < samples {
        let mut encoder = device.create_command_encoder(&Default::default());
        let more = samples - film.samples;
        renderer.encode(&mut encoder, &mut film, &scene.camera, more, None);
        if film.samples == samples {
            denoised.pass.set_blend(schedule.map_or(0.0, |schedule| schedule.blend(samples)));
            denoised.pass.encode(&mut encoder);
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

/// The network's bias remains with more samples; the schedule's result converges to the
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
