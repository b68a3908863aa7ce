"""Make a wider network from a trained one: the same function, with more channels to learn with.

    python widen.py RUN/best.pt high WIDER.pt      # then: train.py high --init WIDER.pt

Each new channel copies a channel of its level. Layers that read the copies split the original weight between them at
random, so that the copies learn different things (Net2Net, Chen et al. 2016).
"""

import argparse
from pathlib import Path

import torch

from model import TIERS, network_for
from run import load_checkpoint, save_checkpoint


class Level:
    """The old channel that each channel of a level copies, and random shares for the layers that read the copies."""

    def __init__(self, old, new, generator):
        extra = torch.randint(old, (new - old,), generator=generator)
        self.old, self.source = old, torch.cat([torch.arange(old), extra])
        self.random = generator

    def shares(self, rows):
        """[rows, new]: positive shares; in each row, the shares of an old channel's copies sum to 1."""
        share = 0.25 + torch.rand(rows, len(self.source), generator=self.random)
        total = torch.zeros(rows, self.old).index_add_(1, self.source, share)
        return share / total[:, self.source]


def read(weight, levels, dim):
    """`weight` adapted to input channels (dimension `dim`) from the widened `levels`, in order."""
    parts = weight.split([level.old for level in levels], dim)
    return torch.cat([_read(part, level, dim) for part, level in zip(parts, levels)], dim)


def _read(weight, level, dim):
    rows = weight.shape[1 - dim]
    shares = level.shares(rows) if dim == 1 else level.shares(rows).T
    return weight.index_select(dim, level.source) * shares[:, :, None, None]


def widen(state, old, new, generator):
    """Converts a network's state dict from widths `old` to widths `new`, none of which may be smaller."""
    levels = [Level(a, b, generator) for a, b in zip(old, new)]
    wide = {}
    for name, (inputs, output) in _layers(levels).items():
        transposed = name.startswith("dec_up")
        for key in [k for k in state if k.startswith(name + ".")]:
            value = state[key]
            if value.ndim == 4 and inputs:
                value = read(value, inputs, 0 if transposed else 1)
            if value.ndim and output:
                value = value.index_select(1 if transposed and value.ndim == 4 else 0, output.source)
            wide[key] = value
    return wide


def _layers(levels):
    """By layer name: the levels of its input channels (none: the image) and of its output."""
    layers = {"out_conv": (levels[:1], None)}
    layers |= {f"kernel_conv{l}": ([level], None) for l, level in enumerate(levels)}
    for l, level in enumerate(levels[:-1]):
        layers[f"enc_conv{l}a"] = (levels[l - 1:l] if l else [], level)
        layers[f"enc_conv{l}b"] = ([level], level)
        layers[f"dec_up{l}"] = ([levels[l + 1]], level)
        layers[f"dec_conv{l}a"] = ([level, level], level)
        layers[f"dec_conv{l}b"] = ([level], level)
    layers["mid_conva"] = (levels[-2:-1], levels[-1])
    layers["mid_convb"] = (levels[-1:], levels[-1])
    return layers


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("checkpoint", type=Path)
    p.add_argument("tier", choices=TIERS)
    p.add_argument("out", type=Path)
    p.add_argument("--seed", type=int, default=1)
    o = p.parse_args()
    checkpoint = load_checkpoint(o.checkpoint)
    old, new = checkpoint["widths"], TIERS[o.tier]
    if len(old) != len(new) or any(a > b for a, b in zip(old, new)):
        raise SystemExit(f"{o.checkpoint} has widths {old}, {o.tier} has {new}: no width may shrink")
    state = widen(checkpoint["ema"], old, new, torch.Generator().manual_seed(o.seed))
    network_for(checkpoint["topology"], new, state).load_state_dict(state)
    history = [*checkpoint["history"], f"widened from {','.join(map(str, old))} to {','.join(map(str, new))}"]
    save_checkpoint(o.out, dict(checkpoint, tier=o.tier, widths=new, history=history, ema=state))


if __name__ == "__main__":
    main()
