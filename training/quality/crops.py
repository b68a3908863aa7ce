"""Images side by side: noisy, denoised, Open Image Denoise, reference."""

import numpy as np
import torch
from PIL import Image
from torch.nn import functional as F

from metrics import display, exposure_of
from quality.store import ALL, INPUTS
from views import read_view

CROP, GAP = 96, 4  # pixels


def strip(images, ref):
    """Linear images [3,H,W] side by side at the reference's display exposure, as uint8 [H,W,3]."""
    shown = [display(i * exposure_of(ref)) for i in images]
    gap = torch.ones(3, ref.shape[1], GAP)
    row = torch.cat([part for s in shown for part in (s, gap)][:-1], 2)
    return (row * 255).round().byte().permute(1, 2, 0).numpy()


@torch.no_grad()
def save_crops(chosen, folders, ours, other, path, zoom=2):
    """One row per chosen render (pairs of ratio and row), cropped where the two denoisers' errors differ most."""
    rows = [_row(ratio, r, folders[r["set"]], ours, other) for ratio, r in chosen]
    gap = np.full((GAP, rows[0].shape[1], 3), 255, np.uint8)
    picture = np.concatenate([part for r in rows for part in (r, gap)][:-1])
    save_png(path, picture, zoom)


def save_png(path, picture, zoom=1):
    """Saves uint8 [H,W,3]; `zoom` repeats the pixels."""
    size = picture.shape[1] * zoom, picture.shape[0] * zoom
    Image.fromarray(picture).resize(size, Image.Resampling.NEAREST).save(path, optimize=True)


def _row(ratio, row, folder, ours, other):
    view = read_view(folder / f"{row['view']}.npz")
    ref, image = view["ref"][:3].float(), dict(view["noisy"])[row["spp"]]
    mine, theirs = ours(image, INPUTS[ALL]), other(image, INPUTS[ALL])
    y, x = _place(*((mine, theirs) if ratio > 1 else (theirs, mine)), ref)
    size = min(CROP, *ref.shape[1:])
    parts = strip([image[:3].float(), mine, theirs, ref], ref)
    width = ref.shape[2] + GAP
    return np.concatenate([_cut(parts, y, x + i * width, size) for i in range(4)], 1)[:, :-GAP]


def _cut(picture, y, x, size):
    white = np.full((size, GAP, 3), 255, np.uint8)
    return np.concatenate([picture[y : y + size, x : x + size], white], 1)


def _place(worse, better, ref):
    """Top-left corner of the crop in which `worse` loses most to `better`."""
    scale = exposure_of(ref)
    shown = [display(i * scale) for i in (worse, better, ref)]
    loss = ((shown[0] - shown[2]).abs() - (shown[1] - shown[2]).abs()).mean(0)
    sums = F.avg_pool2d(loss[None], min(CROP, *loss.shape), 1)[0]
    return divmod(int(sums.argmax()), sums.shape[1])
