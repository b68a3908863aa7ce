"""The protocol of the thesis that introduced the network: 8-bit sRGB images, 256x256 patches, color alone.

The noisy image and the reference are exposed for display and quantized to 8 bits. As in the program for a PNG file, the
noisy image is decoded to linear, denoised, clipped, encoded and quantized again. Errors compare 8-bit images.
"""

import sys

import torch

from metrics import display, exposure_of, ssim
from quality.measure import paths_of
from views import read_view

COUNTS = (2, 5, 10, 25, 50, 100, 200, 500)
PATCH = 256


def to_picture(color):
    """Converts linear color to the values of an 8-bit sRGB file, in 0..1."""
    return (display(color) * 255).round() / 255


def to_linear(picture):
    return torch.where(picture <= 0.04045, picture / 12.92, ((picture + 0.055) / 1.055) ** 2.4)


def patches(image):
    """The complete patches of an image [C,H,W], row by row; a smaller image is its own patch."""
    h, w = (min(PATCH, s) for s in image.shape[1:])
    return [p for row in image.split(h, 1) for p in row.split(w, 2) if p.shape[1:] == (h, w)]


@torch.no_grad()
def measure(folder, networks):
    """L1 and SSIM before and after denoising, one row per patch, sample count and network."""
    rows = []
    for path in paths_of(folder):
        print(f"thesis's protocol: {path.stem}", file=sys.stderr, flush=True)
        view = read_view(path)
        ref = view["ref"][:3].float()
        scale = exposure_of(ref)
        for spp, image in view["noisy"]:
            if spp in COUNTS:
                pairs = zip(patches(to_picture(image[:3].float() * scale)), patches(to_picture(ref * scale)))
                for i, pair in enumerate(pairs):
                    rows += [dict(view=view["name"], patch=i, spp=spp) | _errors(*pair, n) for n in networks]
    if not rows:
        raise SystemExit(f"{folder}: no render with {', '.join(map(str, COUNTS))} samples")
    return rows


def _errors(noisy, ref, network):
    linear = to_linear(noisy)
    denoised = to_picture(network(torch.cat([linear, torch.zeros_like(linear).repeat(2, 1, 1)]), "color"))
    row = dict(method=network.name)
    for name, picture in dict(before=noisy, after=denoised).items():
        row[f"l1_{name}"] = float((picture - ref).abs().mean())
        row[f"ssim_{name}"] = float(ssim(picture[None], ref[None], 1.0))
    return row
