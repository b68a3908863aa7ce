"""Value pipeline shared by training and inference: repair, autoexposure, PU transfer function.

The transfer function is the PU2 fit of Aydin et al. 2008, as used by Intel Open Image Denoise, divided by its value at
65504 so that every half-float color maps into 0..1. All functions take and return torch tensors.
"""

import itertools

import torch
from torch.nn.functional import avg_pool2d, max_pool2d, pad

MAX_COLOR = 65504.0
A, B, C, D = 1.41283765e3, 1.64593172, 0.431384981, -2.94139609e-3
E, F, G = 0.192653254, 6.26026094e-3, 0.998620152
Y0, Y1 = 1.57945760e-6, 3.22087631e-2
X0, X1 = 2.23151711e-3, 3.70974749e-1

LUMINANCE = (0.212671, 0.715160, 0.072169)
BIN, KEY, HELD, BRIGHTEST, DARKEST = 16, 0.18, 16, 1e30, torch.finfo(torch.float32).tiny
RANGE, FADE = 11, 2  # bins darker than the bright ones by 2^11 do not count; those within 2^9 count fully
SUN = 4  # minimum infinite pixels among 3x3; fewer are fireflies
OUTLIER = 256  # maximum brightness of a pixel relative to its brightest neighbor, for networks that gather light


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
    """Luminance [...,H,W] of a color [...,3,H,W]."""
    return sum(w * c for w, c in zip(LUMINANCE, color.unbind(-3)))


def _around(x, distance):
    return avg_pool2d(x, 2 * distance + 1, 1, distance, divisor_override=1)


def fill(image):
    """Replaces non-finite pixels of a feature [...,3,H,W] by the mean of the finite ones in 3x3, else 5x5, else by 0."""
    finite = torch.isfinite(image).all(-3, keepdim=True)
    if finite.all():
        return image
    known, filled = torch.where(finite, image, 0).clamp(-BRIGHTEST, BRIGHTEST), torch.where(finite, image, 0)
    for distance in (2, 1):
        total, count = (_around(x, distance) for x in (known, finite.to(image.dtype)))
        filled = torch.where(~finite & (count > 0), total / count.clamp(min=1), filled)
    return filled


def repair(color, scale, outlier=OUTLIER):
    """Linear color [...,3,H,W] with broken pixels repaired, and validity [...,1,H,W]: 0 where nothing is known.

    Non-finite pixels are filled from their surroundings, suns of +Inf become very bright, pixels of negative luminance
    lose their negative channels, and outliers are darkened to `outlier` times their brightest neighbor or middle gray.
    `scale` is the exposure: a number, or a tensor that broadcasts to [...,1,H,W].
    """
    if torch.isfinite(color).all():
        rgb, valid, around = color, torch.ones_like(color[..., :1, :, :]), _brightest_neighbor(_light(color))
    else:
        rgb, valid, around = _mend(color)
    rgb = rgb.clamp(-BRIGHTEST, BRIGHTEST)
    rgb = torch.where(luminance(rgb).unsqueeze(-3) < 0, rgb.clamp(min=0), rgb)
    bright, most = _light(rgb), outlier * around.clamp(min=KEY / scale)
    return torch.where(bright > most, rgb / bright * most, rgb), valid


def _light(color):
    """The luminance [...,1,H,W] of a color with negative channels set to 0."""
    return luminance(color.clamp(0, BRIGHTEST)).unsqueeze(-3)


def _mend(color):
    """The color with every pixel filled where possible, its validity, and the largest luminance of its eight
    neighbors."""
    sun = _sun(color)
    totals, counts, around = [0, 0], [0, 0], torch.zeros_like(sun)
    for distance, neighbor in _neighbors(color):
        neighbor = torch.where(neighbor == torch.inf, sun, neighbor)
        good = torch.isfinite(neighbor).all(-3, keepdim=True)
        neighbor = torch.where(good, neighbor.clamp(-BRIGHTEST, BRIGHTEST), 0)
        around = torch.maximum(around, _light(neighbor)) if distance == 1 else around
        for reach in range(distance, 3):
            totals[reach - 1], counts[reach - 1] = totals[reach - 1] + neighbor, counts[reach - 1] + good
    rgb = torch.where(color == torch.inf, sun, color)
    valid = torch.isfinite(rgb).all(-3, keepdim=True)
    rgb = torch.where(valid, rgb, 0)
    for total, count in zip(totals, counts):
        rgb = torch.where(~valid & (count > 0), total / count.clamp(min=1), rgb)
        valid = valid | (count > 0)
    return rgb, valid.to(color.dtype), around


