//! A bounding volume hierarchy: a ray that misses a box skips every shape inside it.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::scene::Shape;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The smallest coordinates.
    pub low: Vec3,
    /// The largest coordinates.
    pub high: Vec3,
}

/// A node, laid out as `Node` in `shaders/scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Node {
    /// The box's smallest coordinates.
    pub low: Vec3,
    /// In an inner node, the node after its descendants; in a leaf, its first shape.
    pub next: u32,
    /// The box's largest coordinates.
    pub high: Vec3,
    /// Number of shapes in a leaf; 0 for an inner node.
    pub count: u32,
}

/// The nodes in depth-first order. Traversal needs no stack: it continues with the following node
/// or skips an inner node's descendants.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// The root, then its descendants.
    pub nodes: Vec<Node>,
    /// Indices of the shapes, in the order of the leaves.
    pub order: Vec<usize>,
}

impl Bounds {
    const EMPTY: Self =
        Self { low: Vec3::splat(f32::INFINITY), high: Vec3::splat(f32::NEG_INFINITY) };

    /// The box around a shape, slightly enlarged, because rounding would make rays miss a flat box.
    #[must_use]
    pub fn of(shape: &Shape) -> Self {
        let tight = match *shape {
            Shape::Sphere { center, radius } => Self::around([center - radius, center + radius]),
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

    fn center(&self) -> Vec3 {
        (self.low + self.high) / 2.0
    }

    /// Half the surface area. The share of rays that hit the box is proportional to it.
    fn half_area(&self) -> f32 {
        let size = self.high - self.low;
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}

impl Bvh {
    /// Builds a hierarchy over at least one shape, split by the surface area heuristic (Wald, "On
    /// Fast Construction of SAH-based Bounding Volume Hierarchies", 2007). Scenes are small, so it
    /// tries every split instead of a few bins.
    #[must_use]
    pub fn build(bounds: &[Bounds]) -> Self {
        let mut tree = Self::flat(bounds);
        tree.nodes.clear();
        tree.add(bounds, 0..bounds.len());
        tree
    }

    /// Puts all shapes in one leaf: every ray tests every shape.
    #[must_use]
    pub fn flat(bounds: &[Bounds]) -> Self {
        let order: Vec<_> = (0..bounds.len()).collect();
        let leaf = Node::leaf(&union(bounds, &order), 0..order.len());
        Self { nodes: vec![leaf], order }
    }

    /// Fits the boxes to moved shapes. The tree keeps its structure, so it becomes slower than a
    /// new one once neighbors have moved far apart.
    pub fn refit(&mut self, bounds: &[Bounds]) {
        // Descendants come after their ancestors.
        for index in (0..self.nodes.len()).rev() {
            let node = self.nodes[index];
            let Bounds { low, high } = if node.count > 0 {
                union(bounds, &self.order[node.next as usize..][..node.count as usize])
            } else {
                let [left, right] = self.children(index).map(|child| self.nodes[child].bounds());
                left.and(&right)
            };
            self.nodes[index] = Node { low, high, ..node };
        }
    }

    /// The children of an inner node.
    fn children(&self, parent: usize) -> [usize; 2] {
        let left = parent + 1;
        let Node { next, count, .. } = self.nodes[left];
        [left, if count > 0 { left + 1 } else { next as usize }]
    }

    /// Appends the subtree of these shapes.
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

    fn bounds(&self) -> Bounds {
        Bounds { low: self.low, high: self.high }
    }
}

fn union(bounds: &[Bounds], shapes: &[usize]) -> Bounds {
    shapes.iter().fold(Bounds::EMPTY, |all, &shape| all.and(&bounds[shape]))
}

/// Cost of a box test relative to a shape test.
const BOX_COST: f32 = 1.0;

/// Sorts the shapes for the cheapest split and returns the size of its left half; `None` if a leaf
/// is cheaper.
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
    let key = |shape: usize| (bounds[shape].center()[axis], shape);
    shapes.sort_by(|&a, &b| key(a).partial_cmp(&key(b)).expect("bounds are finite"));
}

/// Expected shape tests times the parent's half area, if the first 1, 2, … shapes are split off.
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
