"""Writes rendered views for views.read_view, which describes the format.

    from write_view import write_view
    write_view("views/s000001_v0.npz", reference, [(4, noisy4), (8, noisy8)], kind="room", ref_relerr=0.05)

Images are float32 [9,H,W]: linear scene-referred color, albedo 0..1, signed unit normal. Give every noisy render and
the reference its own seed, and render without denoising, clamping or a wide pixel filter.
"""

import json
import zipfile

import numpy as np

KEEP_REF, KEEP = 7, 6  # mantissa bits of color to keep: far more than are significant given the noise


def write_view(path, reference, noisy, kind="", ref_relerr=0.0):
    """`noisy` lists (samples per pixel, image); `ref_relerr` is the reference's own relative error, if known."""
    albedo, normal = _levels(reference[3:6], 255, np.uint8, 0), _levels(reference[6:9], 127, np.int8, -127)
    arrays = dict(ref=_split(_delta(_color(reference[:3], KEEP_REF))), ref_alb=_delta(albedo), ref_nrm=_delta(normal))
    for i, (_, image) in enumerate(noisy):
        arrays[f"n{i}"] = _split(_color(image[:3], KEEP))
        arrays[f"n{i}_alb"] = _half(_levels(image[3:6], 255, np.uint8, 0), albedo)
        arrays[f"n{i}_nrm"] = _half(_levels(image[6:9], 127, np.int8, -127), normal)
    meta = dict(spp=[int(spp) for spp, _ in noisy], keep=[KEEP] * len(noisy), keep_ref=KEEP_REF, kind=kind,
                ref_relerr=ref_relerr)
    arrays["meta"] = np.frombuffer(json.dumps(meta).encode(), np.uint8)
    _write(path, arrays)


def _write(path, arrays):
    """Writes an ordinary .npz with LZMA, which packs byte planes a third smaller than np.savez_compressed."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as archive:
        for name, array in arrays.items():
            with archive.open(name + ".npy", "w") as member:
                np.lib.format.write_array(member, np.ascontiguousarray(array))


def _color(color, keep):
    half = np.clip(np.nan_to_num(color, nan=0, posinf=0, neginf=0), 0, 65504).astype(np.float16)
    shift = 10 - keep
    rounded = (half.view(np.uint16).astype(np.int32) + (1 << shift >> 1)) >> shift
    r, g, b = np.minimum(rounded, 0x7BFF >> shift)  # rounding up must not reach infinity
    return np.stack([g, r - g, b - g]).astype(np.int16)


def _levels(image, scale, dtype, low):
    return np.clip(np.rint(np.nan_to_num(image) * scale), low, scale).astype(dtype)


def _split(planes):
    bits = planes.view(np.uint16)
    return np.stack([bits & 255, bits >> 8]).astype(np.uint8)


def _delta(planes):
    return np.diff(planes, axis=-1, prepend=planes.dtype.type(0))


def _half(levels, reference):
    return np.clip(np.rint((levels.astype(np.int16) - reference) / 2), -127, 127).astype(np.int8)