def _neighbors(color):
    """The 24 shifted images within two pixels, each with its distance; pixels beyond the border are NaN."""
    h, w = color.shape[-2:]
    wide = pad(color, (2, 2, 2, 2), value=torch.nan)
    for y, x in itertools.product(range(-2, 3), repeat=2):
        if (y, x) != (0, 0):
            yield max(abs(y), abs(x)), wide[..., y + 2:y + 2 + h, x + 2:x + 2 + w]


def _sun(color):
    """What +Inf stands for at each pixel [...,1,H,W]: where at least four of the 3x3 pixels have it, the largest finite
    channel in the 5x5 around, at least 65504. Fewer are fireflies, and it stays infinite."""
    infinite = (color == torch.inf).any(-3, keepdim=True).to(color.dtype)
    brightest = torch.where(torch.isfinite(color), color, MAX_COLOR).amax(-3, keepdim=True).clamp(min=MAX_COLOR)
    return torch.where(_around(infinite, 1) < SUN - 0.5, torch.inf, max_pool2d(brightest, 5, 1, 2))


def _brightest_neighbor(light):
    """The largest value of each pixel's eight neighbors in [...,1,H,W]; those beyond the border count as 0."""
    h, w = light.shape[-2:]
    around = pad(light, (1, 1, 1, 1))
    rows = torch.maximum(around[..., :h, :], around[..., 2:, :])  # the rows above and below
    sides = torch.maximum(around[..., 1:-1, :w], around[..., 1:-1, 2:])
    corners = torch.maximum(torch.maximum(rows[..., :w], rows[..., 2:]), rows[..., 1:-1])
    return torch.maximum(corners, sides)


def autoexposure(color):
    """The scale that exposes the image [3,H,W] to middle gray: 0.18 / geometric mean of the lit bins' mean luminances.

    Bins are at most 16x16 pixels; weights-format.md defines which are lit and how each is weighted. Bins much darker
    than the bright ones do not count, so dark surroundings do not brighten the picture. Without a lit bin, the scale is
    1.
    """
    finite = torch.isfinite(color).all(0)
    light = luminance(torch.where(finite, color, 0).clamp(0, BRIGHTEST))
    rows, cols = _edges(light.shape[0]), _edges(light.shape[1])
    bins = [_bin(light[y0:y1, x0:x1], finite[y0:y1, x0:x1]) for y0, y1 in rows for x0, x1 in cols]
    bins = [(mean, lone) for mean, lone in bins if mean >= DARKEST]
    means = sorted([mean for mean, lone in bins if not lone] or [mean for mean, lone in bins])
    if not means:
        return 1.0
    lit = torch.tensor(means, dtype=torch.float64).log2()
    weight = ((lit - lit[(len(lit) - 1) * 19 // 20] + RANGE) / FADE).clamp(0, 1)
    return float(KEY / torch.exp2((weight * lit).sum() / weight.sum()))


def _bin(light, finite):
    """Mean of a bin's finite pixels, the brightest clamped to 16 times the second; and whether only one is lit."""
    values = light[finite].double().sort(descending=True).values
    lone = len(values) > 1 and bool(values[0] > 0) and bool(values[1] == 0)
    if len(values) > 1 and not lone:
        values[0] = values[0].clamp(max=HELD * values[1])
    return float(values.sum()) / max(len(values), 1), lone


def _edges(size):
    n = -(-size // BIN)
    return [(i * size // n, (i + 1) * size // n) for i in range(n)]


def network_input(color, albedo, normal, scale, outlier=OUTLIER):
    """The network's input [...,9,H,W] in the network domain, and the light that it gathers, [...,4,H,W]: exposed linear
    color and validity, 0 in missing pixels. A missing feature is None and becomes zeros, as in training."""
    absent = torch.zeros_like(color)
    rgb, valid = repair(color, scale, outlier)
    parts = [transfer(rgb.clamp(min=0) * scale)]
    parts.append(absent if albedo is None else fill(albedo).clamp(0, 1))
    parts.append(absent if normal is None else fill(normal).clamp(-1, 1) * 0.5 + 0.5)
    return torch.cat(parts, -3), torch.cat([rgb * scale * valid, valid], -3)
