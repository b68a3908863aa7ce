"""The networks. Their module names are the tensor names of the weights file.

`state_dict()` maps one-to-one to the safetensors file: `enc_conv0a.weight`, `enc_conv0a.norm.running_mean`,
`kernel_conv3.bias`, ...; only `num_batches_tracked` is not exported.
"""

import torch
from torch import nn
from torch.nn import functional as F

from transfer import OUTLIER, inverse

INPUT_CHANNELS = 9  # color rgb, albedo rgb, normal xyz
TIERS = {
    "fast": (8, 16, 32, 64, 128),
    "balanced": (16, 32, 64, 96, 160),
    "high": (24, 48, 96, 128, 160),
}
TAPS = 9  # of a 3x3 kernel
LIMIT = 8.0  # of log confidence and log share
FLOOR = 0.05  # added to the albedo, so that noise in black does not count as texture
GAIN = 8.0  # of the demodulation logit, so that it learns faster
UNDECIDED = -1 / GAIN  # initial bias of the demodulation logit: a power of 0.27
TINY = torch.finfo(torch.float32).tiny


def widths_of(text):
    """Parses `16,32,64,128,256` to the widths of the levels."""
    return tuple(map(int, text.split(",")))


class ConvBlock(nn.Conv2d):
    """3x3 convolution without bias, batch norm, ReLU. As a child module the norm is named `<layer>.norm`."""

    def __init__(self, cin, cout):
        super().__init__(cin, cout, 3, padding=1, bias=False)
        nn.init.kaiming_normal_(self.weight, nonlinearity="relu")
        self.norm = nn.BatchNorm2d(cout, eps=1e-5, momentum=0.05)

    def forward(self, x):
        return F.relu(self.norm(super().forward(x)), inplace=True)


class Trunk(nn.Module):
    """Encoder, bottom and decoder. The input's sides must be multiples of 2^levels."""

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

    def _block(self, name, cin, cout):
        self.add_module(name + "a", ConvBlock(cin, cout))
        self.add_module(name + "b", ConvBlock(cout, cout))

    def _run(self, name, x):
        return getattr(self, name + "b")(getattr(self, name + "a")(x))

    def features(self, x):
        """Features of every level, from full resolution to the bottom: [B,widths[l],H/2^l,W/2^l]."""
        skips = []
        for l in range(self.levels):
            skips.append(self._run(f"enc_conv{l}", x))
            x = F.max_pool2d(skips[-1], 2)
        found = [self._run("mid_conv", x)]
        for l in reversed(range(self.levels)):
            up = getattr(self, f"dec_up{l}")(found[0])
            found.insert(0, self._run(f"dec_conv{l}", torch.cat([skips[l], up], 1)))
        return found

    @property
    def device(self):
        return self.mid_convb.weight.device


class UNet(Trunk):
    """Predicts color: [B,3,H,W] in the network domain from the input [B,inputs,H,W]."""

    topology = "unet"
    outlier = 16  # brighter outliers would bleed into neighbors

    def __init__(self, widths, inputs=INPUT_CHANNELS):
        super().__init__(widths, inputs)
        self.out_conv = nn.Conv2d(widths[0], 3, 1)

    def forward(self, x):
        f = self.features(x)[0]
        # The last layer and the sigmoid run in f32, as bf16 would quantize the result to 8 bits.
        with torch.autocast(x.device.type, enabled=False):
            return torch.sigmoid(self.out_conv(f.to(self.out_conv.weight.dtype)))

    def denoise(self, x, light):
        """Exposed linear color [B,3,H,W]. Ignores `light`, which other networks gather."""
        return inverse(self(x))


class KernelPyramid(Trunk):
    """Predicts kernels from the input [B,inputs,H,W]: exposed linear color [B,3,H,W] is a weighted mean of `light`
    [B,4,H,W], which holds color times validity, and validity.

    Each level has 3x3 kernels, a log confidence that a pixel is worth gathering, and a log share of the coarser level.
    With `demodulates`, the same weights also gather the albedo; light is multiplied by the ratio of the pixel's own
    albedo to the gathered one, raised to a power given by the last logit at full resolution.
    """

    topology = "kernel-pyramid"
    outlier = OUTLIER

    def __init__(self, widths, inputs=INPUT_CHANNELS, demodulates=False):
        super().__init__(widths, inputs)
        self.demodulates = demodulates
        for l, width in enumerate(widths):
            conv = nn.Conv2d(width, self._logit_count(l), 1)
            nn.init.normal_(conv.weight, std=0.1 / width**0.5)
            nn.init.zeros_(conv.bias)
            self.add_module(f"kernel_conv{l}", conv)
        if demodulates:
            nn.init.zeros_(self.kernel_conv0.weight[-1])
            nn.init.constant_(self.kernel_conv0.bias[-1], UNDECIDED)

    def _logit_count(self, l):
        if l == self.levels:
            return TAPS + 1
        return TAPS + (3 if self.demodulates and l == 0 else 2)

    def forward(self, x, light):
        features = self.features(x)
        # Sums of light need f32; so do logits: bf16 would round weights by up to a percent.
        with torch.autocast(x.device.type, enabled=False):
            logits = [self._logits(l, f) for l, f in enumerate(features)]
            if not self.demodulates:
                return mean_light(light, logits)
            albedo = x[:, 3:6].to(light.dtype)
            both = mean_light(torch.cat([light, albedo * light[:, 3:]], 1), logits)
            ratio = (albedo + FLOOR) / (both[:, 3:] + FLOOR)
            return both[:, :3] * ratio ** torch.sigmoid(GAIN * logits[0][:, -1:])

    def denoise(self, x, light):
        return self(x, light)

    def _logits(self, l, features):
        """The level's conv1x1 in float32, as one matrix product with planar results in any memory layout of the
        features."""
        conv = getattr(self, f"kernel_conv{l}")
        pixels = features.to(conv.weight.dtype).flatten(2)
        planes = torch.matmul(conv.weight.flatten(1), pixels) + conv.bias[:, None]
        return planes.unflatten(2, features.shape[2:])


