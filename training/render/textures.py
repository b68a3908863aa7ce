"""Random textures (float32 [n,n,3] in 0..1, mostly seamless) and environments (radiance, rows from zenith to nadir)."""

import numpy as np


def color(rng, low=0.02, high=0.95):
    """A random albedo: often grayish, sometimes saturated, as often dark as bright."""
    gray = rng.uniform(low, high) if rng.random() < 0.6 else np.exp(rng.uniform(np.log(low), np.log(high)))
    return np.clip(gray * (1 + rng.uniform(0, 1) ** 2 * rng.uniform(-1, 1, 3)), low, high)


def noise(rng, n, slope=1.5, cells=1):
    """Seamless fractal noise in 0..1, smoother with a larger slope, with no features coarser than n/cells pixels."""
    f = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)) * n
    spectrum = np.fft.rfft2(rng.normal(size=(n, n))) * np.where(f < cells, 0, np.maximum(f, 1) ** -slope)
    field = np.fft.irfft2(spectrum, (n, n))
    return np.clip(0.5 + field / field.std() / 5, 0, 1)


def mix(a, b, weight):
    """Blends color a into color b by a field [n,n]."""
    return np.asarray(a) + (np.asarray(b) - np.asarray(a)) * np.asarray(weight)[..., None]


def checker(rng, n=128):
    y, x = _cells(n, 2 * rng.integers(1, 9))
    return mix(color(rng), color(rng), (x + y) % 2)


def stripes(rng, n=128):
    y, x = np.mgrid[:n, :n] / n
    phase = rng.integers(1, 20) * x + rng.choice([0, 0, 1, 4]) * y
    return mix(color(rng), color(rng), phase % 1 < rng.uniform(0.2, 0.8))


def plaid(rng, n=128):
    y, x = np.mgrid[:n, :n] / n
    bands = [(rng.integers(1, 12) * axis) % 1 < rng.uniform(0.2, 0.7) for axis in (x, y)]
    return mix(mix(color(rng), color(rng), bands[0] * 0.5), color(rng), bands[1] * 0.5)


def bricks(rng, n=192):
    """Bricks, or tiles if the rows are not shifted; each has its own shade."""
    rows, columns, gap = 2 * rng.integers(2, 7), rng.integers(2, 6), rng.uniform(0.02, 0.12)
    y, x = np.mgrid[:n, :n] / n
    row = (y * rows).astype(int)
    across = x * columns + rng.choice([0, 0.5]) * (row % 2)
    column = across.astype(int) % columns
    shade = rng.uniform(0.6, 1, (rows, columns))[row, column][..., None]
    mortar = (y * rows % 1 < gap * 1.5) | (across % 1 < gap)
    return mix(mix(color(rng), color(rng), noise(rng, n)) * shade, color(rng), mortar)


def clouds(rng, n=128):
    return mix(color(rng), color(rng), noise(rng, n, rng.uniform(0.8, 2.2), rng.integers(1, 8)))


def wood(rng, n=192):
    y, x = np.mgrid[:n, :n] / n
    rings = np.sin(2 * np.pi * (rng.integers(3, 12) * x + rng.uniform(0.5, 3) * noise(rng, n, 2)))
    fibre = np.repeat(rng.uniform(0.85, 1, (1, n)), n, 0)
    light, dark = color(rng, 0.2, 0.8) * (1, 0.7, 0.45), color(rng, 0.05, 0.5) * (1, 0.65, 0.4)
    return mix(light, dark, rings / 2 + 0.5) * fibre[..., None]


def marble(rng, n=192):
    veins = np.abs(noise(rng, n, 1.6, rng.integers(1, 5)) - 0.5) * rng.uniform(4, 20)
    return mix(color(rng), color(rng), np.clip(veins, 0, 1))


def dots(rng, n=128):
    count = rng.integers(2, 12)
    y, x = np.mgrid[:n, :n] / n * count % 1
    return mix(color(rng), color(rng), np.hypot(x - 0.5, y - 0.5) < rng.uniform(0.1, 0.5))


