//! Averaging frames along their motion reduces flicker and error, and leaves no trace in a still
//! scene.

use wgdenoise::Quality;

use crate::support::{Bench, Shot, bench, draw, error};
use path_tracer::denoise::{Denoised, denoiser, history};
use path_tracer::renderer::Method;
use path_tracer::renderer::film::Film;
use path_tracer::renderer::motion::Motion;
use path_tracer::renderer::pixels::read;
use path_tracer::renderer::scene::Scene;
use path_tracer::renderer::scenes::SceneName;
use path_tracer::stage::{Moment, Stage};

const SIZE: [u32; 2] = [96, 72];

/// A stage with a film and a denoiser.
struct Studio {
    stage: Stage,
    film: Film,
    motion: Motion,
    denoised: Denoised,
}

impl Studio {
    /// Averages frames if `temporal`.
    fn new(temporal: bool) -> Self {
        let Bench { device, queue, kernels } = bench();
        let stage = Stage::new(device, queue, kernels, SceneName::StillLife);
        let film = stage.renderer.film(SIZE, 1).expect("a small film");
        let motion = stage.renderer.motion(SIZE).expect("small images");
        let denoiser = denoiser(device, queue, Quality::Fast).expect("the device works");
        let along = temporal.then_some(&motion);
        let denoised = Denoised::new(&denoiser, device, &film, along).expect("the film fits");
        Self { stage, film, motion, denoised }
    }

    /// Adds samples and denoises the film, to which `earlier` frames have already added samples.
    fn draw(&mut self, earlier: u32) -> Vec<[f32; 4]> {
        let Bench { device, queue, .. } = bench();
        let Self { stage, film, motion, denoised } = self;
        let mut encoder = device.create_command_encoder(&Default::default());
        stage.encode(&mut encoder, film, 4, None);
        stage.encode_motion(&mut encoder, motion);
        denoised.pass.set_history(history(earlier));
        denoised.pass.encode(&mut encoder);
        queue.submit([encoder.finish()]);
        read(device, queue, &denoised.output).expect("it can be read")
    }

    /// Draws moments, one frame each.
    fn play(&mut self, moments: &[Moment]) -> Vec<Vec<[f32; 4]>> {
        let show = |&moment| {
            self.stage.show(moment, &mut self.film).expect("a built-in scene");
            self.film.start_over();
            self.draw(0)
        };
        moments.iter().map(show).collect()
    }
}

/// Eight frames, starting when the spheres are fastest.
fn moments(orbit: f32, animate: bool) -> Vec<Moment> {
    let camera = SceneName::StillLife.build().camera;
    let start = Moment { time: 1.0, camera };
    std::iter::successors(Some(start), |moment| Some(moment.next(orbit, animate))).take(8).collect()
}

/// The mean difference between a frame and the last one, where the motion vectors point.
fn flicker(last: &[[f32; 4]], now: &[[f32; 4]], vectors: &[[f32; 4]]) -> f64 {
    let [width, height] = SIZE.map(|side| side as usize);
    let followed = |pixel: usize| {
        let [x, y, ..] = vectors[pixel];
        let x = ((pixel % width) as f32 + x).round().clamp(0.0, width as f32 - 1.0);
        let y = ((pixel / width) as f32 + y).round().clamp(0.0, height as f32 - 1.0);
        last[y as usize * width + x as usize]
    };
    let followed: Vec<_> = (0..now.len()).map(followed).collect();
    error(now, &followed)
}

/// The last frame's error, and the flicker between it and the previous one.
fn measure(temporal: bool, moments: &[Moment], truth: &[[f32; 4]]) -> [f64; 2] {
    let Bench { device, queue, .. } = bench();
    let mut studio = Studio::new(temporal);
    let frames = studio.play(moments);
    let [.., last, now] = &frames[..] else { panic!("too few frames") };
    let vectors = read(device, queue, &studio.motion.vectors).expect("it can be read");
    [error(now, truth), flicker(last, now, &vectors)]
}

/// Error and flicker of single and of averaged frames.
fn compare(orbit: f32, animate: bool) -> [[f64; 2]; 2] {
    let moments = moments(orbit, animate);
    let Moment { time, camera } = moments[moments.len() - 1];
    let scene = Scene { camera, ..SceneName::StillLife.at(time) };
    let truth = draw(&scene, Method::default(), Shot { size: SIZE, samples: 64, seed: 99 });
    [false, true].map(|temporal| measure(temporal, &moments, &truth.color))
}

/// Here, all flicker is noise.
#[test]
fn a_still_scene_flickers_less_than_half_as_much() {
    let [alone, averaged] = compare(0.0, false);
    assert!(averaged[0] < alone[0] && averaged[1] < alone[1] / 2.0, "{averaged:?} and {alone:?}");
}

/// Here, some of the change is the scene's own.
#[test]
fn moving_scenes_have_less_error_and_flicker() {
    for (orbit, animate) in [(0.5, false), (0.0, true)] {
        let [alone, averaged] = compare(orbit, animate);
        let less = averaged[0] < alone[0] && averaged[1] < alone[1];
        assert!(less, "{orbit}° {animate}: {averaged:?} and {alone:?}");
    }
}

/// Holds even if the history shows another view.
#[test]
fn a_still_scene_converges_as_without_history() {
    let moments = moments(2.0, true);
    let [alone, averaged] = [false, true].map(|temporal| {
        let mut studio = Studio::new(temporal);
        studio.play(&moments);
        (1..12).map(|earlier| studio.draw(earlier)).collect::<Vec<_>>()
    });
    let differs: Vec<_> = alone.iter().zip(&averaged).map(|(a, b)| a != b).collect();
    // Eight frames weigh the same; from the ninth on, no history is left.
    assert_eq!(differs, [[true; 7].as_slice(), &[false; 4]].concat());
}

#[test]
fn on_the_way_from_history_to_film_all_frames_weigh_the_same() {
    // The remaining share of the history after each frame of a film.
    let mut before = 1.0;
    for earlier in 0..12 {
        let frames = f64::from(history(earlier));
        before *= frames / (1.0 + frames);
        let expected = (8.0 - f64::from(earlier)).max(0.0) / 9.0;
        assert!((before - expected).abs() < 1e-12, "{before} after {earlier}");
    }
}
