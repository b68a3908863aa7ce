"""Denoise references with Intel Open Image Denoise, guided by their own albedo and normal, for use as training targets.

    python prefilter.py --data VIEWS [VIEWS ...]

A reference of a few hundred samples is unbiased, but in hard scenes as noisy as a network's output for a few samples.
Writes `SCENE_vV.target.npy`, float16 [3,H,W] of linear color, next to each `SCENE_vV.npz` for `train.py --targets
prefiltered`. Skips views that already have one. Needs pyoidn.
"""

import argparse
from pathlib import Path

import numpy as np
import pyoidn

from views import read_view, target_path


def prefilter(view):
    """The denoised color of the reference, float16 [3,H,W]."""
    color, albedo, normal = (np.ascontiguousarray(p.permute(1, 2, 0)) for p in view["ref"].float().split(3))
    clean = pyoidn.denoise(color, albedo, normal, hdr=True, clean_aux=True)
    return clean.transpose(2, 0, 1).clip(0, 65504).astype(np.float16)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--data", nargs="+", required=True, type=Path, help="folders of views")
    paths = [path for folder in p.parse_args().data for path in sorted(folder.glob("*_v*.npz"))]
    if not paths:
        raise SystemExit("no views (*_v*.npz) in these folders; expected folders of rendered views")
    todo = [path for path in paths if not target_path(path).exists()]
    for done, path in enumerate(todo, 1):
        unfinished = path.with_suffix(".part.npy")
        np.save(unfinished, prefilter(read_view(path)))
        unfinished.replace(target_path(path))
        print(f"\r{done} of {len(todo)} views", end="", flush=True)
    print(f"\n{len(paths)} views have targets")


if __name__ == "__main__":
    main()
