//! Assigns each tensor a texture and a range of its layers.
//!
//! Concatenated tensors share a texture, side by side, so concat moves no data. Textures ("slots")
//! are reused as soon as no layer still reads their contents.

use crate::model::{INPUT, Network, TensorId};

/// A texture shared in turn by tensors of one resolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Both sides are the tile's divided by `2^level`.
    pub level: u32,
    /// Array layers.
    pub quads: u32,
}

/// The location of a tensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Placement {
    /// Index of the slot.
    pub slot: usize,
    /// First array layer.
    pub first_quad: u32,
    /// Number of array layers.
    pub quads: u32,
}

/// The slots, and the location of every tensor.
#[derive(Clone, Debug)]
pub struct Storage {
    /// All textures.
    pub slots: Vec<Slot>,
    /// Locations by [`TensorId`].
    pub placements: Vec<Placement>,
}

impl Storage {
    /// Places all tensors of a network whose input has `input_quads` array layers.
    #[must_use]
    pub fn plan(network: &Network, input_quads: u32) -> Self {
        let groups = Groups::of(network, input_quads);
        let mut slots: Vec<(Slot, usize)> = Vec::new();
        let mut slot_of = vec![usize::MAX; network.shapes.len()];
        for group in groups.by_first_use() {
            let (level, quads) = (network.shapes[group].level, groups.quads[group]);
            let (first, last) = groups.life[group];
            let free = slots.iter().position(|(slot, until)| slot.level == level && *until < first);
            let index = free.unwrap_or(slots.len());
            if index == slots.len() {
                slots.push((Slot { level, quads }, last));
            }
            let (slot, until) = &mut slots[index];
            (slot.quads, *until) = (slot.quads.max(quads), last);
            slot_of[group] = index;
        }
        let place = |tensor: TensorId| {
            let (group, first_quad) = groups.root[tensor];
            Placement { slot: slot_of[group], first_quad, quads: groups.quads[tensor] }
        };
        let placements = (0..network.shapes.len()).map(place).collect();
        Self { slots: slots.into_iter().map(|(slot, _)| slot).collect(), placements }
    }

    /// Bytes of all textures for a tile of this size. Both sides must be multiples of the
    /// alignment.
    #[must_use]
    pub fn bytes(&self, width: u32, height: u32, texel_bytes: u64) -> u64 {
        let area = |level: u32| u64::from(width >> level) * u64::from(height >> level);
        self.slots.iter().map(|s| u64::from(s.quads) * area(s.level) * texel_bytes).sum()
    }
}

/// Tensors grouped by the concat they end up in.
struct Groups {
    /// By tensor: the root whose texture it is part of, and its first layer in it.
    root: Vec<(TensorId, u32)>,
    /// By tensor: array layers.
    quads: Vec<u32>,
    /// By root: the first step that writes it and the last that reads it.
    life: Vec<(usize, usize)>,
}

impl Groups {
    fn of(network: &Network, input_quads: u32) -> Self {
        let quads = quads(network, input_quads);
        let mut root: Vec<_> = (0..network.shapes.len()).map(|t| (t, 0)).collect();
        // From the last concat to the first, so that an inner concat already has its place.
        for (i, layer) in network.layers.iter().enumerate().rev() {
            if layer.op.facts().joins {
                let (group, mut next) = root[i + 1];
                for &input in &layer.inputs {
                    assert!(root[input] == (input, 0), "a tensor is concatenated only once");
                    root[input] = (group, next);
                    next += quads[input];
                }
            }
        }
        let life = life(network, &root);
        Self { root, quads, life }
    }

    fn by_first_use(&self) -> Vec<TensorId> {
        let mut groups: Vec<_> = (0..self.root.len()).filter(|&t| self.root[t].0 == t).collect();
        groups.sort_by_key(|&group| self.life[group].0);
        groups
    }
}

/// Array layers by tensor. Each concatenated part starts at a whole layer.
fn quads(network: &Network, input_quads: u32) -> Vec<u32> {
    let mut quads = vec![input_quads];
    for (i, layer) in network.layers.iter().enumerate() {
        quads.push(if layer.op.facts().joins {
            layer.inputs.iter().map(|&input| quads[input]).sum()
        } else {
            network.shapes[i + 1].channels.div_ceil(4) as u32
        });
    }
    quads
}

/// First write and last read of each group; layer `i` runs at step `i + 1`.
fn life(network: &Network, root: &[(TensorId, u32)]) -> Vec<(usize, usize)> {
    let mut life = vec![(usize::MAX, 0); root.len()];
    life[root[INPUT].0].0 = 0;
    for (i, layer) in network.layers.iter().enumerate() {
        let step = i + 1;
        for tensor in layer.inputs.iter().copied().chain([step]) {
            let (first, last) = &mut life[root[tensor].0];
            (*first, *last) = ((*first).min(step), (*last).max(step));
        }
    }
    for &output in &network.outputs {
        life[root[output].0].1 = usize::MAX;
    }
    life
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Op;

    #[test]
    fn no_layer_writes_over_a_tensor_that_is_still_read() {
        let network = Network::unet(9, &[5, 8, 12, 20]);
        let storage = Storage::plan(&network, 3);
        let last_read = |t: TensorId| {
            network.layers.iter().rposition(|l| l.inputs.contains(&t)).unwrap_or(usize::MAX)
        };
        let overlap = |a: &Placement, b: &Placement| {
            a.slot == b.slot
                && a.first_quad < b.first_quad + b.quads
                && b.first_quad < a.first_quad + a.quads
        };
        for (i, layer) in network.layers.iter().enumerate().filter(|(_, l)| l.op != Op::Concat) {
            let written = &storage.placements[i + 1];
            for t in (0..=i).filter(|&t| last_read(t) >= i && last_read(t) != usize::MAX) {
                assert!(
                    !overlap(written, &storage.placements[t]),
                    "{} writes over {t}",
                    layer.name
                );
            }
        }
    }

    #[test]
    fn the_parts_of_a_concat_lie_side_by_side() {
        let network = Network::unet(3, &[5, 8]);
        let storage = Storage::plan(&network, 1);
        let concat = network.layers.iter().position(|l| l.op == Op::Concat).unwrap();
        let [skip, up] = [0, 1].map(|i| storage.placements[network.layers[concat].inputs[i]]);
        let whole = storage.placements[concat + 1];
        assert_eq!((skip.slot, up.slot), (whole.slot, whole.slot));
        assert_eq!((skip.first_quad, up.first_quad, whole.quads), (0, 2, 4));
    }
}
