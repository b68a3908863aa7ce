"""Error metrics of a denoised image against its reference; SSIM is differentiable.

All figures take linear color [3,H,W]. Display images are exposed so that the reference's log-average luminance is
0.18, clipped to 0..1 and sRGB encoded.
"""

import torch
from torch.nn import functional as F

LUMA = torch.tensor([0.2126, 0.7152, 0.0722])


def exposure_of(ref):
    lum = torch.einsum("c,chw->hw", LUMA, ref).clamp(min=0)
    lit = lum[lum > 1e-8]
    return float(0.18 / lit.log().mean().exp()) if lit.numel() else 1.0


def display(color):
    x = color.clamp(0, 1)
    return torch.where(x <= 0.0031308, 12.92 * x, 1.055 * x.clamp(min=1e-8).pow(1 / 2.4) - 0.055)


def figures(image, ref):
    """{l1, psnr, ssim, relmse, smape} of a linear image [3,H,W]; lower is better, except for psnr and ssim."""
    scale = exposure_of(ref)
    x, r = image * scale, ref * scale
    a, b = display(x), display(r)
    relative = ((x - r) ** 2 / (r.mean(0) ** 2 + 0.01)).mean(0).flatten().sort().values
    return dict(
        l1=float((a - b).abs().mean()),
        psnr=float(-10 * ((a - b) ** 2).mean().clamp(min=1e-12).log10()),
        ssim=float(ssim(a[None], b[None], 1.0)),
        relmse=float(relative[: max(1, int(len(relative) * 0.999))].mean()),
        smape=float(((x - r).abs() / (x.abs() + r.abs() + 0.01)).mean()),
    )


def ssim(a, b, peak, step=1):
    """Mean SSIM of [B,C,H,W] images with an 11x11 Gaussian window (sigma 1.5). Counts only windows inside the image, in
    every `step`th row and column."""
    moments = torch.cat([a, b, a * a, b * b, a * b], 1)
    ma, mb, aa, bb, ab = _blur(moments, step).chunk(5, 1)
    c1, c2 = (0.01 * peak) ** 2, (0.03 * peak) ** 2
    likeness = (2 * ma * mb + c1) * (2 * (ab - ma * mb) + c2)
    return (likeness / ((ma**2 + mb**2 + c1) * (aa - ma**2 + bb - mb**2 + c2))).mean()


def _blur(x, step):
    k = torch.exp(-(torch.arange(-5.0, 6.0) ** 2) / (2 * 1.5**2))
    k = (k / k.sum()).to(x.device)
    h, w = x.shape[2:]
    # Uses banded matrices, because depthwise convolutions are slow on a CPU.
    rows = torch.stack([F.pad(k, (i, h - 11 - i)) for i in range(0, h - 10, step)])
    cols = torch.stack([F.pad(k, (i, w - 11 - i)) for i in range(0, w - 10, step)])
    return ((x @ cols.T).transpose(2, 3) @ rows.T).transpose(2, 3)
