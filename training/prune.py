"""Make a narrower network from a trained one by removing its weakest channels.

    python prune.py RUN/best.pt 16,32,64,96,160 NARROWER.pt    # then: train.py balanced --widths ... --init NARROWER.pt

Channels are ranked by the energy that they add to the layers that read them: the mean square, according to batch norm,
times the squared weights of the readers (after Li et al., "Pruning Filters for Efficient ConvNets", 2017). The result
is not the same function; further training makes up for that.
"""

import argparse
import math
from pathlib import Path

import torch

from model import network_for, widths_of
from run import load_checkpoint, save_checkpoint


def inputs(levels):
    """{layer: the layers whose channels it reads, in order}; an empty list stands for the image."""
    reads = {"enc_conv0a": [], "mid_conva": [f"enc_conv{levels - 1}b"], "mid_convb": ["mid_conva"],
             f"kernel_conv{levels}": ["mid_convb"]}
    for l in range(levels):
        coarser = "mid_convb" if l + 1 == levels else f"dec_conv{l + 1}b"
        reads |= {f"enc_conv{l + 1}a": [f"enc_conv{l}b"]} if l + 1 < levels else {}
        reads |= {f"enc_conv{l}b": [f"enc_conv{l}a"], f"dec_up{l}": [coarser],
                  f"dec_conv{l}a": [f"enc_conv{l}b", f"dec_up{l}"], f"dec_conv{l}b": [f"dec_conv{l}a"],
                  f"kernel_conv{l}": [f"dec_conv{l}b"]}
    return reads


def prune(state, new):
    """The state dict of a kernel pyramid reduced to the widths `new`, none of which may be larger than its own."""
    reads = inputs(len(new) - 1)
    kept = {layer: strongest(state, layer, reads, width_of(layer, new)) for layer in reads if "kernel" not in layer}
    narrow = {}
    for layer, sources in reads.items():
        offsets = torch.tensor([0, *(outputs(state, source) for source in sources)]).cumsum(0)
        read = [kept[source] + offset for source, offset in zip(sources, offsets)]
        for key in (key for key in state if key.startswith(layer + ".")):
            value = state[key]
            if value.ndim and layer in kept:
                value = value.index_select(output_dim(layer, value), kept[layer])
            if value.ndim == 4 and read:
                value = value.index_select(1 - output_dim(layer, value), torch.cat(read))
            narrow[key] = value
    return narrow


def strongest(state, layer, reads, count):
    """The indices of the `count` channels of a layer that contribute most to its readers, in order."""
    weights = 0
    for reader, sources in reads.items():
        if layer in sources:
            first = sum(outputs(state, source) for source in sources[:sources.index(layer)])
            squares = by_input(state, reader).square().sum((1, 2, 3))
            weights += squares[first:first + outputs(state, layer)]
    return (mean_square(state, layer, reads) * weights).topk(count).indices.sort().values


def mean_square(state, layer, reads):
    """The mean square of each channel: of a rectified normal distribution, or of a sum of independent ones."""
    if layer.startswith("dec_up"):
        squares = by_input(state, layer).square().mean((2, 3))
        return squares.T @ mean_square(state, reads[layer][0], reads) + state[layer + ".bias"].square()
    mean, deviation = state[layer + ".norm.bias"], state[layer + ".norm.weight"].abs().clamp(min=1e-6)
    above = 0.5 * (1 + torch.erf(mean / deviation / math.sqrt(2)))
    density = torch.exp(-0.5 * (mean / deviation).square()) / math.sqrt(2 * math.pi)
    return (mean.square() + deviation.square()) * above + mean * deviation * density


def width_of(layer, widths):
    return widths[-1] if layer.startswith("mid") else widths[int(layer[8 if "conv" in layer else 6])]


def outputs(state, layer):
    weight = state[layer + ".weight"]
    return weight.shape[output_dim(layer, weight)]


def output_dim(layer, value):
    return 1 if layer.startswith("dec_up") and value.ndim == 4 else 0


def by_input(state, layer):
    """The layer's weights [input,output,row,column]."""
    weight = state[layer + ".weight"]
    return weight if layer.startswith("dec_up") else weight.transpose(0, 1)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("checkpoint", type=Path)
    p.add_argument("widths", type=widths_of)
    p.add_argument("out", type=Path)
    o = p.parse_args()
    checkpoint = load_checkpoint(o.checkpoint)
    old = tuple(checkpoint["widths"])
    if checkpoint["topology"] != "kernel-pyramid":
        raise SystemExit(f"{o.checkpoint} has topology {checkpoint['topology']}: only a kernel-pyramid can be pruned")
    if len(old) != len(o.widths) or any(a < b for a, b in zip(old, o.widths)):
        raise SystemExit(f"{o.checkpoint} has widths {old}, not {o.widths}: no width may grow")
    state = prune(checkpoint["ema"], o.widths)
    network_for(checkpoint["topology"], o.widths, state).load_state_dict(state)
    history = [*checkpoint["history"], f"pruned from {','.join(map(str, old))} to {','.join(map(str, o.widths))}"]
    save_checkpoint(o.out, dict(checkpoint, widths=o.widths, history=history, ema=state))


if __name__ == "__main__":
    main()
