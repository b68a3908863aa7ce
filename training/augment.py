"""Random training crops: choice of samples and features, exposure, orientation, color, and light that renders lack."""

import torch
from torch.nn import functional as F

from transfer import DARKEST, KEY, autoexposure, luminance, network_input, transfer

FEATURES = (("all", 0.60), ("albedo", 0.75), ("color", 1.0))  # inputs that a crop keeps, cumulative probability


def splat(image, sigma):
    """[C,H,W] filtered with a Gaussian of `sigma` pixels, truncated at 2 pixels; edges repeat."""
    k = torch.exp(-(torch.arange(-2.0, 3.0) ** 2) / (2 * sigma**2))
    k = (k / k.sum()).view(1, 1, 5)
    along_x = F.conv1d(F.pad(image, (2, 2), mode="replicate").flatten(0, 1)[:, None], k).view_as(image)
    columns = F.pad(along_x.transpose(1, 2), (2, 2), mode="replicate").flatten(0, 1)[:, None]
    return F.conv1d(columns, k).view_as(image.transpose(1, 2)).transpose(1, 2)


def texture(size, cell, kind, low, start=(0, 0)):
    """[1,S,S] with mean 1: checks (kind 0), columns (1), rows (2) or dots (3) of `cell` pixels, in two tones with ratio
    `low`, starting `start` pixels into the pattern."""
    x = ((torch.arange(size) + start[0]) // cell % 2).expand(size, size)
    y = ((torch.arange(size) + start[1]) // cell % 2)[:, None].expand(size, size)
    dark = (x ^ y, x, y, x | y)[kind]
    pattern = torch.where(dark == 1, low, 1.0)
    return (pattern / pattern.mean())[None]


def noisier(view):
    """The view's renders with at most about a quarter of its reference's samples, or else its noisiest one. A denoised
    reference cannot teach a network to denoise renders nearly as good as itself, only to copy its blur."""
    target = view["target"].float()
    scale = autoexposure(target)

    def noise(image):
        return float((transfer(image[:3].float() * scale) - transfer(target * scale)).abs().mean())

    most = 2 * noise(view["ref"])
    return [render for render in view["noisy"] if noise(render[1]) >= most] or view["noisy"][:1]


class Random:
    """Draws all random values of a crop from one generator."""

    def __init__(self, seed):
        self.generator = torch.Generator().manual_seed(seed)

    def uniform(self, low=0.0, high=1.0):
        return low + (high - low) * float(torch.rand((), generator=self.generator))

    def power(self, low, high):
        """A log-uniform number between `low` and `high`."""
        return low * (high / low) ** self.uniform()

    def index(self, n):
        return int(torch.randint(n, (), generator=self.generator))

    def flip(self, odds=0.5):
        return self.uniform() < odds

    def rand(self, *shape):
        return torch.rand(shape, generator=self.generator)

    def gauss(self, *shape):
        return torch.randn(shape, generator=self.generator)

    def order(self, n=3):
        return torch.randperm(n, generator=self.generator)


class Crops:
    """Endless random batches: network input [B,9,S,S], exposed light to gather [B,4,S,S], and target [B,3,S,S] in the
    network domain. `effects` scales the odds of all effects that make a crop unlike a plain render: at 1, one crop in
    seven is plain; at 0.4, every second one."""

    def __init__(self, views, size, seed, effects=1.0):
        self.views, self.size, self.random, self.effects = views, size, Random(seed), effects
        self.renders = [noisier(v) for v in views]
        self.scales = [[autoexposure(image[:3].float()) for _, image in renders] for renders in self.renders]
        # Draw views with noisy references less often; dark and indoor scenes have many.
        self.odds = torch.tensor([1 / (1 + (v["relerr"] / 0.3) ** 2) for v in views])

    def batch(self, count):
        chosen = torch.multinomial(self.odds, count, replacement=True, generator=self.random.generator)
        crops = [self._crop(self.views[i], self.renders[i], self.scales[i]) for i in chosen]
        noisy, target, kept = (torch.stack(parts) for parts in list(zip(*crops))[:3])
        scale = torch.tensor([crop[3] for crop in crops]).view(-1, 1, 1, 1)
        x, light = network_input(*noisy.split(3, 1), scale)
        return x * kept, light, transfer(target * scale)

    def _crop(self, view, renders, scales):
        """Noisy [9,S,S], target [3,S,S], mask of kept inputs [9,1,1], and the exposure."""
        r = self.random
        window = self._window(view["ref"])
        noisy, scale = self._noisy(renders, scales, window)
        target = window(view["target"])
        if self._happens(0.3):
            noisy = self._converged(noisy, target)
        if self._happens(0.15):  # some renderers provide noise-free features
            noisy = torch.cat([noisy[:3], window(view["ref"])[3:]])
        color, features = noisy[:3], noisy[3:]
        if self._happens(0.05):
            color, features, target = self._smooth(features, target)
        if self._happens(0.10):
            color, features, target = self._textured(color, features, target)
        if self._happens(0.10):
            color = self._sparse(color, target)
        if self._happens(0.15):
            color = self._fireflies(color, scale, 1e4) if r.flip() else color
            color, features, target = self._splat(color, features, target)
        if self._happens(0.50):
            color, features, target, scale = self._hue(color, features, target, scale)
        color, features, target = self._lit(color, features, target, scale)
        scale *= 2 ** ((2.0 if r.flip(0.1) else 0.5) * float(r.gauss(1)))
        return torch.cat([color, features[:3], self._frame(features[3:])]), target, self._kept(), scale

    def _happens(self, odds):
        """Whether to apply an effect to this crop."""
        return self.random.flip(self.effects * odds)

    def _noisy(self, renders, scales, window):
        """One render, or sometimes the mean of all, to simulate other sample counts."""
        if len(renders) > 1 and self.random.flip(0.25):
            total = sum(spp for spp, _ in renders)
            return sum(window(image) * (spp / total) for spp, image in renders), sum(scales) / len(scales)
        i = self.random.index(len(renders))
        return window(renders[i][1]), scales[i]

    def _converged(self, noisy, target):
        """The render with at least half of its color noise removed, as with four times the samples or more. Few renders
        have that many, and a network that never sees nearly clean images blurs them."""
        share = self.random.uniform(0.5, 1)
        return torch.cat([noisy[:3].lerp(target, share), noisy[3:]])

    def _smooth(self, features, target):
        """A ramp between two colors with little noise, like a sky; its features are constant or those of the crop."""
        r, mean = self.random, target.mean((1, 2), keepdim=True)
        along = torch.linspace(0, 1, self.size).expand(1, self.size, self.size)
        along = (along + r.uniform(-1, 1) * along.transpose(1, 2)) ** (1 + r.index(2))
        ramp = mean * (1 + r.uniform() * r.rand(3, 1, 1) * along)
        noise = r.gauss(1 if r.flip(0.3) else 3, self.size, self.size) * r.power(2e-4, 3e-2)
        flat = features[:, :1, :1].expand_as(features) * (1 if r.flip() else 0)
        return ramp * (1 + noise).clamp(min=0), flat if r.flip(0.8) else features, ramp

    def _textured(self, color, features, target):
        """The target, its mean color or the noisy color, times a regular texture of one or a few pixels. Renders
        have no such textures, and a network that never sees them takes them for noise. Half of them are in the
        albedo too."""
        r = self.random
        low = 0.0 if r.flip(0.3) else r.power(2**-8, 1)
        cell = 1 + r.index(2) * r.index(4)  # mostly single pixels
        pattern = texture(self.size, cell, r.index(4), low, (r.index(2 * cell), r.index(2 * cell)))
        if r.flip():
            target = target.mean((1, 2), keepdim=True).expand_as(target)
        source = color if r.flip(0.25) else target
        if r.flip():
            features = torch.cat([(features[:3] * pattern).clamp(max=1), features[3:]])
        return source * pattern, features, target * pattern

    def _sparse(self, color, target):
        """Light that few samples hit, in the whole crop or in part of it, like a caustic or a small lamp without direct
        sampling; or samples of one wavelength each. Keeps the mean."""
        r, count = self.random, 2 ** self.random.index(4)
        clean = target if r.flip(0.3) else color
        if r.flip(0.2):
            hits = F.one_hot((r.rand(count, self.size, self.size) * 3).long(), 3)
            return clean * hits.sum(0).permute(2, 0, 1) * (3 / count)
        odds = r.power(0.02, 0.5)
        hits = (r.rand(count, 1, self.size, self.size) < odds).sum(0) / (count * odds)
        return clean * hits if r.flip() else torch.where(self._area() < 1, clean * hits, color)

    def _splat(self, *images):
        """The images blurred with one random Gaussian, which correlates noise like a splatting pixel filter."""
        sigma = self.random.uniform(0.3, 0.8)
        return [splat(image, sigma) for image in images]

    def _hue(self, color, features, target, scale):
        """New colors of light and surfaces: permuted channels, a tint, and sometimes light of nearly one hue, or of the
        same hue everywhere. The exposure follows the luminance."""
        r, order = self.random, self.random.order()
        mix, tint = torch.eye(3)[order], 2 ** (0.2 * r.gauss(3, 1, 1))
        if r.flip(0.2):
            mix = r.rand(3, 3) ** 2
            mix = mix / mix.sum(1, keepdim=True)
        if r.flip(0.25):
            tint = torch.tensor([0.0 if r.flip(0.3) else r.power(1e-3, 1) for _ in range(3)]).view(3, 1, 1)
            tint[r.index(3)] = 1
        change = mix * tint.view(3, 1)
        dimmed = luminance((change @ target.mean((1, 2))).view(3, 1, 1)) / luminance(target).mean().clamp(min=DARKEST)
        color, target = (torch.einsum("oc,chw->ohw", change, image) for image in (color, target))
        return color, torch.cat([features[:3][order], features[3:]]), target, scale / max(float(dimmed), 1e-2)

    def _lit(self, color, features, target, scale):
        """Lamps, fireflies and dark surroundings, each in a few crops."""
        r = self.random
        if self._happens(0.10):
            for _ in range(1 + r.index(3)):
                lamp, light = self._area(0.3) < 1, self._light(r.power(10, 1e5), scale)
                color, target = (torch.where(lamp, light, image) for image in (color, target))
                if r.flip():
                    features = torch.cat([torch.where(lamp, r.uniform(), features[:3]), features[3:]])
        if self._happens(0.10):
            color = self._fireflies(color, scale)
        if self._happens(0.06):
            dim = 0.0 if r.flip() else r.power(1e-6, 1e-3)
            level = torch.where((self._area(0.8) < 1) ^ r.flip(0.2), 1.0, dim)
            color, target = color * level, target * level
            features = features * (level == 1) if r.flip() else features
        return color, features, target

    def _light(self, level, scale):
        """A color [3,1,1] of `level` times middle gray, white or tinted."""
        return level * KEY / scale * 2 ** (self.random.gauss(3, 1, 1) * (0.5 if self.random.flip() else 0))

    def _fireflies(self, color, scale, most=1e6):
        """Makes a few pixels 16 to `most` times brighter."""
        r, color = self.random, color.clone()
        for _ in range(1 + r.index(8)):
            y, x = r.index(self.size), r.index(self.size)
            color[:, y, x] = (color[:, y, x] + 0.1 * KEY / scale) * r.power(16, most) * 2 ** r.gauss(3)
        return color

    def _area(self, largest=1.0):
        """[1,S,S], below 1 inside a random disc or rectangle of at most `largest` times the crop's size."""
        r = self.random
        axis, (x, y) = torch.arange(self.size) / self.size, (r.uniform(), r.uniform())
        across = ((axis - x) / (largest * r.uniform(0.02, 1) / 2)).abs()
        if r.flip():
            down = ((axis - y) / (largest * r.uniform(0.02, 1) / 2)).abs()
            return torch.maximum(across.expand(self.size, -1), down[:, None])[None]
        radius = largest * r.uniform(0.02, 1) / 2
        return ((((axis - x) / radius) ** 2)[None, :] + (((axis - y) / radius) ** 2)[:, None])[None]

    def _window(self, image):
        """A function that cuts the same random square out of images of this size, rotated and mirrored."""
        s, (h, w) = self.size, image.shape[1:]
        y, x = self.random.index(h - s + 1), self.random.index(w - s + 1)
        turns, mirror = self.random.index(4), self.random.index(2)

        def cut(image):
            square = torch.rot90(image[:, y:y + s, x:x + s].float(), turns, (1, 2))
            return square.flip(2) if mirror else square

        return cut

    def _frame(self, normal):
        """Normals, for half of the crops in another frame, because renderers use camera or world space, with y or z
        up."""
        if self.random.flip():
            return normal
        signs = torch.randint(0, 2, (3, 1, 1), generator=self.random.generator) * 2 - 1
        return normal[self.random.order()] * signs

    def _kept(self):
        """[9,1,1]: 0 for the channels of features that this crop lacks."""
        draw = self.random.uniform()
        keep = next(name for name, end in FEATURES if draw < end)
        return torch.tensor([1.0] * 3 + [float(keep != "color")] * 3 + [float(keep == "all")] * 3).view(9, 1, 1)
