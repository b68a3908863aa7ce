//! The bounding volume hierarchy, compared with testing every shape.

use glam::Vec3;

use crate::support::{Bench, Shot, bench, draw, draw_moved};
use path_tracer::renderer::bvh::{Bounds, Bvh, Node};
use path_tracer::renderer::scene::Scene;
use path_tracer::renderer::scenes::SceneName;
use path_tracer::renderer::{Method, Renderer};

fn bounds(scene: &Scene) -> Vec<Bounds> {
    scene.shapes.iter().map(|(shape, _)| Bounds::of(shape)).collect()
}

fn meets(origin: Vec3, direction: Vec3, low: Vec3, high: Vec3) -> bool {
    let (a, b) = ((low - origin) / direction, (high - origin) / direction);
    let (enter, leave) = (a.min(b), a.max(b));
    enter.max_element().max(0.0) <= leave.min_element()
}

/// The shapes in the leaves that a ray reaches, traversed as in the shader.
fn candidates(bvh: &Bvh, origin: Vec3, direction: Vec3) -> Vec<usize> {
    let (mut found, mut index) = (Vec::new(), 0);
    while let Some(node) = bvh.nodes.get(index) {
        let met = meets(origin, direction, node.low, node.high);
        if met {
            found.extend_from_slice(leaf(bvh, node));
        }
        index = if met || node.count > 0 { index + 1 } else { node.next as usize };
    }
    found
}

/// The shapes of a leaf; none for an inner node.
fn leaf<'a>(bvh: &'a Bvh, node: &Node) -> &'a [usize] {
    if node.count == 0 { &[] } else { &bvh.order[node.next as usize..][..node.count as usize] }
}

/// A low-discrepancy point in the unit cube (Roberts, "The Unreasonable Effectiveness of
/// Quasirandom Sequences", 2018).
fn point(index: usize) -> Vec3 {
    let root = 1.220_744_1_f32;
    let step = Vec3::new(1.0 / root, 1.0 / root.powi(2), 1.0 / root.powi(3));
    (step * index as f32).fract_gl()
}

const RAYS: usize = 2000;

#[test]
fn the_walk_reaches_every_shape_whose_box_a_ray_meets() {
    let bounds = bounds(&SceneName::StillLife.build());
    let bvh = Bvh::build(&bounds);
    let (mut reached, mut needed) = (0, 0);
    for i in 0..RAYS {
        let origin = (point(2 * i + 1) - 0.5) * 4.0;
        let direction = (point(2 * i + 2) - 0.5).normalize();
        let found = candidates(&bvh, origin, direction);
        let meeting =
            |&shape: &usize| meets(origin, direction, bounds[shape].low, bounds[shape].high);
        let expected: Vec<_> = (0..bounds.len()).filter(meeting).collect();
        for shape in &expected {
            assert!(found.contains(shape), "ray {i} misses shape {shape}");
        }
        reached += found.len();
        needed += expected.len();
    }
    assert!(needed > 1000, "the rays hit only {needed} boxes");
    let all = RAYS * bounds.len();
    assert!(reached * 20 < all, "the walk tests {reached} shapes of {all}");
}

#[test]
fn every_shape_is_in_one_leaf_and_inside_of_its_box() {
    let bounds = bounds(&SceneName::Caustics.build());
    let bvh = Bvh::build(&bounds);
    let leaves: Vec<_> = bvh.nodes.iter().map(|node| (node, leaf(&bvh, node))).collect();
    let mut seen: Vec<_> = leaves.iter().flat_map(|(_, shapes)| shapes.iter().copied()).collect();
    seen.sort_unstable();
    assert_eq!(seen, (0..bounds.len()).collect::<Vec<_>>());
    for (node, shapes) in leaves {
        for &shape in shapes {
            assert_eq!(node.low.min(bounds[shape].low), node.low);
            assert_eq!(node.high.max(bounds[shape].high), node.high);
        }
    }
}

#[test]
fn a_refitted_tree_has_boxes_around_the_shapes_as_they_are_and_no_wider() {
    let [before, after] = [0.0, 1.0].map(|time| bounds(&SceneName::Fireflies.at(time)));
    let mut bvh = Bvh::build(&before);
    bvh.refit(&after);
    let root = bvh.nodes[0];
    let low = after.iter().map(|bounds| bounds.low).reduce(Vec3::min).expect("a shape");
    let high = after.iter().map(|bounds| bounds.high).reduce(Vec3::max).expect("a shape");
    assert_eq!((root.low, root.high), (low, high));
    for i in 0..RAYS {
        let origin = (point(2 * i + 1) - 0.5) * 4.0;
        let direction = (point(2 * i + 2) - 0.5).normalize();
        let found = candidates(&bvh, origin, direction);
        for (shape, bounds) in after.iter().enumerate() {
            let met = meets(origin, direction, bounds.low, bounds.high);
            assert!(!met || found.contains(&shape), "ray {i} misses shape {shape}");
        }
    }
}

/// Compares with a renderer created for the moved scene.
#[test]
fn a_scene_that_has_moved_is_drawn_as_one_that_was_made_so() {
    let [before, after] = [0.0, 1.0].map(|time| SceneName::StillLife.at(time));
    let shot = Shot { size: [32, 24], samples: 1, seed: 5 };
    let made = draw(&after, Method::default(), shot);
    let moved = draw_moved(&before, &after, shot);
    let still = draw(&before, Method::default(), shot);
    assert_ne!(still.normal, moved.normal);
    assert_eq!((made.normal, made.albedo), (moved.normal, moved.albedo));
}

#[test]
fn a_scene_with_other_shapes_is_refused() {
    let Bench { device, queue, kernels } = bench();
    let scenes = [SceneName::StillLife, SceneName::Sky].map(SceneName::build);
    let mut renderer = Renderer::new(device, queue, kernels, &scenes[0], Method::default());
    for (now, last) in [(0, 1), (1, 0)] {
        let error = renderer.update(&scenes[now], &scenes[last]).unwrap_err().to_string();
        assert!(error.contains(&scenes[1].shapes.len().to_string()), "{error}");
    }
}

#[test]
fn one_shape_is_one_leaf() {
    let bvh = Bvh::build(&[Bounds { low: Vec3::ZERO, high: Vec3::ONE }]);
    assert_eq!((bvh.nodes.len(), bvh.nodes[0].count, bvh.order), (1, 1, vec![0]));
}

/// First hits are bit-identical. A few longer paths differ: rounding decides whether a ray hits a
/// triangle edge-on, and the hierarchy skips some of these tests.
#[test]
fn pictures_with_and_without_the_tree_are_the_same() {
    let scene = SceneName::StillLife.build();
    let shot = Shot { size: [32, 24], samples: 1, seed: 5 };
    let fast = draw(&scene, Method::default(), shot);
    let slow = draw(&scene, Method { hierarchy: false, ..Method::default() }, shot);
    assert_eq!(fast.normal, slow.normal);
    assert_eq!(fast.albedo, slow.albedo);
    let pairs = fast.color.iter().zip(&slow.color);
    let different = pairs.filter(|(fast, slow)| fast != slow).count();
    assert!(different * 50 < fast.color.len(), "{different} pixels differ");
}
