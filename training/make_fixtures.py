"""Make small, reproducible inputs and PyTorch results for the tests of the operators and the whole network.

    python make_fixtures.py ../tests/fixtures ../weights/*.safetensors

Without weights files, omits shipped.safetensors, which depends on them. Results are computed from the stored inputs in
float64 and rounded to float32. Images are [C,H,W]. Tensors by file:

* conv3x3.safetensors: input, weight, bias, norm.weight, norm.bias, norm.running_mean, norm.running_var (eps 1e-5);
  expected (convolution and bias), expected_relu (then ReLU), expected_norm_relu (no bias, batch norm, ReLU)
* conv1x1.safetensors: input, weight, bias, expected
* conv_transpose.safetensors: input, weight [in,out,2,2], bias, expected (stride 2)
* max_pool.safetensors: input, expected (2x2)
* concat.safetensors: first, second, expected
* sigmoid.safetensors: input, expected
* transfer.safetensors: input (exposed linear color), expected (0..1); inverse_input (0..1), inverse_expected
* autoexposure.safetensors: input, expected [1,1,1]; black_input, black_expected. `input` has NaN, infinite and negative
  values, an outlier, a lone lit pixel, bins without light, and bins too dark to count fully or at all
* repair.safetensors: color, scale [1,1,1]; expected (linear color), valid (0 or 1). `color` has NaN, infinities,
  negative light and outliers
* pyramid.safetensors: light (color times validity, validity), logits0, expected0 (level 0); logits1, expected1 (next)
* gather.safetensors: light, logits, coarser; expected_bottom (without the coarser level), expected
* shipped.safetensors: color (linear), albedo, normal; expected.fast, ...: linear color from each of the shipped
  weights, computed in float32
* unet_tiny.safetensors: a weights file of widths 4, 6, 10; unet_tiny_io.safetensors: input (network domain), expected
* kernel_tiny.safetensors, a weights file of widths 4, 6, 8; kernel_tiny_io.safetensors: input (network domain), light,
  expected (exposed linear color)
* demodulating_tiny.safetensors, a weights file of widths 4, 6, 8, 10; demodulating_tiny_io.safetensors: input (network
  domain), light, expected (exposed linear color). Sides are no multiples of 8: the last column and row are repeated
"""

import sys
from pathlib import Path

import torch
from safetensors.torch import save_file
from torch.nn import functional as F

from export import save_weights
from model import KernelPyramid, UNet, gather, pyramid
from quality.networks import load_all
from transfer import X0, X1, Y0, Y1, PU_MAX, autoexposure, inverse, repair, transfer

TINY = (4, 6, 10)
TINY_KERNEL = (4, 6, 8)
TINY_DEMODULATING = (4, 6, 8, 10)


def random(generator, *shape, scale=1.0):
    """Normally distributed float64 values that are exact in float32."""
    return (torch.randn(shape, generator=generator) * scale).double()


def operators(g):
    """The tensors of every operator file, by file name."""
    files = dict(conv3x3=conv3x3(g))
    x, w, b = random(g, 6, 5, 7), random(g, 3, 6, 1, 1, scale=0.5), random(g, 3)
    files["conv1x1"] = dict(input=x, weight=w, bias=b, expected=F.conv2d(x, w, b))
    x, w, b = random(g, 6, 3, 5), random(g, 6, 4, 2, 2, scale=0.5), random(g, 4)
    files["conv_transpose"] = dict(input=x, weight=w, bias=b, expected=F.conv_transpose2d(x, w, b, stride=2))
    x = random(g, 3, 6, 10)
    files["max_pool"] = dict(input=x, expected=F.max_pool2d(x, 2))
    first, second = random(g, 3, 4, 5), random(g, 2, 4, 5)
    files["concat"] = dict(first=first, second=second, expected=torch.cat([first, second]))
    x = torch.cat([random(g, 2, 4, 5, scale=3).flatten(), torch.tensor([-120.0, -30, -0.0, 0, 30, 120])]).view(1, 2, -1)
    files["sigmoid"] = dict(input=x, expected=torch.sigmoid(x))
    return files


