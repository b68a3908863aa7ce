"""The blind spots of a no-reference score: scores of references that were degraded without noise."""

import numpy as np
import torch
from torch.nn import functional as F

from augment import splat
from metrics import display, exposure_of, figures
from quality.measure import paths_of
from quality.scene_statistics import features
from quality.store import markdown
from views import read_view


def blocks(image, size=4):
    """The image with each block of size x size pixels replaced by its mean."""
    return F.interpolate(F.avg_pool2d(image[None], size), size=image.shape[1:])[0]


def box(image):
    """The mean of the 5x5 pixels around each pixel."""
    return F.avg_pool2d(image, 5, 1, 2, count_include_pad=False)


def gone(image):
    """The image with its middle third replaced by the mirrored left one."""
    third = image.shape[2] // 3
    return torch.cat([image[..., :third], image[..., :third].flip(2), image[..., 2 * third:]], 2)


HARMS = {
    "nothing": lambda image: image,
    "half as bright": lambda image: image / 2,
    "without color": lambda image: image.mean(0, keepdim=True).expand(3, -1, -1),
    "the middle third replaced": gone,
    "blurred by a Gaussian of 1 pixel": lambda image: splat(image, 1.0),
    "blurred by the mean of 5×5 pixels": box,
    "blocks of 4×4 pixels": blocks,
}


def report(folder, views, regressor):
    """A table of each degradation's effect on the references of these views: mean score, mean 100 (1 - SSIM), and how
    often the degraded picture scores better than the reference."""
    found = {harm: [] for harm in HARMS}
    for path in (p for p in paths_of(folder) if p.stem in views):
        ref = read_view(path)["ref"][:3].float()
        for harm, change in HARMS.items():
            image = change(ref)
            shown = display(image * exposure_of(ref))
            score = float(regressor(features(shown.numpy())[None])[0])
            found[harm].append((score, 100 * (1 - figures(image, ref)["ssim"])))
    untouched = np.array(found["nothing"])[:, 0]
    lines = [[harm, *(f"{v:.0f}" for v in np.mean(pairs, 0)), _better(np.array(pairs)[:, 0], untouched)]
             for harm, pairs in found.items()]
    return markdown(["done to the reference", "score", "100 (1 − SSIM)", "scores better than the reference"], lines)


def _better(scores, untouched):
    return f"{(scores < untouched).sum()} of {len(scores)}"
