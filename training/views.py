"""Reads rendered views (.npz), caches them decoded, and splits scenes into training, validation and test.

A file `SCENE_vV.npz` holds view V of a scene as planar [3,H,W] arrays in three encodings:

* color (`ref`, `n0`, `n1`, ...): float16 bit patterns without their low 10-keep mantissa bits, as int16 planes
  (G, R-G, B-G), split into two byte planes [2,3,H,W] (low bytes, high bytes). `ref` is also differenced along x. `keep`
  is `meta["keep_ref"]`, or `meta["keep"][i]` for `n<i>`.
* reference features: `ref_alb` uint8 (albedo*255) and `ref_nrm` int8 (normal*127), differenced along x, wrapping.
* noisy features `n<i>_alb`, `n<i>_nrm`: int8, half the difference from the decoded reference's levels.

`meta` is UTF-8 JSON in a uint8 array: `spp` (samples per pixel of n0, n1, ...), `keep`, `keep_ref`, `kind`,
`ref_relerr` (estimated relative error of the reference). Other members are ignored.
"""

import hashlib
import json
import os
from pathlib import Path

import numpy as np
import torch

SPLIT = {"train": (0.0, 0.76), "val": (0.76, 0.90), "test": (0.90, 1.0)}  # shares of the scenes


def target_path(path):
    """The path of the denoised reference that prefilter.py writes for the view `path`."""
    return Path(path).with_suffix(".target.npy")


def read_view(path):
    """One view: {name, scene, kind, relerr, ref [9,H,W], noisy [(spp, [9,H,W])]}, float16 color, albedo, normal."""
    z = np.load(path)
    meta = json.loads(z["meta"].tobytes())
    albedo, normal = _integrate(z["ref_alb"]), _integrate(z["ref_nrm"])
    ref = _stack(_color(_integrate(_join(z["ref"])), meta["keep_ref"]), albedo, normal)
    noisy = []
    for i, spp in enumerate(meta["spp"]):
        color = _color(_join(z[f"n{i}"]), meta["keep"][i])
        features = _from_half(z[f"n{i}_alb"], albedo, 0, 255), _from_half(z[f"n{i}_nrm"], normal, -127, 127)
        noisy.append((spp, _stack(color, *features)))
    name = Path(path).stem
    return dict(name=name, scene=name.split("_v")[0], kind=meta.get("kind", ""), ref=ref, noisy=noisy,
                relerr=float(meta.get("ref_relerr", 0)))


def _join(planes):
    return (planes[0].astype(np.uint16) | planes[1].astype(np.uint16) << 8).view(np.int16)


def _integrate(differences):
    return np.cumsum(differences.astype(np.int64), -1).astype(differences.dtype)


def _color(planes, keep):
    g, dr, db = planes.astype(np.int32)
    bits = np.stack([g + dr, g, g + db]) << (10 - keep)
    return bits.astype(np.uint16).view(np.float16)


def _from_half(difference, reference, low, high):
    return np.clip(reference.astype(np.int16) + 2 * difference.astype(np.int16), low, high)


def _stack(color, albedo, normal):
    parts = color, albedo.astype(np.float32) / 255, normal.astype(np.float32) / 127
    return torch.from_numpy(np.concatenate([p.astype(np.float16) for p in parts]))


def load_views(folders, cache=None, prefiltered=False):
    """All views in the folders, each with a `target` [3,H,W]: its reference's color, or prefilter.py's version of it.

    Decoding is slow, so the folder `cache`, if given, keeps decoded views.
    """
    paths = sorted(p for f in folders for p in Path(f).glob("*_v*.npz"))
    if not paths:
        raise SystemExit(f"no views (*_v*.npz) in {', '.join(map(str, folders))}; expected folders of rendered views")
    views = [_cached(p, Path(cache)) if cache else read_view(p) for p in paths]
    return [v | dict(target=_target(p) if prefiltered else v["ref"][:3]) for p, v in zip(paths, views)]


def _target(path):
    if not target_path(path).exists():
        raise SystemExit(f"{target_path(path)} is missing: run prefilter.py on its folder first")
    return torch.from_numpy(np.load(target_path(path)))


def _cached(path, cache):
    """The view of `path`, decoded into the cache at first use. Memory-mapped, so that processes share it."""
    state = path.stat()
    key = hashlib.sha256(f"{path.resolve()} {state.st_size} {state.st_mtime_ns}".encode()).hexdigest()[:16]
    kept = cache / f"{path.stem}-{key}.pt"
    if not kept.exists():
        cache.mkdir(parents=True, exist_ok=True)
        unfinished = kept.with_suffix(f".{os.getpid()}")
        torch.save(read_view(path), unfinished)
        unfinished.replace(kept)
    return torch.load(kept, mmap=True)


def part(views, name):
    """The views of one part: "train", "val" or "test". A hash of its name assigns each scene, so adding scenes moves
    no others."""
    low, high = SPLIT[name]
    return [v for v in views if low <= _place(v["scene"]) < high]


def _place(scene):
    return int.from_bytes(hashlib.sha256(scene.encode()).digest()[:6], "big") / 2**48