TOPOLOGIES = {network.topology: network for network in (UNet, KernelPyramid)}


def network_for(topology, widths, state):
    """A network that fits the state dict."""
    options = dict(demodulates=True) if len(state.get("kernel_conv0.bias", ())) > TAPS + 2 else {}
    return TOPOLOGIES[topology](widths, **options)


def with_demodulation(state):
    """The state dict of a kernel pyramid, with an untrained demodulation logit added if it has none."""
    weight, bias = state["kernel_conv0.weight"], state["kernel_conv0.bias"]
    if len(bias) > TAPS + 2:
        return state
    return state | {"kernel_conv0.weight": torch.cat([weight, torch.zeros_like(weight[:1])]),
                    "kernel_conv0.bias": torch.cat([bias, torch.full_like(bias[:1], UNDECIDED)])}


def mean_light(light, logits):
    """The weighted means of `light` [B,C,H,W] without its fourth channel, the validity, by the logits of all levels; 0
    where all weights are 0."""
    total = None
    for p, k in zip(reversed(pyramid(light, logits)), reversed(logits)):
        total = gather(p, k, total)
    weight = total[:, 3:4]
    means = torch.cat([total[:, :3], total[:, 4:]], 1) / weight.clamp(min=TINY)
    return torch.where(weight > 0, means, 0)


def pyramid(light, logits):
    """Premultiplied light [B,C,H/2^l,W/2^l] of every level: 2x2 means of the finer level, times the confidence."""
    levels = [confident(light, logits[0])]
    for k in logits[1:]:
        levels.append(confident(F.avg_pool2d(levels[-1], 2), k))
    return levels


def confident(light, logits):
    return light * logits[:, TAPS:TAPS + 1].clamp(-LIMIT, LIMIT).exp()


def gather(light, logits, coarser=None):
    """3x3 weighted means of `light` [B,C,H,W] with the softmax of the level's kernel logits, plus the share of the
    `coarser` sums [B,C,H/2,W/2], if given."""
    sums = Gather.apply(light, F.softmax(logits[:, :TAPS], 1))
    if coarser is None:
        return sums
    share = logits[:, TAPS + 1:TAPS + 2].clamp(-LIMIT, LIMIT).exp()
    return sums + share * F.interpolate(coarser, scale_factor=2, mode="bilinear", align_corners=False)


class Gather(torch.autograd.Function):
    """Sums 3x3 taps of `light` [B,C,H,W] with `kernels` [B,9,H,W]; edges repeat. Accumulates in place: the automatic
    derivative of nine slices would write and add nine whole images."""

    @staticmethod
    def forward(ctx, light, kernels):
        padded = F.pad(light, (1, 1, 1, 1), mode="replicate")
        ctx.save_for_backward(padded, kernels)
        sums = torch.zeros_like(light)
        for tap, part in _taps(padded):
            sums.addcmul_(kernels[:, tap:tap + 1], part)
        return sums

    @staticmethod
    def backward(ctx, grad):
        padded, kernels = ctx.saved_tensors
        d_padded, d_kernels = torch.zeros_like(padded), torch.empty_like(kernels)
        for (tap, part), (_, d_part) in zip(_taps(padded), _taps(d_padded)):
            d_part.addcmul_(kernels[:, tap:tap + 1], grad)
            torch.sum(part * grad, 1, out=d_kernels[:, tap])
        return _unpad(d_padded), d_kernels


def _taps(padded):
    """The nine shifted views of an image with a one-pixel border, row by row."""
    h, w = padded.shape[2] - 2, padded.shape[3] - 2
    for tap in range(TAPS):
        y, x = divmod(tap, 3)
        yield tap, padded[:, :, y:y + h, x:x + w]


def _unpad(d):
    """The derivative of edge repetition: gradients accumulate in the repeated pixels."""
    d[:, :, 1] += d[:, :, 0]
    d[:, :, -2] += d[:, :, -1]
    d[..., 1] += d[..., 0]
    d[..., -2] += d[..., -1]
    return d[:, :, 1:-1, 1:-1]


def parameter_count(model):
    return sum(p.numel() for p in model.parameters())
