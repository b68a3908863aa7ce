"""Errors of every denoiser on every test render, and a description of the test sets."""

import sys
from pathlib import Path

import torch

from metrics import figures
from quality import highlights
from views import read_view

COUNTS = (1, 2, 8, 32, 128)


def paths_of(folder):
    paths = sorted(Path(folder).glob("*_v*.npz"))
    if not paths:
        raise SystemExit(f"{folder}: no views (*_v*.npz); expected a folder of rendered test views")
    return paths


def describe(name, folder):
    """One row per view of a test set: size, kind and estimated relative error of the reference."""
    views = map(read_view, paths_of(folder))
    return [dict(set=name, view=v["name"], kind=v["kind"], width=v["ref"].shape[2], height=v["ref"].shape[1],
                 relerr=v["relerr"]) for v in views]


@torch.no_grad()
def measure(name, folder, denoisers):
    """Rows of a test set: the noisy renders, then each denoiser of `denoisers`, {denoiser: its INPUTS}."""
    rows, paths = [], paths_of(folder)
    for i, path in enumerate(paths, 1):
        print(f"{name}: view {i} of {len(paths)}", file=sys.stderr, flush=True)
        view = read_view(path)
        for spp, image in view["noisy"]:
            if spp in COUNTS:
                about = dict(set=name, view=view["name"], spp=spp)
                rows += [about | row for row in _render(image, view["ref"][:3].float(), denoisers)]
    if not rows:
        raise SystemExit(f"{folder}: no render with {', '.join(map(str, COUNTS))} samples")
    return rows


def _render(image, ref, denoisers):
    yield dict(method="noisy", inputs="") | _errors(image[:3].float(), ref)
    for denoiser, accepted in denoisers.items():
        for inputs, asked in accepted.items():
            yield dict(method=denoiser.name, inputs=inputs) | _errors(denoiser(image, asked), ref)


def _errors(image, ref):
    """The error metrics, and the image's share of the reference's light: in the channel that is furthest off, among
    those with at least a hundredth of the light, and in the brightest 1 % of pixels."""
    means, right = image.mean((1, 2)), ref.mean((1, 2))
    shares = (means / right)[right > 0.01 * right.max()]
    bright = highlights.brightest(ref)
    return figures(image, ref) | dict(
        light=float(shares[(shares - 1).abs().argmax()]),
        highlights=highlights.light(image, bright) / highlights.light(ref, bright),
    )
