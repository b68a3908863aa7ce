"""The U-Net. Its module names are the tensor names of the weights file.

`state_dict()` maps one to one onto the safetensors file: `enc_conv0a.weight`, `enc_conv0a.norm.running_mean`,
`dec_up3.bias`, ...; only `num_batches_tracked` is not exported.
"""

import torch
from torch import nn
from torch.nn import functional as F

INPUT_CHANNELS = 9  # color rgb, albedo rgb, normal xyz
TIERS = {
    "fast": (8, 16, 32, 64, 128),
    "balanced": (16, 32, 64, 128, 256),
    "high": (32, 64, 96, 128, 256),
}


class ConvBlock(nn.Conv2d):
    """3x3 convolution without bias, batch norm, ReLU. As a child module the norm is named `<layer>.norm`."""

    def __init__(self, cin, cout):
        super().__init__(cin, cout, 3, padding=1, bias=False)
        nn.init.kaiming_normal_(self.weight, nonlinearity="relu")
        self.norm = nn.BatchNorm2d(cout, eps=1e-5, momentum=0.05)

    def forward(self, x):
        return F.relu(self.norm(super().forward(x)), inplace=True)


class UNet(nn.Module):
    """Input [B,inputs,H,W] in the network domain, H and W multiples of 2^levels; output [B,3,H,W] in 0..1."""

    def __init__(self, widths, inputs=INPUT_CHANNELS):
        super().__init__()
        self.widths, self.inputs = tuple(widths), inputs
        self.levels = len(widths) - 1
        previous = inputs
        for l in range(self.levels):
            self._block(f"enc_conv{l}", previous, widths[l])
            previous = widths[l]
        self._block("mid_conv", previous, widths[-1])
        for l in reversed(range(self.levels)):
            self.add_module(f"dec_up{l}", nn.ConvTranspose2d(widths[l + 1], widths[l], 2, stride=2))
            self._block(f"dec_conv{l}", 2 * widths[l], widths[l])
        self.out_conv = nn.Conv2d(widths[0], 3, 1)

    def _block(self, name, cin, cout):
        self.add_module(name + "a", ConvBlock(cin, cout))
        self.add_module(name + "b", ConvBlock(cout, cout))

    def _run(self, name, x):
        return getattr(self, name + "b")(getattr(self, name + "a")(x))

    def forward(self, x):
        skips = []
        for l in range(self.levels):
            skips.append(self._run(f"enc_conv{l}", x))
            x = F.max_pool2d(skips[-1], 2)
        x = self._run("mid_conv", x)
        for l in reversed(range(self.levels)):
            up = getattr(self, f"dec_up{l}")(x)
            x = self._run(f"dec_conv{l}", torch.cat([skips[l], up], 1))
        # The last layer and the sigmoid run in f32: bf16 would quantize the result to 8 bits.
        with torch.autocast(x.device.type, enabled=False):
            return torch.sigmoid(self.out_conv(x.to(self.out_conv.weight.dtype)))


def parameter_count(model):
    return sum(p.numel() for p in model.parameters())
