"""Value pipeline shared by training and inference: sanitising, autoexposure, PU transfer function.

The transfer function is the PU2 fit of Aydin et al. 2008 (as Intel Open Image Denoise uses it), divided by
its value at 65504 so that every half-float colour maps into 0..1. All functions take and return torch tensors.
"""

import torch

MAX_COLOR = 65504.0
A, B, C, D = 1.41283765e3, 1.64593172, 0.431384981, -2.94139609e-3
E, F, G = 0.192653254, 6.26026094e-3, 0.998620152
Y0, Y1 = 1.57945760e-6, 3.22087631e-2
X0, X1 = 2.23151711e-3, 3.70974749e-1

LUMINANCE = (0.212671, 0.715160, 0.072169)
BIN, KEY, DARK = 16, 0.18, 1e-8


def _pu(y):
    low, middle = A * y, B * y.clamp(min=Y0).pow(C) + D
    high = E * torch.log(y + F) + G
    return torch.where(y <= Y0, low, torch.where(y <= Y1, middle, high))


PU_MAX = float(_pu(torch.tensor(MAX_COLOR, dtype=torch.float64)))


def transfer(color):
    """Exposed linear colour (>= 0) to the network domain 0..1; values above 65504 are clamped."""
    return _pu(color.clamp(max=MAX_COLOR)) / PU_MAX


def inverse(x):
    """Network domain 0..1 back to exposed linear colour."""
    x = x * PU_MAX
    low, middle = x / A, ((x.clamp(min=X0) - D) / B).pow(1 / C)
    high = torch.exp((x - G) / E) - F
    return torch.where(x <= X0, low, torch.where(x <= X1, middle, high))


def sanitise(color):
    """Non-finite and negative values become 0."""
    return torch.where(torch.isfinite(color), color, 0).clamp(min=0)


def autoexposure(color):
    """Scale that brings the image [3,H,W] to middle grey: 0.18 / geometric mean of the bins' mean luminances.

    Bins are at most 16x16 pixels, broken pixels count as black, black bins are skipped, and an image without a lit bin keeps scale 1.
    """
    r, g, b = sanitise(color).unbind(0)
    lum = LUMINANCE[0] * r + LUMINANCE[1] * g + LUMINANCE[2] * b
    rows, cols = _edges(lum.shape[0]), _edges(lum.shape[1])
    means = torch.stack([lum[y0:y1, x0:x1].mean() for y0, y1 in rows for x0, x1 in cols])
    lit = means[means > DARK]
    return float(KEY / torch.exp2(torch.log2(lit).mean())) if len(lit) else 1.0


def _edges(size):
    n = -(-size // BIN)
    return [(i * size // n, (i + 1) * size // n) for i in range(n)]


def network_input(color, albedo, normal, scale):
    """[9,H,W] in the network domain. An absent feature is None and gives zeros, which is what the network learned."""
    absent = torch.zeros_like(color)
    parts = [transfer(sanitise(color) * scale)]
    parts.append(absent if albedo is None else albedo.nan_to_num(0, 0, 0).clamp(0, 1))
    parts.append(absent if normal is None else normal.nan_to_num(0, 0, 0).clamp(-1, 1) * 0.5 + 0.5)
    return torch.cat(parts)
