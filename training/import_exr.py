"""Makes a training view from EXR files: a reference and noisy renders of the same picture, by any renderer.

    python import_exr.py mine/kitchen_v0.npz --reference kitchen_4096.exr 4=kitchen_4.exr 16=kitchen_16.exr

The view is named SCENE_vNUMBER.npz. Views with the same SCENE stay together when they are split into training,
validation and test. Render without denoising, clamping or fixed seeds: the noise of all files must be independent. The
files need color, albedo and normals; the program finds their layers, as `wgdenoise info` shows, unless `--color`,
`--albedo` and `--normal` name them. Needs the program and the package OpenEXR.
"""

import argparse
import json
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import OpenEXR

from write_view import write_view

FEATURES = "color", "albedo", "normal"
LETTERS = ("r", "g", "b"), ("x", "y", "z"), ("red", "green", "blue")
LEAST = 128  # minimum side in pixels, that of a training crop


def render(text):
    """Parses `4=kitchen_4.exr` to the samples per pixel and the file."""
    count, _, path = text.partition("=")
    if not path or not re.fullmatch(r"[1-9]\d*", count):
        raise argparse.ArgumentTypeError(f"{text}: expected SAMPLES=FILE, such as 4=kitchen_4.exr")
    return int(count), Path(path)


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("view", type=Path, help="the file to write, SCENE_vNUMBER.npz")
    p.add_argument("noisy", type=render, nargs="+", metavar="SAMPLES=FILE", help="noisy renders")
    p.add_argument("--reference", type=Path, required=True, help="a render with as many samples as you can afford")
    p.add_argument("--error", type=float, default=0.0, help="the reference's own relative error, if you know it")
    p.add_argument("--program", default="../target/release/wgdenoise")
    for name in FEATURES:
        p.add_argument(f"--{name}", help=f"layer of the {name}")
    o = p.parse_args()
    if not re.fullmatch(r".+_v\d+\.npz", o.view.name):
        p.error(f"{o.view}: expected a name such as kitchen_v0.npz")
    return o


def read(path, o):
    """[9,H,W]: color, albedo, normal."""
    named = {name: getattr(o, name) for name in FEATURES if getattr(o, name)}
    flags = [f"--{name}={layer}" for name, layer in named.items()]
    told = subprocess.run([o.program, "info", path, "--json", *flags], capture_output=True, text=True)
    if told.returncode:
        raise SystemExit(told.stderr.strip())
    about, file = json.loads(told.stdout), OpenEXR.File(str(path), separate_channels=True)
    missing = [name for name in FEATURES if not about[name]]
    if missing:
        raise SystemExit(f"{path}: no {' and no '.join(missing)}: render these too, or name their layers")
    return np.concatenate([_layer(file, about, about[name], path) for name in FEATURES])


def _layer(file, about, name, path):
    """[3,H,W] of a layer. Its channels are prefixed with its name, unless they have a part of their own."""
    layer = next(entry for entry in about["layers"] if entry["name"] == name)
    own, channels = {c["name"].lower(): c["name"] for c in layer["channels"]}, file.parts[layer["part"]].channels
    letters = next((group for group in LETTERS if all(letter in own for letter in group)), None)
    if letters is None:
        raise SystemExit(f"{path}: layer {name} has no three channels")
    full = [f"{name}.{own[letter]}" if f"{name}.{own[letter]}" in channels else own[letter] for letter in letters]
    return np.stack([channels[channel].pixels for channel in full]).astype(np.float32)


def main():
    o = arguments()
    reference, noisy = read(o.reference, o), [(count, read(path, o)) for count, path in o.noisy]
    for (_, image), (_, path) in zip(noisy, o.noisy):
        if image.shape != reference.shape:
            raise SystemExit(f"{path}: its size is not the reference's")
    if min(reference.shape[1:]) < LEAST:
        raise SystemExit(f"{o.reference}: a side is shorter than {LEAST} pixels, those of a training crop")
    o.view.parent.mkdir(parents=True, exist_ok=True)
    part = o.view.with_suffix(".part")
    write_view(part, reference, noisy, kind="imported", ref_relerr=o.error)
    os.replace(part, o.view)
    print(f"{o.view}: {reference.shape[2]}x{reference.shape[1]} pixels, {len(noisy)} noisy renders")


if __name__ == "__main__":
    main()