def text(rng, n=256):
    """Lines of words in an invented script of random 5x3 glyphs."""
    glyphs = rng.random((24, 5, 3)) < 0.6
    scale = rng.choice([1, 2, 4])
    small = np.zeros((n // scale, n // scale), bool)
    for y in range(2, len(small) - 8, 8):
        for x in range(3, len(small) - 6, 4):
            if rng.random() < 0.82:
                small[y:y + 5, x:x + 3] = glyphs[rng.integers(24)]
    ink = np.kron(small, np.ones((scale, scale), bool))
    paper, black = color(rng, 0.5, 0.95), color(rng, 0.02, 0.2)
    return mix(paper, black, ink) if rng.random() < 0.8 else mix(black, paper, ink)


def picture(rng, n=192):
    """Overlapping rectangles and discs over a gradient, like a poster or a photograph."""
    y, x = np.mgrid[:n, :n] / n
    image = mix(color(rng), color(rng), rng.choice([0, 1]) * x * 0.5 + y * 0.5)
    for _ in range(rng.integers(4, 25)):
        (cx, cy), (w, h) = rng.random(2), rng.uniform(0.03, 0.3, 2)
        dx, dy = np.abs(x - cx) / w, np.abs(y - cy) / h
        image = mix(image, color(rng), (dx**2 + dy**2 if rng.random() < 0.5 else np.maximum(dx, dy)) < 1)
    return image * (0.8 + 0.2 * noise(rng, n, 1)[..., None])


def facade(rng, n=192):
    """The front of a house: rows of windows."""
    columns, rows = rng.integers(2, 9, 2)
    y, x = np.mgrid[:n, :n] / n * np.array([rows, columns])[:, None, None]
    w, h = rng.uniform(0.15, 0.42, 2)
    window = (np.abs(x % 1 - 0.5) < w) & (np.abs(y % 1 - 0.5) < h)
    glass = rng.uniform(0.3, 1, (rows, columns))[y.astype(int), x.astype(int)][..., None] * color(rng, 0.02, 0.5)
    wall = mix(color(rng), color(rng), noise(rng, n, 1.2) * 0.4)
    return np.where(window[..., None], glass, wall)


def spectrum(rng, n=128):
    """A smooth change of hue."""
    y, x = np.mgrid[:n, :n] / n
    t = (rng.integers(0, 2) * x + y)[..., None] + rng.random(3)
    return 0.5 + rng.uniform(0.1, 0.45) * np.sin(2 * np.pi * t)


TEXTURES = [checker, stripes, plaid, bricks, clouds, wood, marble, dots, text, picture, facade, spectrum]


def random_texture(rng, choices=TEXTURES):
    return np.clip(choices[rng.integers(len(choices))](rng), 0.02, 0.95).astype(np.float32)


def random_heights(rng, n=192):
    """A height field [n,n] in 0..1: grain, dents, or the softened edges of a pattern."""
    if rng.random() < 0.5:
        return noise(rng, n, rng.uniform(0.8, 2), rng.integers(2, 25))
    pattern = random_texture(rng).mean(-1)
    f = np.hypot(np.fft.fftfreq(len(pattern))[:, None], np.fft.rfftfreq(len(pattern)))
    return np.fft.irfft2(np.fft.rfft2(pattern) * np.exp(-20 * f**2), pattern.shape)  # a Gaussian of one pixel


def light_color(rng):
    """The color of a lamp: mostly between candle and blue sky, sometimes saturated."""
    if rng.random() < 0.15:
        return np.clip(rng.uniform(0, 1, 3) ** 2 + 0.03, 0, 1)
    warm = rng.uniform(0, 1)
    return np.array([1, 0.55 + 0.35 * warm, 0.2 + 0.8 * warm])


def sky(rng, n=128):
    """Clear sky, ground, and a sun of one or two degrees, thousands of times as bright."""
    d = _directions(n)
    zenith, horizon = color(rng, 0.1, 0.4) * (0.5, 0.8, 1.6), color(rng, 0.4, 0.9) * light_color(rng)
    image = mix(horizon, zenith, np.clip(d[..., 2], 0, 1) ** 0.5)
    image = mix(image, color(rng, 0.05, 0.4), d[..., 2] < 0)
    elevation, azimuth = rng.uniform(0.1, 1.3), rng.uniform(0, 6.3)
    sun = d @ _direction(azimuth, elevation)
    image = image + np.exp((sun - 1)[..., None] * 60) * 0.5 * light_color(rng)
    disc = sun > np.cos(np.radians(rng.uniform(1.5, 3)))
    return image + disc[..., None] * 10 ** rng.uniform(2, 3.5) * light_color(rng)


def overcast(rng, n=64):
    d = _directions(n)
    cloud = np.tile(noise(rng, n, 1.6), (1, 2))
    return mix(mix(color(rng, 0.2, 0.9), color(rng, 0.5, 0.95), cloud), color(rng, 0.05, 0.4), d[..., 2] < 0)


def studio(rng, n=64):
    """A dark room with rectangular softboxes."""
    image = np.ones((n, 2 * n, 3)) * color(rng, 0.02, 0.2)
    for _ in range(rng.integers(1, 6)):
        y, x = rng.integers(0, n * 3 // 4), rng.integers(0, 2 * n - 6)
        h, w = rng.integers(3, n // 3), rng.integers(3, n // 2)
        image[y:y + h, x:x + w] = light_color(rng) * 10 ** rng.uniform(0.3, 1.5)
    return image


def night(rng, n=128):
    """Stars, a moon and the glow of a town on the horizon."""
    d = _directions(n)
    image = mix(color(rng, 0.01, 0.04), light_color(rng) * 0.1, np.exp(-np.abs(d[..., 2]) * 8))
    stars = (rng.random((n, 2 * n)) < 0.004) * (d[..., 2] > 0) * rng.exponential(3, (n, 2 * n))
    moon = d @ _direction(rng.uniform(0, 6.3), rng.uniform(0.3, 1.2)) > np.cos(np.radians(2.5))
    return image + stars[..., None] + moon[..., None] * rng.uniform(20, 200) * np.array([0.9, 0.95, 1])


def interior(rng, n=64):
    """A panorama of a room: walls with pictures and furniture, bright windows or lamps."""
    y, x = np.mgrid[:n, :2 * n]
    image = mix(color(rng, 0.1, 0.5), color(rng, 0.03, 0.3), y > n * 0.62)
    image = image * (0.7 + 0.3 * np.cos(x / n * np.pi)[..., None])
    for dim in [True] * rng.integers(5, 20) + [False] * rng.integers(1, 5):
        top, left = rng.integers(n // 4 if dim else 0, n if dim else n // 2), rng.integers(0, 2 * n - 4)
        h, w = rng.integers(2, n // 3, 2)
        image[top:top + h, left:left + w] = color(rng) * 0.5 if dim else light_color(rng) * 10 ** rng.uniform(0.7, 2)
    return image


ENVIRONMENTS = [sky, overcast, studio, night, interior]


def random_environment(rng, choices=ENVIRONMENTS, mean=None):
    """A random environment scaled to a mean radiance that suits lamps of 1 to 50 W/(sr m^2)."""
    image = np.maximum(choices[rng.integers(len(choices))](rng), 1e-4)
    mean = rng.uniform(0.3, 2) if mean is None else mean
    return (image * (mean / image.mean())).astype(np.float32)


def _cells(n, count):
    y, x = np.mgrid[:n, :n]
    return y * count // n, x * count // n


def _direction(azimuth, elevation):
    return np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])


def _directions(n):
    """Unit directions [n,2n,3] of an environment's pixels."""
    theta, phi = np.meshgrid((np.arange(n) + 0.5) / n * np.pi, (np.arange(2 * n) + 0.5) / n * np.pi, indexing="ij")
    return np.stack([np.cos(phi) * np.sin(theta), np.sin(phi) * np.sin(theta), np.cos(theta)], -1)
