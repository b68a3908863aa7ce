//! Motion vectors and depth, compared with trigonometry and with what two frames show.

use glam::{Quat, Vec3, vec3};

use crate::support::{Bench, Shot, bench, camera_at, draw, sphere};
use path_tracer::renderer::camera::Camera;
use path_tracer::renderer::pixels::read;
use path_tracer::renderer::scene::{Material, Scene, Shape, Sky};
use path_tracer::renderer::scenes::SceneName;
use path_tracer::renderer::{Method, Renderer};

const SIZE: [u32; 2] = [96, 72];
const GRAY: Material = Material::Diffuse(Vec3::splat(0.5));

/// Motion vectors and depth of the second scene, relative to the first.
fn motion([last, now]: [&Scene; 2]) -> (Vec<[f32; 2]>, Vec<f32>) {
    let Bench { device, queue, kernels } = bench();
    let mut renderer = Renderer::new(device, queue, kernels, now, Method::default());
    renderer.update(now, last).expect("both have the same shapes");
    let motion = renderer.motion(SIZE).expect("small images");
    let mut encoder = device.create_command_encoder(&Default::default());
    renderer.encode_motion(&mut encoder, &motion, [&now.camera, &last.camera]);
    queue.submit([encoder.finish()]);
    let read = |texture| read(device, queue, texture).expect("it can be read");
    let vectors = read(&motion.vectors).into_iter().map(|[x, y, ..]| [x, y]).collect();
    (vectors, read(&motion.depth).into_iter().map(|[depth, ..]| depth).collect())
}

/// The pixel right of and below the image's center.
const MIDDLE: usize = (SIZE[1] / 2 * SIZE[0] + SIZE[0] / 2) as usize;

/// Pixels per unit of the image plane at distance 1.
fn focal_length(camera: &Camera) -> f32 {
    SIZE[1] as f32 / 2.0 / (camera.field_of_view / 2.0).to_radians().tan()
}

fn assert_near(found: [f32; 2], expected: [f32; 2]) {
    let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
    // Coordinates up to 100 pixels in 32-bit floats, after a few operations.
    assert!(off < 1e-3, "{found:?} instead of {expected:?}");
}

/// A wall at height 0, seen from 4 m away.
fn wall() -> Scene {
    let corner = vec3(-9.0, -9.0, 0.0);
    let wall = Shape::Quad { corner, edges: [Vec3::X * 18.0, Vec3::Y * 18.0] };
    let camera = camera_at(vec3(0.0, 0.0, 4.0), 30.0);
    Scene::new(camera, Sky::constant(Vec3::ONE)).with(GRAY, [wall])
}

fn moved(mut scene: Scene, by: Vec3) -> Scene {
    scene.camera.position += by;
    scene.camera.target += by;
    scene
}

#[test]
fn a_camera_that_goes_right_and_up_saw_a_wall_farther_right_and_above() {
    let (last, now) = (wall(), moved(wall(), vec3(0.2, 0.1, 0.0)));
    let (vectors, depth) = motion([&last, &now]);
    let pixels = focal_length(&now.camera) / 4.0;
    for (vector, depth) in vectors.into_iter().zip(depth) {
        assert_near(vector, [0.2 * pixels, -0.1 * pixels]);
        assert!((depth - 4.0).abs() < 1e-5, "{depth}");
    }
}

#[test]
fn a_sphere_that_goes_right_and_up_was_left_and_below() {
    let ball = |center| {
        let camera = camera_at(vec3(0.0, 0.0, 4.0), 30.0);
        Scene::new(camera, Sky::constant(Vec3::ONE)).with(GRAY, [sphere(center, 0.5)])
    };
    let (last, now) = (ball(vec3(-0.2, -0.1, 0.0)), ball(Vec3::ZERO));
    let (vectors, depth) = motion([&last, &now]);
    let pixels = focal_length(&now.camera) / depth[MIDDLE];
    assert_near(vectors[MIDDLE], [-0.2 * pixels, 0.1 * pixels]);
    // The ray half a pixel off the axis hits the ball just behind its pole.
    assert!((3.5..3.501).contains(&depth[MIDDLE]), "{}", depth[MIDDLE]);
    // The background stands still.
    assert_near(vectors[0], [0.0; 2]);
    assert_eq!(depth[0], 0.0);
}

#[test]
fn a_camera_that_turns_left_saw_the_background_farther_left_wherever_it_stands() {
    let angle = 0.02_f32;
    let start = camera_at(vec3(0.0, 0.0, 4.0), 30.0);
    let toward = start.target - start.position;
    let target = start.position + Quat::from_rotation_y(angle) * toward;
    let empty = |camera| {
        Scene::new(camera, Sky::constant(Vec3::ONE)).with(GRAY, [sphere(Vec3::Z * 50.0, 0.1)])
    };
    let (last, now) = (empty(start), moved(empty(Camera { target, ..start }), vec3(1.0, 2.0, 3.0)));
    let (vectors, depth) = motion([&last, &now]);
    assert!(depth.iter().all(|&depth| depth == 0.0));
    // The direction half a pixel right of the new axis, and its angle from the old one.
    let focal = focal_length(&start);
    let x = focal * ((0.5 / focal).atan() - angle).tan() - 0.5;
    assert!((vectors[MIDDLE][0] - x).abs() < 1e-2, "{:?} instead of {x}", vectors[MIDDLE]);
}