def conv3x3(g):
    x, w, b = random(g, 5, 9, 11), random(g, 7, 5, 3, 3, scale=0.2), random(g, 7)
    weight, bias, mean, var = random(g, 7), random(g, 7), random(g, 7), random(g, 7).exp().float().double()
    plain, bare = F.conv2d(x, w, b, padding=1), F.conv2d(x, w, padding=1)
    norm = F.batch_norm(bare[None], mean, var, weight, bias, eps=1e-5)[0]
    return {"input": x, "weight": w, "bias": b, "norm.weight": weight, "norm.bias": bias, "norm.running_mean": mean,
            "norm.running_var": var, "expected": plain, "expected_relu": plain.relu(), "expected_norm_relu": norm.relu()}


def transfer_function():
    edges = torch.tensor([0, 1e-10, Y0 * 0.999, Y0 * 1.001, Y1 * 0.999, Y1 * 1.001, 0.18, 1, 65504, 1e6])
    y = torch.cat([edges, torch.logspace(-8, 4.8, 110)]).view(1, 3, 40).double()
    edges = torch.tensor([0, X0 / PU_MAX * 0.999, X0 / PU_MAX * 1.001, X1 / PU_MAX * 0.999, X1 / PU_MAX * 1.001, 1])
    x = torch.cat([edges, torch.linspace(0.001, 0.999, 74)]).view(1, 2, 40).double()
    return dict(input=y, expected=transfer(y), inverse_input=x, inverse_expected=inverse(x))


def exposure(g):
    image = random(g, 3, 37, 50, scale=1.5).exp().float().double()
    image[:, :13, :13] = 0
    image[:, 3, 4] = 1e9
    image[:, 25, 20] = 1e12
    image[:, 25:, 34:] *= 2.0**-10
    image[:, :12, 34:] *= 2.0**-20
    for (y, x), value in {(20, 3): float("nan"), (30, 33): float("inf"), (5, 40): -7.0, (36, 49): float("-inf")}.items():
        image[1, y, x] = value
    black = torch.zeros(3, 5, 4)
    scales = [torch.tensor(autoexposure(i)).view(1, 1, 1) for i in (image, black)]
    return dict(input=image, expected=scales[0], black_input=black, black_expected=scales[1])


def bad_pixels(g):
    color = random(g, 3, 12, 16, scale=1.5).exp().float().double()
    nan, inf = float("nan"), float("inf")
    color[1, 2:8, 3:9] = nan  # a hole too wide to be filled
    color[0, 10, 1], color[2, 10, 3], color[:, 0, 15] = -inf, inf, nan
    color[1, 9:11, 12:14] = inf  # a sun
    color[:, 1, 12], color[:, 11, 7], color[0, 5, 15] = 1e35, 1e6, 1e9
    color[0, 3, 13], color[:, 7, 12] = -0.01, torch.tensor([0.1, -3.0, 0.2])
    scale = 0.75
    expected, valid = repair(color, scale)
    return dict(color=color, scale=torch.tensor(scale).view(1, 1, 1), expected=expected, valid=valid)


def kernel_operators(g):
    """The tensors of the files for the two operators that gather light."""
    light = torch.cat([random(g, 3, 6, 10).exp().float().double(), torch.ones(1, 6, 10)])
    light[:, 2, 3:5] = 0  # missing
    k0, k1 = random(g, 11, 6, 10, scale=3), random(g, 11, 3, 5, scale=3)
    k0[9, 0, 0], k1[9, 1, 1], k0[10, 5, 9], k0[10, 0, 1] = 11, -9, 20, -20  # clamped
    levels = pyramid(light[None], [k0[None], k1[None]])
    fine, coarse = random(g, 4, 6, 10).exp().float().double(), random(g, 4, 3, 5).exp().float().double()
    alone, both = gather(fine[None], k0[None, :10]), gather(fine[None], k0[None], coarse[None])
    return dict(
        pyramid=dict(light=light, logits0=k0, expected0=levels[0][0], logits1=k1, expected1=levels[1][0]),
        gather=dict(light=fine, logits=k0, coarser=coarse, expected_bottom=alone[0], expected=both[0]))


