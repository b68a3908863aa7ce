//! A scene in motion: when the film starts over, and what counts as the last frame.

use crate::support::{Bench, bench};
use path_tracer::renderer::film::Film;
use path_tracer::renderer::motion::Motion;
use path_tracer::renderer::pixels::read;
use path_tracer::renderer::scenes::SceneName;
use path_tracer::stage::{Moment, Stage};

const SIZE: [u32; 2] = [32, 24];

fn stage() -> (Stage, Film, Motion) {
    let Bench { device, queue, kernels } = bench();
    let stage = Stage::new(device, queue, kernels, SceneName::StillLife);
    let film = stage.renderer.film(SIZE, 7).expect("a small film");
    let motion = stage.renderer.motion(SIZE).expect("small images");
    (stage, film, motion)
}

/// Draws a sample of the stage's frame; returns the longest motion vector.
fn draw(stage: &Stage, film: &mut Film, motion: &Motion) -> f32 {
    let Bench { device, queue, .. } = bench();
    let mut encoder = device.create_command_encoder(&Default::default());
    stage.encode(&mut encoder, film, 1, None);
    stage.encode_motion(&mut encoder, motion);
    queue.submit([encoder.finish()]);
    let vectors = read(device, queue, &motion.vectors).expect("it can be read");
    vectors.iter().map(|[x, y, ..]| x.hypot(*y)).fold(0.0, f32::max)
}

#[test]
fn the_film_starts_over_with_other_noise_only_when_something_moves() {
    let (mut stage, mut film, motion) = stage();
    let start = Moment { time: 1.0, ..stage.now() };
    let camera = Moment { camera: start.camera.orbit(2.0), ..start };
    let spheres = Moment { time: 1.1, ..camera };
    let mut seeds = Vec::new();
    for moment in [start, camera, spheres] {
        stage.show(moment, &mut film).expect("a built-in scene");
        assert_eq!(film.samples, 0);
        seeds.push(film.seed);
        assert!(draw(&stage, &mut film, &motion) > 0.5, "{moment:?}");
        stage.show(moment, &mut film).expect("a built-in scene");
        assert_eq!(film.samples, 1, "nothing has moved");
        assert!(draw(&stage, &mut film, &motion) < 1e-3, "what has stopped does not move");
    }
    seeds.dedup();
    assert_eq!(seeds.len(), 3);
}

#[test]
fn the_next_moment_moves_what_it_should_and_time_goes_around() {
    let start = stage().0.now();
    assert_eq!(start.next(0.0, false), start);
    let turned = start.next(90.0, false);
    assert_eq!((turned.time, turned.camera.target), (0.0, start.camera.target));
    // Seen from above, the camera moves to the right as seen by someone looking at the target.
    let [before, after] =
        [start, turned].map(|moment| moment.camera.position - start.camera.target);
    let quarter = glam::vec3(before.z, before.y, -before.x);
    assert!(after.distance(quarter) < 1e-5, "{after}");
    let around = (0..120).fold(start, |moment, _| moment.next(0.0, true));
    // 120 steps of 1/30 s in 32-bit floats.
    assert!(around.time < 1e-4 || around.time > 4.0 - 1e-4, "{}", around.time);
}
