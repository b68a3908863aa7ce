"""Denoises a whole render, with the same steps as the program."""

import torch
from torch.nn import functional as F

from transfer import autoexposure, network_input


@torch.no_grad()
def denoise(model, image, inputs="color,albedo,normal"):
    """Linear color [3,H,W] of a render [9,H,W]."""
    color, albedo, normal = image.float().split(3)
    scale = autoexposure(color)
    albedo, normal = albedo if "albedo" in inputs else None, normal if "normal" in inputs else None
    given = network_input(color, albedo, normal, scale, model.outlier)
    m = 2**model.levels
    h, w = color.shape[1:]
    x, light = (F.pad(part[None], (0, -w % m, 0, -h % m), mode="replicate").to(model.device) for part in given)
    return model.denoise(x.contiguous(memory_format=torch.channels_last), light)[0, :, :h, :w].float().cpu() / scale
