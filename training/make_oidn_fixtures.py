"""Make small test networks with Open Image Denoise's layers and random weights, in its file format (TZA).

    python make_oidn_fixtures.py ../tests/fixtures/oidn

Writes rt_hdr_alb_nrm.tza, rt_hdr_alb_nrm_large.tza and rt_alb.tza, named after their use, and io.safetensors: `input`
[9,H,W] in the network's encoding, and for each file `expected.rt_hdr_alb_nrm` and so on, PyTorch's result from the
channels that the network reads, in float64 rounded to float32. They contain no values of Open Image Denoise's weights.
"""

import struct
import sys
from pathlib import Path

import torch
from safetensors.torch import save_file
from torch.nn import functional as F

BASE = ("enc_conv0 enc_conv1", "enc_conv2", "enc_conv3", "enc_conv4", "enc_conv5a enc_conv5b", "dec_conv4a dec_conv4b",
        "dec_conv3a dec_conv3b", "dec_conv2a dec_conv2b", "dec_conv1a dec_conv1b dec_conv0")
LARGE = ("enc_conv1a enc_conv1b", "enc_conv2a enc_conv2b", "enc_conv3a enc_conv3b", "enc_conv4a enc_conv4b",
         "enc_conv5a enc_conv5b", "dec_conv4a dec_conv4b", "dec_conv3a dec_conv3b", "dec_conv2a dec_conv2b",
         "dec_conv1a dec_conv1b dec_conv1c")
LEVELS = 4
# Input channels, blocks, and output channels of each convolution; uneven, so that no two counts are confused.
WIDTHS = {"rt_hdr_alb_nrm": (9, BASE, (5, 4, 6, 7, 8, 9, 10, 11, 12, 9, 8, 7, 6, 5, 8, 3)),
          "rt_hdr_alb_nrm_large": (9, LARGE, (6, 5, 7, 6, 8, 7, 9, 8, 10, 9, 11, 10, 9, 8, 7, 6, 20, 18, 3)),
          "rt_alb": (3, BASE, (4, 5, 6, 6, 7, 8, 9, 9, 8, 7, 8, 6, 7, 5, 6, 3))}


def random_weights(blocks, widths, inputs, generator):
    """Weights by name, as float64 values that are exact in 16-bit floats."""
    weights, widths = {}, iter(widths)
    skips, channels = [], inputs
    for i, block in enumerate(blocks):
        if i < LEVELS:
            skips.append(channels)
        elif i > LEVELS:
            channels += skips.pop()
        for name in block.split():
            width = next(widths)
            scale = (2 / (9 * channels)) ** 0.5
            weights[f"{name}.weight"] = torch.randn((width, channels, 3, 3), generator=generator) * scale
            weights[f"{name}.bias"] = torch.randn(width, generator=generator) * 0.1
            channels = width
    weights[f"{name}.weight"] *= 0.2
    weights[f"{name}.bias"] += 0.5
    return {name: w.half().double() for name, w in weights.items()}


def run(blocks, weights, x):
    """The network's output; a ReLU follows every convolution."""
    skips = []
    for i, block in enumerate(blocks):
        if i < LEVELS:
            skips.append(x)
        elif i > LEVELS:
            x = torch.cat([F.interpolate(x, scale_factor=2), skips.pop()], 1)
        for name in block.split():
            x = F.conv2d(x, weights[f"{name}.weight"], weights[f"{name}.bias"], padding=1).relu()
        if i < LEVELS:
            x = F.max_pool2d(x, 2)
    return x


def tza(weights):
    """A TZA file: header, values at multiples of 64 bytes, table."""
    header, data, table = 12, b"", struct.pack("<I", len(weights))
    for name, values in weights.items():
        data += bytes(-(header + len(data)) % 64)
        layout = {4: b"oihw", 1: b"x"}[values.ndim]
        table += struct.pack("<H", len(name)) + name.encode() + struct.pack("<B", values.ndim)
        table += struct.pack(f"<{values.ndim}I", *values.shape) + layout + b"h"
        table += struct.pack("<Q", header + len(data))
        data += values.half().numpy().tobytes()
    return struct.pack("<HBBQ", 0x41D7, 2, 0, header + len(data)) + data + table


def main():
    if len(sys.argv) != 2:
        raise SystemExit("usage: python make_oidn_fixtures.py FOLDER")
    folder, generator = Path(sys.argv[1]), torch.Generator().manual_seed(20261122)
    folder.mkdir(parents=True, exist_ok=True)
    results = dict(input=torch.rand((9, 16, 32), generator=generator))
    for name, (inputs, blocks, widths) in WIDTHS.items():
        weights = random_weights(blocks, widths, inputs, generator)
        image = results["input"][None, :inputs].double()
        (folder / f"{name}.tza").write_bytes(tza(weights))
        results[f"expected.{name}"] = run(blocks, weights, image)[0].float().contiguous()
    save_file(results, folder / "io.safetensors")


if __name__ == "__main__":
    main()
