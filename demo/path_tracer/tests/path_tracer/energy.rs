//! No material creates light, and white ones absorb none: under a sky of radiance 1, anything white
//! looks like the sky.

use glam::{Vec3, vec3};

use crate::support::{Shot, assert_mean, camera_at, draw, floor, reds, sphere};
use path_tracer::renderer::Method;
use path_tracer::renderer::scene::{Material, Scene, Shape, Sky};

const SHOT: Shot = Shot { size: [64, 48], samples: 8, seed: 1 };

/// A sphere that fills the middle of the image.
fn in_white_sky(material: Material) -> Vec<f64> {
    let camera = camera_at(vec3(0.0, 0.0, 4.0), 30.0);
    let scene =
        Scene::new(camera, Sky::constant(Vec3::ONE)).with(material, [sphere(Vec3::ZERO, 1.0)]);
    let drawn = draw(&scene, Method::default(), SHOT);
    let covered = drawn.color.iter().filter(|pixel| pixel[3] == 1.0).copied();
    reds(&covered.collect::<Vec<_>>())
}

#[test]
fn a_white_sphere_vanishes_in_a_white_sky() {
    assert_mean("white", &in_white_sky(Material::Diffuse(Vec3::ONE)), 1.0, 0.01);
}

#[test]
fn a_gray_sphere_reflects_its_share() {
    // The sphere is convex, so every path scatters once.
    assert_mean("gray", &in_white_sky(Material::Diffuse(Vec3::splat(0.5))), 0.5, 0.01);
}

#[test]
fn clear_glass_loses_nothing() {
    for ior in [1.0, 1.33, 1.5, 2.4] {
        let glass = Material::Glass { color: Vec3::ONE, ior };
        assert_mean(&format!("glass {ior}"), &in_white_sky(glass), 1.0, 0.01);
    }
}

#[test]
fn metal_makes_no_light() {
    for roughness in [0.05, 0.2, 0.5, 1.0] {
        let pixels = in_white_sky(Material::Metal { color: Vec3::ONE, roughness });
        let most = pixels.iter().copied().fold(0.0, f64::max);
        // A visible microfacet's weight is at most 1; the rest is rounding.
        assert!(most <= 1.0 + 1e-4, "roughness {roughness}: {most}");
        let mean = pixels.iter().sum::<f64>() / pixels.len() as f64;
        assert!(roughness > 0.05 || mean > 0.99, "nearly a mirror: {mean}");
    }
}

/// At roughness 1, D = 1/π. At normal view no microfacet is masked, and light from cosine c is
/// shadowed by Λ = (1/c − 1)/2. The reflected share is therefore ∫ D / (1 + Λ) / 4 · 2π dc = ∫ c /
/// (1 + c) dc over c from 0 to 1, which is 1 − ln 2. The model omits the rest, which bounces
/// between microfacets.
#[test]
fn the_roughest_metal_reflects_what_its_facets_do_not_hide() {
    let white = Material::Metal { color: Vec3::ONE, roughness: 1.0 };
    let wall = Shape::Quad { corner: vec3(-1.0, -1.0, 0.0), edges: [Vec3::X * 2.0, Vec3::Y * 2.0] };
    let camera = camera_at(vec3(0.0, 0.0, 4.0), 0.1);
    let scene = Scene::new(camera, Sky::constant(Vec3::ONE)).with(white, [wall]);
    let pixels = reds(&draw(&scene, Method::default(), SHOT).color);
    assert_mean("roughness 1", &pixels, 1.0 - 2.0_f64.ln(), 0.01);
}

#[test]
fn white_things_among_each_other_lose_nothing_but_the_longest_paths() {
    let camera = camera_at(vec3(0.0, 2.0, 4.0), 30.0);
    let white = Material::Diffuse(Vec3::ONE);
    let shapes = [floor(2.0), sphere(vec3(-0.6, 0.5, 0.0), 0.5), sphere(vec3(0.6, 0.5, 0.0), 0.5)];
    let scene = Scene::new(camera, Sky::constant(Vec3::ONE)).with(white, shapes);
    let drawn = draw(&scene, Method::default(), SHOT);
    let pixels = reds(&drawn.color);
    let mean = pixels.iter().sum::<f64>() / pixels.len() as f64;
    assert!((0.999..1.0001).contains(&mean), "{mean}");
}
