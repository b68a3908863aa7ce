//! A tree of boxes around shapes: what a ray's box test rules out need not be tested.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::scene::Shape;

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) low: Vec3,
    pub(crate) high: Vec3,
}

/// A node as the shader reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Node {
    pub(crate) low: Vec3,
    /// Inner node: the node that follows its descendants. Leaf: its first shape.
    pub(crate) next: u32,
    pub(crate) high: Vec3,
    /// Shapes of a leaf; 0 for an inner node.
    pub(crate) count: u32,
}

/// Nodes in depth-first order, so that a walk needs no stack: it goes on to the following node, or
/// skips an inner node's descendants.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    pub(crate) nodes: Vec<Node>,
    /// The shapes, in the order in which the leaves count them.
    pub(crate) order: Vec<usize>,
}

impl Bounds {
    const EMPTY: Self =
        Self { low: Vec3::splat(f32::INFINITY), high: Vec3::splat(f32::NEG_INFINITY) };

    /// Around a shape, and a bit more: a box without thickness would be missed by rounding.
    pub(crate) fn of(shape: &Shape) -> Self {
        let tight = match *shape {
            Shape::Sphere { centre, radius } => Self::around([centre - radius, centre + radius]),
            Shape::Quad { corner, edges: [a, b] } => {
                Self::around([corner, corner + a, corner + b, corner + a + b])
            }
            Shape::Triangle { corners, .. } => Self::around(corners),
        };
        let margin = 1e-5 * tight.low.abs().max(tight.high.abs()).max(Vec3::ONE);
        Self { low: tight.low - margin, high: tight.high + margin }
    }

    fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        let point = |at| Self { low: at, high: at };
        points.into_iter().fold(Self::EMPTY, |all, at| all.and(&point(at)))
    }

    fn and(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn centre(&self) -> Vec3 {
        (self.low + self.high) / 2.0
    }

    /// Half the surface, to which the share of rays that meet the box is proportional.
    fn half_area(&self) -> f32 {
        let size = self.high - self.low;
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}

impl Bvh {
    /// A tree over at least one shape, split where the surface area heuristic expects the least
    /// work (Wald, "On Fast Construction of SAH-based Bounding Volume Hierarchies", 2007; all
    /// places are tried rather than some bins, as scenes are small).
    pub(crate) fn build(bounds: &[Bounds]) -> Self {
        let mut tree = Self::flat(bounds);
        tree.nodes.clear();
        tree.add(bounds, 0..bounds.len());
        tree
    }

    /// All shapes in one leaf: every ray tests every shape.
    pub(crate) fn flat(bounds: &[Bounds]) -> Self {
        let order: Vec<_> = (0..bounds.len()).collect();
        let leaf = Node::leaf(&union(bounds, &order), 0..order.len());
        Self { nodes: vec![leaf], order }
    }

    /// Adds the node of these shapes and all that are below it.
    fn add(&mut self, bounds: &[Bounds], range: Range<usize>) {
        let index = self.nodes.len();
        let whole = union(bounds, &self.order[range.clone()]);
        self.nodes.push(Node::leaf(&whole, range.clone()));
        if let Some(left) = split(bounds, &mut self.order[range.clone()], whole.half_area()) {
            let middle = range.start + left;
            self.add(bounds, range.start..middle);
            self.add(bounds, middle..range.end);
            let next = self.nodes.len() as u32;
            self.nodes[index] = Node { next, count: 0, ..self.nodes[index] };
        }
    }
}

impl Node {
    fn leaf(bounds: &Bounds, range: Range<usize>) -> Self {
        let (next, count) = (range.start as u32, range.len() as u32);
        Self { low: bounds.low, next, high: bounds.high, count }
    }
}

fn union(bounds: &[Bounds], shapes: &[usize]) -> Bounds {
    shapes.iter().fold(Bounds::EMPTY, |all, &shape| all.and(&bounds[shape]))
}

/// What a box test costs, in tests of a shape.
const BOX_COST: f32 = 1.0;

/// Orders the shapes for the best split and returns how many are left of it; `None` if none is
/// better than a leaf.
fn split(bounds: &[Bounds], shapes: &mut [usize], half_area: f32) -> Option<usize> {
    let mut best = ((shapes.len() as f32 - 2.0 * BOX_COST) * half_area, None);
    for axis in 0..3 {
        sort(bounds, shapes, axis);
        for (left, cost) in (1..).zip(costs(bounds, shapes)) {
            if cost < best.0 {
                best = (cost, Some((axis, left)));
            }
        }
    }
    best.1.map(|(axis, left)| {
        sort(bounds, shapes, axis);
        left
    })
}

fn sort(bounds: &[Bounds], shapes: &mut [usize], axis: usize) {
    let key = |shape: usize| (bounds[shape].centre()[axis], shape);
    shapes.sort_by(|&a, &b| key(a).partial_cmp(&key(b)).expect("bounds are finite"));
}

/// The expected shape tests, times the whole's half area, if the first 1, 2, … are split off.
fn costs(bounds: &[Bounds], shapes: &[usize]) -> Vec<f32> {
    let areas = |shapes: &mut dyn Iterator<Item = &usize>| -> Vec<f32> {
        let grow = |all: &mut Bounds, &shape: &usize| {
            *all = all.and(&bounds[shape]);
            Some(all.half_area())
        };
        shapes.scan(Bounds::EMPTY, grow).collect()
    };
    let (from_left, from_right) = (areas(&mut shapes.iter()), areas(&mut shapes.iter().rev()));
    let count = shapes.len();
    let cost = |left: usize| {
        let right = count - left;
        left as f32 * from_left[left - 1] + right as f32 * from_right[right - 1]
    };
    (1..count).map(cost).collect()
}