def tiny_net(model, g):
    """The network with random weights and plausible statistics, rounded to the types of the weights file."""
    model = model.double().eval()
    for name, p in model.state_dict().items():
        if name.endswith("running_var"):
            p.copy_(random(g, *p.shape, scale=0.4).exp())
        elif name.endswith("norm.weight"):
            p.copy_(1 + random(g, *p.shape, scale=0.2))
        elif p.ndim == 1:
            p.copy_(random(g, *p.shape, scale=0.2))
        elif p.ndim == 4:
            p.copy_(random(g, *p.shape, scale=(2 / p[0].numel()) ** 0.5).half())
        if p.is_floating_point():
            p.copy_(p.float())
    return model


def shipped(g, paths):
    """A noisy image and the exported networks' results, which the program must reproduce."""
    color, albedo, normal = random(g, 3, 40, 56, scale=1.5).exp(), random(g, 3, 40, 56).sigmoid(), random(g, 3, 40, 56).tanh()
    image = torch.cat([color, albedo, normal]).float()
    results = {f"expected.{n.name}": n(image, "color,albedo,normal") for n in load_all(paths)}
    return dict(color=image[:3], albedo=image[3:6], normal=image[6:]) | results


def kernel_files(folder, g):
    """Saves the kernel-predicting network and returns the tensors of its files, from a generator of their own."""
    model = tiny_net(KernelPyramid(TINY_KERNEL), g)
    save_tiny(folder / "kernel_tiny.safetensors", model)
    x = torch.rand((1, 9, 20, 28), generator=g).double()
    light = torch.cat([random(g, 1, 3, 20, 28).exp().float().double(), torch.ones(1, 1, 20, 28)], 1)
    light[..., 7:9, 11] = 0
    io = dict(input=x[0], light=light[0], expected=model(x, light)[0])
    return kernel_operators(g) | dict(kernel_tiny_io=io, repair=bad_pixels(g))


def demodulation_files(folder, g):
    """Saves the demodulating network and returns the tensors of its files, from a generator of their own."""
    model = tiny_net(KernelPyramid(TINY_DEMODULATING, demodulates=True), g)
    save_tiny(folder / "demodulating_tiny.safetensors", model)
    x = torch.rand((1, 9, 21, 30), generator=g).double()
    x[:, 3:6, 8:, :8] = x[:, 3:6, 8:9, :1]  # no texture
    x[:, 3:6, :5, 20:] = 0  # and black
    light = torch.cat([random(g, 1, 3, 21, 30).exp().float().double(), torch.ones(1, 1, 21, 30)], 1)
    light[..., 7:9, 11] = 0
    whole = [F.pad(image, (0, -30 % 8, 0, -21 % 8), mode="replicate") for image in (x, light)]
    return dict(demodulating_tiny_io=dict(input=x[0], light=light[0], expected=model(*whole)[0, :, :21, :30]))


def save_tiny(path, model):
    save_weights(path, model.state_dict(), model.topology, model.widths, "tiny", "random weights, for tests")


def main():
    if len(sys.argv) < 2:
        raise SystemExit("usage: python make_fixtures.py FOLDER [WEIGHTS ...]")
    folder, g = Path(sys.argv[1]), torch.Generator().manual_seed(20240607)
    folder.mkdir(parents=True, exist_ok=True)
    model = tiny_net(UNet(TINY), g)
    x = torch.rand((1, 9, 20, 28), generator=g).double()
    with torch.no_grad():
        files = operators(g) | dict(transfer=transfer_function(), autoexposure=exposure(g))
        files["unet_tiny_io"] = dict(input=x[0], expected=model(x)[0])
        if sys.argv[2:]:
            files["shipped"] = shipped(g, sys.argv[2:])
        files |= kernel_files(folder, torch.Generator().manual_seed(20261128))
        files |= demodulation_files(folder, torch.Generator().manual_seed(20261130))
    save_tiny(folder / "unet_tiny.safetensors", model)
    for name, tensors in files.items():
        save_file({k: v.float().contiguous() for k, v in tensors.items()}, folder / f"{name}.safetensors")


if __name__ == "__main__":
    main()
