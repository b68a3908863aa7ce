"""The error of half precision, from the program's runs in both precisions on EXR files of a few test renders."""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
import torch

from metrics import figures
from quality.measure import paths_of
from views import read_view

PRECISIONS = ("f32", "f16")
COUNT = 8  # samples per pixel of the renders
LAYERS = ("R", "G", "B"), ("albedo.R", "albedo.G", "albedo.B"), ("normal.X", "normal.Y", "normal.Z")


def measure(program, folder, networks, views):
    """Display L1, one row per render, network and precision, for `views` renders spread evenly over the folder."""
    paths = [p for p in paths_of(folder) if COUNT in dict(read_view(p)["noisy"])]
    if not paths:
        raise SystemExit(f"{folder}: no render with {COUNT} samples")
    chosen = np.linspace(0, len(paths) - 1, min(views, len(paths))).astype(int)
    return [row for i in chosen for row in _rows(program, read_view(paths[i]), networks)]


def _rows(program, view, networks):
    print(f"half precision: {view['name']}", file=sys.stderr, flush=True)
    image, ref = dict(view["noisy"])[COUNT], view["ref"][:3].float()
    for network in networks:
        for precision in PRECISIONS:
            l1 = figures(run(program, image, network.path, precision), ref)["l1"]
            yield dict(view=view["name"], method=network.name, precision=precision, l1=l1)


def run(program, image, weights, precision):
    """Denoises a render [9,H,W] with the program; returns linear color [3,H,W]."""
    with tempfile.TemporaryDirectory() as folder:
        noisy, clean = Path(folder) / "noisy.exr", Path(folder) / "clean.exr"
        names = [n for layer in LAYERS for n in layer]
        _write(noisy, dict(zip(names, image.float().numpy())))
        call([program, noisy, clean, "--weights", weights, "--precision", precision, "--quiet"])
        return torch.from_numpy(_read(clean, LAYERS[0]))


def call(command, environment=None):
    """The standard output of a command; if it fails, ends the script with its error message."""
    try:
        done = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=True,
                              env=environment)
    except FileNotFoundError:
        raise SystemExit(f"{command[0]}: not found; build it with `cargo build --release`") from None
    except subprocess.CalledProcessError as e:
        raise SystemExit(f"{command[0]} failed: {e.stderr.strip()}") from None
    return done.stdout


def _write(path, channels):
    header = dict(compression=OpenEXR.ZIP_COMPRESSION, type=OpenEXR.scanlineimage)
    OpenEXR.File(header, {n: np.ascontiguousarray(c) for n, c in channels.items()}).write(str(path))


def _read(path, names):
    with OpenEXR.File(str(path), separate_channels=True) as f:
        return np.stack([np.asarray(f.channels()[n].pixels, np.float32) for n in names])
