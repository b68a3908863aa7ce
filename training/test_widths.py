"""Tests of widen.py and prune.py. Run `pytest` in this folder; they take seconds and need no data."""

import re
from functools import partial

import pytest
import torch

from model import KernelPyramid, UNet
from prune import prune
from widen import widen


@pytest.fixture
def random():
    return torch.Generator().manual_seed(1)


def results(network, random):
    """The network's result for a random image."""
    image = torch.rand(2, 9, 16, 24, generator=random)
    light = torch.cat([image[:, :3], torch.ones(2, 1, 16, 24)], 1)
    return network.eval().denoise(image, light)


@pytest.mark.parametrize("kind", [UNet, KernelPyramid, partial(KernelPyramid, demodulates=True)])
def test_a_wider_network_is_the_same_function(kind, random):
    narrow, wide = kind((4, 6, 10)), kind((7, 6, 16))
    wide.load_state_dict(widen(narrow.state_dict(), narrow.widths, wide.widths, random))
    before, after = (results(n, torch.Generator().manual_seed(2)) for n in (narrow, wide))
    torch.testing.assert_close(after, before, rtol=1e-4, atol=1e-5)


def test_copies_of_a_channel_are_read_with_different_weights(random):
    narrow = KernelPyramid((4, 6, 10))
    wide = widen(narrow.state_dict(), (4, 6, 10), (8, 6, 10), random)
    readers = wide["kernel_conv0.weight"].flatten(1)
    assert len({tuple(column.tolist()) for column in readers.T}) == 8


def silence(network, random, width):
    """Leaves each layer only as many nonzero channels as `width` has for its level."""
    for name, module in network.named_children():
        if name.startswith("kernel_conv"):
            continue
        level = -1 if name.startswith("mid") else int(re.search(r"\d", name)[0])
        count = (module.bias if name.startswith("dec_up") else module.weight).shape[0]
        silent = torch.randperm(count, generator=random)[:count - width[level]]
        if name.startswith("dec_up"):
            module.weight.data[:, silent], module.bias.data[silent] = 0, 0
        else:
            module.norm.weight.data[silent], module.norm.bias.data[silent] = 0, 0


def test_pruning_leaves_out_what_adds_nothing(random):
    network, widths = KernelPyramid((5, 7, 10)), (3, 6, 8)
    silence(network, random, widths)
    narrow = KernelPyramid(widths)
    narrow.load_state_dict(prune(network.state_dict(), widths))
    before, after = (results(n, torch.Generator().manual_seed(2)) for n in (network, narrow))
    torch.testing.assert_close(after, before, rtol=1e-4, atol=1e-5)


def test_pruning_leaves_out_what_is_hardly_read():
    network, widths = KernelPyramid((4, 6)), (3, 6)
    network.dec_conv0b.weight.data[:, 2] *= 1e-3  # reads channel 2 of dec_conv0a
    network.dec_conv0a.norm.bias.data[:] = torch.arange(4.0)
    pruned = prune(network.state_dict(), widths)
    assert pruned["dec_conv0a.norm.bias"].tolist() == [0, 1, 3]


def test_pruning_to_the_same_widths_changes_nothing():
    state = KernelPyramid((4, 6, 10)).state_dict()
    pruned = prune(state, (4, 6, 10))
    assert pruned.keys() == state.keys() and all(torch.equal(pruned[name], value) for name, value in state.items())
