"""Value pipeline shared by training and inference: repair, autoexposure, PU transfer function.

The transfer function is the PU2 fit of Aydin et al. 2008, as used by Intel Open Image Denoise, divided by its value at
65504 so that every half-float color maps into 0..1. All functions take and return torch tensors.
"""

import torch
from torch.nn.functional import avg_pool2d, pad

MAX_COLOR = 65504.0
A, B, C, D = 1.41283765e3, 1.64593172, 0.431384981, -2.94139609e-3
E, F, G = 0.192653254, 6.26026094e-3, 0.998620152
Y0, Y1 = 1.57945760e-6, 3.22087631e-2
X0, X1 = 2.23151711e-3, 3.70974749e-1

LUMINANCE = (0.212671, 0.715160, 0.072169)
BIN, KEY, RANGE, HELD, BRIGHTEST, DARKEST = 16, 0.18, 2.0**33, 16, 1e30, torch.finfo(torch.float32).tiny
OUTLIER = 16  # maximum brightness of a pixel relative to its brightest neighbor


def _pu(y):
    low, middle = A * y, B * y.clamp(min=Y0).pow(C) + D
    high = E * torch.log(y + F) + G
    return torch.where(y <= Y0, low, torch.where(y <= Y1, middle, high))


PU_MAX = float(_pu(torch.tensor(MAX_COLOR, dtype=torch.float64)))


def transfer(color):
    """Exposed linear color (>= 0) to the network domain 0..1, clamped at 65504."""
    return _pu(color.clamp(max=MAX_COLOR)) / PU_MAX


def inverse(x):
    """Network domain 0..1 back to exposed linear color."""
    x = x * PU_MAX
    low, middle = x / A, ((x.clamp(min=X0) - D) / B).pow(1 / C)
    high = torch.exp((x - G) / E) - F
    return torch.where(x <= X0, low, torch.where(x <= X1, middle, high))


def luminance(color):
    return sum(w * c for w, c in zip(LUMINANCE, color.unbind(0)))


def _finite(image):
    return torch.isfinite(image).all(0, keepdim=True)


def fill(image):
    """Replaces non-finite pixels of [3,H,W] by the mean of the finite ones in 3x3, else in 5x5, else by 0."""
    finite = _finite(image)
    known, filled = torch.where(finite, image.clamp(-BRIGHTEST, BRIGHTEST), 0), torch.where(finite, image, 0)
    for distance in (2, 1):
        total, count = (_around(x, distance) for x in (known, finite.to(image.dtype)))
        filled = torch.where(~finite & (count > 0), total / count.clamp(min=1), filled)
    return filled


def _around(x, distance):
    return avg_pool2d(x, 2 * distance + 1, 1, distance, divisor_override=1)


def repair(color, scale):
    """Fills bad pixels, clamps negative values, and darkens outliers to 16 times their neighbors or middle gray."""
    rgb = fill(color).clamp(0, BRIGHTEST)
    around = pad(luminance(torch.where(_finite(color), color.clamp(0, BRIGHTEST), 0)), (1, 1, 1, 1))
    h, w = rgb.shape[1:]
    neighbors = [around[y : y + h, x : x + w] for y in range(3) for x in range(3) if (y, x) != (1, 1)]
    most = OUTLIER * torch.stack(neighbors).amax(0).clamp(min=KEY / scale)
    bright = luminance(rgb)
    return torch.where(bright > most, rgb / bright * most, rgb)


def autoexposure(color):
    """Scale that brings the image [3,H,W] to middle gray: 0.18 / geometric mean of the lit bins' mean luminances.

    Bins are at most 16x16 pixels; weights-format.md defines which are lit. An image without a lit bin keeps scale 1.
    """
    finite = _finite(color)[0]
    light = luminance(torch.where(finite, color, 0).clamp(0, BRIGHTEST))
    rows, cols = _edges(light.shape[0]), _edges(light.shape[1])
    bins = [_bin(light[y0:y1, x0:x1], finite[y0:y1, x0:x1]) for y0, y1 in rows for x0, x1 in cols]
    bins = [(mean, lone) for mean, lone in bins if mean >= DARKEST]
    means = [mean for mean, lone in bins if not lone] or [mean for mean, lone in bins]
    brightest = max(means, default=0)
    lit = torch.tensor([mean for mean in means if mean > brightest / RANGE], dtype=torch.float64)
    return float(KEY / torch.exp2(torch.log2(lit).mean())) if len(lit) else 1.0


def _bin(light, finite):
    """Mean of a bin's finite pixels, the brightest clamped to 16 times the second; whether only one is lit."""
    values = light[finite].double().sort(descending=True).values
    lone = len(values) > 1 and bool(values[0] > 0) and bool(values[1] == 0)
    if len(values) > 1 and not lone:
        values[0] = values[0].clamp(max=HELD * values[1])
    return float(values.sum()) / max(len(values), 1), lone


def _edges(size):
    n = -(-size // BIN)
    return [(i * size // n, (i + 1) * size // n) for i in range(n)]


def network_input(color, albedo, normal, scale):
    """[9,H,W] in the network domain. A missing feature is None and becomes zeros, as in training."""
    absent = torch.zeros_like(color)
    parts = [transfer(repair(color, scale) * scale)]
    parts.append(absent if albedo is None else fill(albedo).clamp(0, 1))
    parts.append(absent if normal is None else fill(normal).clamp(-1, 1) * 0.5 + 0.5)
    return torch.cat(parts)
