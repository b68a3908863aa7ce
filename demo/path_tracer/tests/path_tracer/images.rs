//! The images of a film.

use clap::ValueEnum as _;

use crate::support::{Drawn, Shot, draw};
use path_tracer::renderer::Method;
use path_tracer::renderer::scenes::SceneName;

const SHOT: Shot = Shot { size: [64, 48], samples: 5, seed: 7 };

fn scene(name: SceneName) -> Drawn {
    draw(&name.build(), Method::default(), SHOT)
}

fn length(v: &[f32; 4]) -> f32 {
    v[0].hypot(v[1]).hypot(v[2])
}

#[test]
fn every_scene_draws_light_that_is_finite() {
    for &name in SceneName::value_variants() {
        let drawn = scene(name);
        let values = drawn.color.iter().flatten();
        assert!(values.clone().all(|v| v.is_finite() && *v >= 0.0), "{name:?}");
        let lit = drawn.color.iter().filter(|pixel| length(pixel) > 0.0).count();
        assert!(lit * 2 > drawn.color.len(), "{name:?}: {lit} pixels are lit");
    }
}

#[test]
fn a_seed_repeats_to_the_bit_and_another_one_differs() {
    let scene = SceneName::StillLife.build();
    let draw = |seed| draw(&scene, Method::default(), Shot { seed, ..SHOT }).color;
    let first = draw(7);
    assert_eq!(first, draw(7));
    let other = draw(8);
    let same = first.iter().zip(&other).filter(|(a, b)| a == b).count();
    assert!(same * 10 < first.len(), "{same} pixels of two seeds are equal");
}

#[test]
fn the_background_is_empty_and_surfaces_have_unit_normals() {
    let Drawn { color, albedo, normal } = scene(SceneName::Sky);
    let (mut background, mut surface) = (0, 0);
    for ((color, albedo), normal) in color.iter().zip(&albedo).zip(&normal) {
        if color[3] == 0.0 {
            assert_eq!((length(albedo), length(normal)), (0.0, 0.0));
            background += 1;
        } else if color[3] == 1.0 {
            assert!(length(albedo) > 0.0);
            // An average of unit normals, stored in 16 bits, has length 1 at most.
            assert!((0.2..1.001).contains(&length(normal)), "{normal:?}");
            surface += 1;
        }
    }
    assert!(background > 1000 && surface > 500, "{background} and {surface} pixels");
}

#[test]
fn more_samples_come_nearer_to_many() {
    let scene = SceneName::StillLife.build();
    let draw = |samples, seed| {
        draw(&scene, Method::default(), Shot { samples, seed, size: [32, 24] }).color
    };
    let many = draw(128, 1);
    let off = |few: Vec<[f32; 4]>| -> f32 {
        few.iter().zip(&many).map(|(a, b)| (a[1] - b[1]).abs()).sum::<f32>()
    };
    let (few, more) = (off(draw(4, 0)), off(draw(64, 0)));
    // With 16 times the samples, the standard deviation drops to a quarter; outliers blur that.
    assert!(more < 0.5 * few, "4 samples are off by {few}, 64 by {more}");
}
