"""Training losses on [B,3,H,W] images in the network domain, by name in `LOSSES` for `train.py --loss`.

The network domain is exposed color after the transfer function, where equal differences are about equally visible.
"""

import torch
from torch.nn import functional as F

from metrics import display, ssim
from transfer import inverse, transfer

PEAK = 0.5  # range of most pixels in the network domain, for SSIM's constants
STEP = 2  # SSIM windows are 11 pixels wide: every second row and column sees every pixel, at half the cost


def l1(output, target):
    return (output - target).abs().mean()


def l1_ssim(output, target):
    """The thesis's loss: 0.9 L1 + 0.1 (1 - SSIM)."""
    return 0.9 * l1(output, target) + 0.1 * (1 - ssim(output, target, PEAK, STEP))


def l1_ms_ssim(output, target):
    """SSIM averaged over three scales, which also sees errors wider than its 11-pixel window."""
    scaled = [(F.avg_pool2d(output, s), F.avg_pool2d(target, s)) for s in (1, 2, 4)]
    likeness = sum(ssim(a, b, PEAK, STEP) for a, b in scaled) / 3
    return 0.9 * l1(output, target) + 0.1 * (1 - likeness)


def l1_gradient(output, target):
    """The thesis's loss plus L1 of differences between neighbors, which keeps edges and texture sharp."""
    d = output - target
    edges = (d[..., :, 1:] - d[..., :, :-1]).abs().mean() + (d[..., 1:, :] - d[..., :-1, :]).abs().mean()
    return l1_ssim(output, target) + 0.5 * edges


def l1_mean(output, target):
    """The thesis's loss plus L1 of 8x8 means: the median of skewed noise is too dark, local means must not be."""
    return l1_ssim(output, target) + 0.5 * l1(F.avg_pool2d(output, 8), F.avg_pool2d(target, 8))


def _mean_light(output, target):
    """L1 of the means of linear light over 8x8 and over 32x32 pixels, in the network domain."""
    return sum(l1(*(transfer(F.avg_pool2d(x, s)) for x in (output, target))) for s in (8, 32))


def l1_light(output, target):
    """The thesis's loss plus L1 of mean light, where pixels count in proportion to their light. In 8x8 means, sparse
    light is still noise; in 32x32 means, lamps keep their light even if they bleed."""
    lights = [inverse(image) for image in (output, target)]
    return l1_ssim(output, target) + 0.4 * _mean_light(*lights)


def display_light(output, target):
    """L1 and SSIM of displayed images, which ignore errors above the display's white, plus a share of the light of 8x8
    and of 32x32 pixels, which counts them."""
    return _shown(inverse(output), inverse(target))


def _shown(*lights):
    """`display_light` of linear light."""
    shown = [display(image) for image in lights]
    return l1(*shown) + 0.05 * (1 - ssim(*shown, 1.0, STEP)) + 0.2 * _mean_light(*lights)


def l1_relative(output, target):
    """The thesis's loss plus relative L1 (SMAPE in the network domain), which gives dark regions more weight."""
    relative = ((output - target).abs() / (output.detach() + target + 0.05)).mean()
    return l1_ssim(output, target) + 0.1 * relative


def display_relative(output, target):
    """`display_light` plus the logarithm of the relative squared error, which also counts errors above the display's
    white. Its gradient falls with one over the error, so fireflies and lamps do not outweigh the rest."""
    x, r = inverse(output), inverse(target)
    error = (x - r) ** 2 / (r.mean(1, keepdim=True) ** 2 + 0.01)
    return _shown(x, r) + torch.log1p(error).mean()


LOSSES = {f.__name__: f for f in (l1_ssim, l1_ms_ssim, l1_gradient, l1_mean, l1_light, l1_relative, display_light,
                                  display_relative)}
