"""Random training crops: choice of samples and features, exposure, orientation and color."""

import torch
from torch.nn import functional as F

from transfer import autoexposure, network_input, transfer

FEATURES = (("all", 0.60), ("albedo", 0.75), ("color", 1.0))  # inputs that a crop keeps, cumulative odds


def splat(image, sigma):
    """[C,H,W] filtered with a Gaussian of `sigma` pixels, cut off at 2 pixels; edges repeat."""
    k = torch.exp(-(torch.arange(-2.0, 3.0) ** 2) / (2 * sigma**2))
    k = (k / k.sum()).view(1, 1, 5)
    along_x = F.conv1d(F.pad(image, (2, 2), mode="replicate").flatten(0, 1)[:, None], k).view_as(image)
    columns = F.pad(along_x.transpose(1, 2), (2, 2), mode="replicate").flatten(0, 1)[:, None]
    return F.conv1d(columns, k).view_as(image.transpose(1, 2)).transpose(1, 2)


def texture(size, cell, kind, low):
    """[1,S,S] with mean 1: checks (kind 0), columns (1) or rows (2) of `cell` pixels, in two tones of ratio `low`."""
    cells = torch.arange(size) // cell
    x, y = cells.expand(size, size), cells[:, None].expand(size, size)
    odd = (x + y, x, y)[kind] % 2
    pattern = torch.where(odd == 1, low, 1.0)
    return (pattern / pattern.mean())[None]


class Crops:
    """Endless random batches (input [B,9,S,S], target [B,3,S,S]) in the network domain."""

    def __init__(self, views, size, seed):
        self.views, self.size = views, size
        self.scales = [[autoexposure(image[:3].float()) for _, image in v["noisy"]] for v in views]
        self.random = torch.Generator().manual_seed(seed)
        # References of dark and indoor scenes are often noisy themselves; draw them less often.
        self.odds = torch.tensor([1 / (1 + (v["relerr"] / 0.3) ** 2) for v in views])

    def batch(self, count):
        chosen = torch.multinomial(self.odds, count, replacement=True, generator=self.random)
        inputs, targets = zip(*(self._crop(self.views[i], self.scales[i]) for i in chosen))
        return torch.stack(inputs), torch.stack(targets)

    def _uniform(self):
        return float(torch.rand((), generator=self.random))

    def _gauss(self, *shape):
        return torch.randn(shape, generator=self.random)

    def _index(self, n):
        return int(torch.randint(n, (), generator=self.random))

    def _crop(self, view, scales):
        window = self._window(view["ref"])
        noisy, scale = self._noisy(view["noisy"], scales, window)
        target = window(view["target"])
        if self._uniform() < 0.3:
            noisy = self._converged(noisy, target)
        scale *= float(2 ** (0.5 * self._gauss()))
        if self._uniform() < 0.15:  # some renderers provide noise-free features
            noisy = torch.cat([noisy[:3], window(view["ref"])[3:]])
        if self._uniform() < 0.15:
            noisy, target = self._splat(noisy, target)
        if self._uniform() < 0.12:
            noisy, target = self._textured(noisy, target)
        color, albedo, normal = noisy.split(3)
        if self._uniform() < 0.5:
            hue = torch.randperm(3, generator=self.random)
            color, albedo, target = color[hue], albedo[hue], target[hue]
            tint = 2 ** (0.2 * self._gauss(3, 1, 1))
            color, target = color * tint, target * tint
        normal = self._frame(normal)
        draw = self._uniform()
        keep = next(name for name, end in FEATURES if draw < end)
        x = network_input(color, None if keep == "color" else albedo, normal if keep == "all" else None, scale)
        return x, transfer(target * scale)

    def _noisy(self, renders, scales, window):
        """One render, or sometimes the mean of all, which simulates other sample counts."""
        if len(renders) > 1 and self._uniform() < 0.25:
            total = sum(spp for spp, _ in renders)
            return sum(window(image) * (spp / total) for spp, image in renders), sum(scales) / len(scales)
        i = self._index(len(renders))
        return window(renders[i][1]), scales[i]

    def _converged(self, noisy, target):
        """The render with at least half of its color noise removed, as from four times the samples or more. Few have
        that many, and a network that never sees nearly clean images blurs them."""
        share = 0.5 + 0.5 * self._uniform()
        return torch.cat([noisy[:3].lerp(target, share), noisy[3:]])

    def _splat(self, *images):
        """The images blurred by one random Gaussian, which correlates noise like a splatting pixel filter."""
        sigma = 0.3 + 0.5 * self._uniform()
        return [splat(image, sigma) for image in images]

    def _textured(self, noisy, target):
        """The clean target, or its mean color, times a regular texture of one or a few pixels. Renders have no such
        textures, and a network that never sees any takes them for noise. Half of them are in the albedo too."""
        low = 0.0 if self._uniform() < 0.3 else float(2 ** (-8 * self._uniform()))
        cell = 1 + self._index(2) * self._index(3)  # mostly single pixels
        pattern = texture(self.size, cell, self._index(3), low)
        if self._index(2):
            target = target.mean((1, 2), keepdim=True).expand_as(target)
        albedo = (noisy[3:6] * pattern).clamp(max=1) if self._index(2) else noisy[3:6]
        return torch.cat([target * pattern, albedo, noisy[6:]]), target * pattern

    def _window(self, image):
        """A function that cuts the same random square out of images of this size, rotated and mirrored."""
        s, (h, w) = self.size, image.shape[1:]
        y, x = self._index(h - s + 1), self._index(w - s + 1)
        turns, mirror = self._index(4), self._index(2)

        def cut(image):
            square = torch.rot90(image[:, y:y + s, x:x + s].float(), turns, (1, 2))
            return square.flip(2) if mirror else square

        return cut

    def _frame(self, normal):
        """Normals, for half of the crops in another frame: renderers differ in camera or world space, y or z up."""
        if self._index(2):
            return normal
        signs = torch.randint(0, 2, (3, 1, 1), generator=self.random) * 2 - 1
        return normal[torch.randperm(3, generator=self.random)] * signs