#[test]
fn what_was_behind_the_camera_was_out_of_the_picture() {
    let (mut last, now) = (wall(), wall());
    last.camera.target.z = 9.0;
    let (vectors, _) = motion([&last, &now]);
    let out = |[x, y]: [f32; 2]| x < -(SIZE[0] as f32) && y < -(SIZE[1] as f32);
    assert!(vectors.into_iter().all(out));
}

#[test]
fn nothing_moves_in_a_still_scene() {
    let scene = SceneName::StillLife.at(1.0);
    motion([&scene, &scene]).0.into_iter().for_each(|vector| assert_near(vector, [0.0; 2]));
}

/// A pixel's position in the last frame by its vector, between pixels; `None` outside the image.
fn place(pixel: usize, [x, y]: [f32; 2]) -> Option<[f32; 2]> {
    let [width, height] = SIZE.map(|side| side as f32);
    let x = (pixel % SIZE[0] as usize) as f32 + x;
    let y = (pixel / SIZE[0] as usize) as f32 + y;
    let inside = (0.0..width - 1.0).contains(&x) && (0.0..height - 1.0).contains(&y);
    inside.then_some([x, y])
}

/// Whether a value is in the range of the four pixels around a position. Both were rounded to 8
/// bits.
fn shows(image: &[[f32; 4]], [x, y]: [f32; 2], value: [f32; 4]) -> bool {
    let first = y as usize * SIZE[0] as usize + x as usize;
    let around = [0, 1, SIZE[0] as usize, SIZE[0] as usize + 1].map(|step| image[first + step]);
    (0..3).all(|c| {
        let channel = around.iter().map(|pixel| pixel[c]);
        let (low, high) = (channel.clone().fold(1.0, f32::min), channel.fold(0.0, f32::max));
        (low - 1.0 / 255.0..=high + 1.0 / 255.0).contains(&value[c])
    })
}

/// Checks that the last frame, warped by the vectors, matches this frame. What the last frame hid
/// is wrong with any vectors, so zero vectors and vectors with wrong signs serve for comparison:
/// they must be wrong more than twice as often, among the pixels that count.
fn check_warp(
    [last, now]: [&[[f32; 4]]; 2],
    vectors: &[[f32; 2]],
    wrong: &[[f32; 2]],
    counts: impl Fn(usize) -> bool,
) {
    let pixels: Vec<_> = (0..now.len()).filter(|&pixel| counts(pixel)).collect();
    assert!(pixels.len() > 500, "only {} pixels count", pixels.len());
    let share = |[x, y]: [f32; 2]| {
        let place = |&pixel: &usize| place(pixel, [x * vectors[pixel][0], y * vectors[pixel][1]]);
        let places = pixels.iter().filter_map(|pixel| Some((pixel, place(pixel)?)));
        let off = places.clone().filter(|&(&pixel, at)| !shows(last, at, now[pixel])).count();
        off as f32 / places.count() as f32
    };
    let right = share([1.0; 2]);
    for &signs in wrong {
        let other = share(signs);
        assert!(right < other / 2.0, "{right} of the pixels are off, {other} with {signs:?}");
    }
}

const SHOT: Shot = Shot { size: SIZE, samples: 16, seed: 3 };
const NONE_OR_FLIPPED: &[[f32; 2]] = &[[0.0; 2], [-1.0, 1.0], [1.0, -1.0]];

fn turned(mut scene: Scene, around: f32, up: f32) -> Scene {
    let turn = Quat::from_rotation_y(around) * Quat::from_rotation_x(-up);
    let Camera { position, target, .. } = scene.camera;
    scene.camera.position = target + turn * (position - target);
    scene
}

#[test]
fn albedo_follows_a_camera_that_turns() {
    let (last, now) =
        (SceneName::StillLife.build(), turned(SceneName::StillLife.build(), 0.05, 0.03));
    let (vectors, _) = motion([&last, &now]);
    let albedo = [&last, &now].map(|scene| draw(scene, Method::default(), SHOT).albedo);
    check_warp(albedo.each_ref().map(Vec::as_slice), &vectors, NONE_OR_FLIPPED, |_| true);
}

#[test]
fn albedo_follows_spheres_that_move() {
    let [last, now] = [0.8, 1.0].map(|time| SceneName::StillLife.at(time));
    let (vectors, _) = motion([&last, &now]);
    let albedo = [&last, &now].map(|scene| draw(scene, Method::default(), SHOT).albedo);
    let moves = |pixel: usize| vectors[pixel][0].hypot(vectors[pixel][1]) > 0.5;
    check_warp(albedo.each_ref().map(Vec::as_slice), &vectors, NONE_OR_FLIPPED, moves);
}

/// The sky's gradient is vertical, so it cannot reveal a wrong x.
#[test]
fn the_sky_follows_a_camera_that_turns() {
    let (last, now) = (SceneName::Sky.build(), turned(SceneName::Sky.build(), 0.0, 0.03));
    let (vectors, depth) = motion([&last, &now]);
    let color = [&last, &now].map(|scene| draw(scene, Method::default(), SHOT).color);
    let wrong = &[[1.0, 0.0], [1.0, -1.0]];
    check_warp(color.each_ref().map(Vec::as_slice), &vectors, wrong, |pixel| depth[pixel] == 0.0);
}
