"""Building blocks of the random scenes: materials, placement, rooms and lights."""

import numpy as np

from . import meshes
from .scene import Instance, Material, PointLight
from .textures import color, light_color, random_texture


def at(position=(0, 0, 0), scale=1.0, turn=0.0, tilt=0.0):
    """A matrix that scales, tilts about x, turns about z (radians), then moves to `position`."""
    c, s, ct, st = np.cos(turn), np.sin(turn), np.cos(tilt), np.sin(tilt)
    matrix = np.eye(4)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, ct, -st], [0, st, ct]])
    matrix[:3, :3] = rotation * np.broadcast_to(scale, 3)
    matrix[:3, 3] = position
    return matrix.astype(np.float32)


def material(rng, kinds=("diffuse", "diffuse", "plastic", "metal", "glass"), textured=0.35):
    """A random material of one of the kinds, with a texture at probability `textured`."""
    kind = kinds[rng.integers(len(kinds))]
    roughness = rng.choice([0.0, 0.05, rng.uniform(0.1, 0.6), rng.uniform(0.1, 0.6)])
    if kind == "glass":
        clear = rng.uniform(0.7, 1, 3) if rng.random() < 0.5 else np.ones(3) * 0.98
        return Material(kind, tuple(clear), float(rng.choice([0, 0, roughness])), float(rng.uniform(1.3, 1.7)))
    albedo = color(rng, 0.4, 0.95) if kind == "metal" else color(rng)
    texture = random_texture(rng) if kind in ("diffuse", "plastic") and rng.random() < textured else None
    return Material(kind, tuple(albedo), float(roughness), texture=texture)


def palette(rng, n, **options):
    """A few materials for a scene's objects to share, so that renderers can merge the objects."""
    return [material(rng, **options) for _ in range(n)]


def matte(rng, textured=0.4):
    return material(rng, ("diffuse", "diffuse", "plastic"), textured)


def glow(rng, strength):
    """An emitter with about this radiance."""
    return Material(emission=tuple(light_color(rng) * strength))


def lamp(rng, position, power, radius=0.02):
    return PointLight(tuple(position), tuple(light_color(rng) * power), radius)


def pick(rng, options):
    return options[rng.integers(len(options))]


def solid(rng):
    """A random mesh of unit size standing on z = 0."""
    makers = [meshes.box, meshes.box, meshes.sphere, meshes.cylinder, meshes.torus,
              lambda: meshes.cone(rng.choice([0, 0.4])), lambda: meshes.rounded(rng.uniform(0.2, 0.6)),
              lambda: meshes.blob(rng, rng.integers(2, 16)), lambda: meshes.vase(rng),
              lambda: meshes.cylinder(sides=rng.integers(3, 9)), lambda: knot(rng)]
    return pick(rng, makers)()


def knot(rng):
    """A wire bent into a closed curve."""
    t = np.linspace(0, 2 * np.pi, 120)
    p, q = rng.integers(1, 4), rng.integers(2, 7)
    r = 0.3 + 0.13 * np.cos(q * t)
    points = np.stack([r * np.cos(p * t), r * np.sin(p * t), 0.5 + 0.4 * np.sin(q * t)], -1)
    return meshes.tube(points, rng.uniform(0.01, 0.07), 10)


def scatter(rng, materials, n, area, size, z=0.0, make=solid):
    """n objects standing at height z within area (x0, x1, y0, y1), apart if possible; size is a range."""
    placed, instances = [], []
    for _ in range(n):
        extent = np.exp(rng.uniform(*np.log(size)))
        for _ in range(20):
            x, y = rng.uniform(area[0], area[1]), rng.uniform(area[2], area[3])
            if all((x - a) ** 2 + (y - b) ** 2 > (extent + e) ** 2 / 3 for a, b, e in placed):
                break
        placed.append((x, y, extent))
        scale = extent * rng.uniform((0.6, 0.6, 0.5), (1, 1, 1.5))
        instances.append(Instance(make(rng), pick(rng, materials), at((x, y, z), scale, rng.uniform(0, 6.3))))
    return instances


def stack(rng, materials, n, position, size):
    """Boxes piled up at `position`, each slightly rotated and smaller than the one below."""
    instances, (x, y, z) = [], position
    for _ in range(n):
        scale = size * rng.uniform((0.7, 0.7, 0.15), (1, 1, 0.5))
        instances.append(Instance(meshes.box(), pick(rng, materials), at((x, y, z), scale, rng.uniform(0, 6.3))))
        z, size = z + scale[2] + 0.001, size * 0.95
    return instances


def table(rng, surface, width, depth, height, position=(0, 0)):
    """A top on four legs."""
    x, y = position
    parts = [meshes.moved(meshes.box(), at((x, y, height - 0.04), (width, depth, 0.04)))]
    for sx, sy in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
        leg = at((x + sx * (width / 2 - 0.05), y + sy * (depth / 2 - 0.05), 0), (0.05, 0.05, height - 0.04))
        parts.append(meshes.moved(meshes.box(), leg))
    return Instance(meshes.merge(parts), surface)


def wall(width, height, window=None):
    """An upright wall (x along it, z up), with a hole at `window` (x0, x1, z0, z1)."""
    xs, zs, holes = [-width / 2, width / 2], [0, height], []
    if window:
        xs, zs, holes = [xs[0], *window[:2], xs[1]], [zs[0], *window[2:], zs[1]], [(1, 1)]
    return meshes.moved(meshes.lattice(xs, zs, holes), at(tilt=np.pi / 2))


def room(rng, width, depth, height, windows=0, textured=0.4):
    """Floor, ceiling and four walls around the origin, `windows` of them with a hole."""
    walls, ceiling = matte(rng, textured), matte(rng, 0)
    floor = material(rng, ("diffuse", "plastic", "plastic"), textured)
    instances = [Instance(meshes.plane(width, depth), floor),
                 Instance(meshes.plane(width, depth), ceiling, at((0, 0, height), tilt=np.pi))]
    open_sides = rng.permutation(4)[:windows]
    for side in range(4):
        length, distance = (width, depth) if side % 2 == 0 else (depth, width)
        opening = window_in(rng, length, height) if side in open_sides else None
        turn = side * np.pi / 2
        position = (-np.sin(turn) * distance / 2, np.cos(turn) * distance / 2, 0)
        instances.append(Instance(wall(length, height, opening), walls, at(position, turn=turn)))
    return instances


def window_in(rng, length, height):
    """A random opening in a wall."""
    w, h = rng.uniform(0.2, 0.8) * length, rng.uniform(0.3, 0.8) * height
    x = rng.uniform(-length / 2 + 0.05, length / 2 - w - 0.05)
    z = rng.uniform(0.05, height - h - 0.05)
    return x, x + w, z, z + h


def panel(rng, position, width, depth, strength, tilt=0.0, turn=0.0):
    """A rectangular lamp shining down, or towards -y if tilted by -90 degrees."""
    return Instance(meshes.plane(width, depth), glow(rng, strength), at(position, turn=turn, tilt=np.pi + tilt))
