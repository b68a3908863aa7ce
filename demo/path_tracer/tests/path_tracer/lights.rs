//! Light sampling and scattering alone, against analytic solutions.

use std::f64::consts::PI;

use glam::{Vec3, vec3};

use crate::support::{Shot, assert_mean, camera_at, draw, estimate, floor, reds, sphere};
use path_tracer::renderer::Method;
use path_tracer::renderer::scene::{Material, Scene, Shape, Sky, Sun};
use path_tracer::renderer::scenes::SceneName;

const BLACK: Vec3 = Vec3::ZERO;
const REFLECTANCE: f32 = 0.5;
const RADIANCE: f32 = 3.0;
const CHANCE: Method = Method { sample_lights: false, hierarchy: true };

/// A close-up of a floor, so small that all pixels receive the same light.
fn look_at_floor(sky: Sky) -> Scene {
    let camera = camera_at(vec3(3.0, 0.8, 0.0), 0.05);
    let gray = Material::Diffuse(Vec3::splat(REFLECTANCE));
    Scene::new(camera, sky).with(gray, [floor(4.0)])
}

/// Compares both methods with the radiance that the floor reflects under this irradiance.
fn check(what: &str, scene: &Scene, irradiance: f64) {
    let expected = f64::from(REFLECTANCE) / PI * irradiance;
    for (way, method, samples) in [("aimed", Method::default(), 8), ("by chance", CHANCE, 96)] {
        let drawn = draw(scene, method, Shot { size: [64, 48], samples, seed: 3 });
        assert_mean(&format!("{what}, {way}"), &reds(&drawn.color), expected, 0.01);
    }
}

#[test]
fn a_sphere_lights_a_floor_by_the_square_of_its_sine() {
    let (height, radius) = (1.5, 0.5);
    let light = sphere(Vec3::Y * height, radius);
    let scene = look_at_floor(Sky::constant(BLACK));
    let scene = scene.with(Material::Emitter(Vec3::splat(RADIANCE)), [light]);
    let irradiance = PI * f64::from(RADIANCE) * f64::from(radius / height).powi(2);
    check("sphere", &scene, irradiance);
}

/// The configuration factor from a point to a parallel rectangle with a corner above the point
/// (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3).
fn corner_factor(width: f64, depth: f64, height: f64) -> f64 {
    let (a, b) = (width / height, depth / height);
    let part = |a: f64, b: f64| a / a.hypot(1.0) * (b / a.hypot(1.0)).atan();
    (part(a, b) + part(b, a)) / (2.0 * PI)
}

#[test]
fn a_quad_lights_a_floor_by_its_configuration_factor() {
    let corner = vec3(-0.5, 1.2, -0.7);
    let light = Shape::Quad { corner, edges: [Vec3::X, Vec3::Z * 1.4] };
    let scene = look_at_floor(Sky::constant(BLACK));
    let scene = scene.with(Material::Emitter(Vec3::splat(RADIANCE)), [light]);
    let factor = 4.0 * corner_factor(0.5, 0.7, f64::from(corner.y));
    check("quad", &scene, PI * f64::from(RADIANCE) * factor);
}

#[test]
fn triangles_light_a_floor_like_the_quad_that_they_make() {
    let corners = [(-0.5, -0.7), (0.5, -0.7), (0.5, 0.7), (-0.5, 0.7)];
    let [a, b, c, d] = corners.map(|(x, z)| vec3(x, 1.2, z));
    let half = |corners| Shape::Triangle { corners, normals: [Vec3::NEG_Y; 3] };
    let scene = look_at_floor(Sky::constant(BLACK));
    let shapes = [half([a, b, c]), half([a, c, d])];
    let scene = scene.with(Material::Emitter(Vec3::splat(RADIANCE)), shapes);
    let factor = 4.0 * corner_factor(0.5, 0.7, 1.2);
    check("triangles", &scene, PI * f64::from(RADIANCE) * factor);
}

#[test]
fn a_sun_lights_a_floor_by_its_height() {
    let direction = vec3(0.3, 0.8, -0.4);
    let angle = 30.0_f32;
    let sun = Sun { direction, angle, radiance: Vec3::splat(RADIANCE) };
    let scene = look_at_floor(Sky { sun: Some(sun), ..Sky::constant(BLACK) });
    let sine = f64::from(angle / 2.0).to_radians().sin();
    let height = f64::from(direction.normalize().y);
    check("sun", &scene, PI * f64::from(RADIANCE) * sine * sine * height);
}

#[test]
fn the_back_of_a_quad_is_dark() {
    let light = Shape::Quad { corner: vec3(-0.5, 1.0, -0.5), edges: [Vec3::Z, Vec3::X] };
    let scene = look_at_floor(Sky::constant(BLACK));
    let scene = scene.with(Material::Emitter(Vec3::splat(RADIANCE)), [light]);
    for method in [Method::default(), CHANCE] {
        let drawn = draw(&scene, method, Shot { size: [16, 16], samples: 16, seed: 0 });
        assert!(reds(&drawn.color).iter().all(|&red| red == 0.0));
    }
}

/// A room with all materials: mean brightness by both methods, over several seeds.
#[test]
fn a_whole_scene_is_as_bright_by_aim_as_by_chance() {
    let scene = SceneName::StillLife.build();
    let means = |method, samples| -> Vec<f64> {
        let mean = |seed| {
            let drawn = draw(&scene, method, Shot { size: [32, 24], samples, seed });
            let pixels = reds(&drawn.color);
            pixels.iter().sum::<f64>() / pixels.len() as f64
        };
        (0..8).map(mean).collect()
    };
    let (aimed, aimed_error) = estimate(&means(Method::default(), 8));
    let (chance, chance_error) = estimate(&means(CHANCE, 24));
    let error = aimed_error.hypot(chance_error);
    assert!(error < 0.02 * aimed, "{aimed} and {chance} ± {error} are too uncertain");
    assert!((aimed - chance).abs() < 5.0 * error, "{aimed} and {chance} ± {error}");
}
