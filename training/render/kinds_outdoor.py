"""Random outdoor places: plants, terrain and streets."""

import numpy as np

from . import meshes
from .placing import at, glow, lamp, material, matte, palette, pick, scatter, solid
from .scene import Instance, Material, Scene
from .textures import bricks, clouds, facade, marble, night, noise, overcast, random_environment, random_texture, sky
from .viewpoints import cameras


def _terrain(rng, size, height, n=96, slope=2.2):
    """A heightfield, and a function for its height at points x, y."""
    heights = (noise(rng, n, slope) - 0.5) * height
    def level(x, y):
        i, j = (np.clip(((c / size + 0.5) * (n - 1)).astype(int), 0, n - 1) for c in (np.asarray(x), np.asarray(y)))
        return heights[i, j]
    return meshes.heightfield(heights, size), level


def _earth(rng):
    return Material("diffuse", texture=random_texture(rng, [clouds, clouds, marble]))


def _green(rng, kind="thin_leaf"):
    """A plant color of some season."""
    return Material(kind, tuple(np.clip(rng.uniform((0.05, 0.15, 0.02), (0.5, 0.6, 0.15)), 0, 1)))


def _grass(rng, level, center, radius, n, length):
    x, y = np.asarray(center)[:, None] + rng.uniform(-radius, radius, (2, n))
    roots = np.stack([x, y, level(x, y)], -1)
    up = np.tile([0, 0, 1.0], (n, 1)) + rng.normal(0, 0.2, 3) * (1, 1, 0)
    return meshes.strands(rng, roots, up, length, length * rng.uniform(0.02, 0.1), rng.uniform(0.2, 1.2))


def _tree(rng, position, height, n):
    """Trunk and branches as one mesh, a crown of n leaves as another."""
    t = np.linspace(0, 1, 8)[:, None]
    bend = rng.normal(0, 0.08, (8, 3)) * t * height
    parts = [meshes.tube(np.array(position) + t * (0, 0, height * 0.75) + bend, height * 0.035 * (1.2 - t[:, 0]))]
    tips = []
    for _ in range(rng.integers(4, 12)):
        start = parts[0].vertices[rng.integers(len(parts[0].vertices) // 2, len(parts[0].vertices))]
        tip = start + rng.normal(0, 0.25, 3) * height * (1, 1, 0.6) + (0, 0, 0.1 * height)
        parts.append(meshes.tube(start + (tip - start) * t + bend / 3, height * 0.012 * (1.1 - t[:, 0]), 5))
        tips.append(tip)
    centers = np.array(tips)[rng.integers(len(tips), size=n)] + rng.normal(0, 0.12 * height, (n, 3))
    return meshes.merge(parts), meshes.leaves(rng, centers, height**0.5 * rng.uniform(0.02, 0.06))


def grass(rng):
    """Close to the ground of a meadow with stones and flowers."""
    ground, level = _terrain(rng, 8, 0.5)
    instances = [Instance(ground, _earth(rng))]
    for green in (_green(rng), _green(rng), _green(rng, "plastic")):
        blades = _grass(rng, level, (0, 0), 1.8, rng.integers(1500, 5000), rng.uniform(0.08, 0.4))
        instances.append(Instance(blades, green))
    stones = scatter(rng, palette(rng, 3, kinds=("diffuse", "plastic")), 8, (-1.5, 1.5, -1.5, 1.5), (0.06, 0.35), 0,
                     lambda r: meshes.blob(r, 8))
    targets = [(*rng.uniform(-0.8, 0.8, 2), 0.1) for _ in range(3)]
    return Scene("grass", instances + stones, cameras(rng, instances + stones, targets, (0.8, 2.5), (0.35, 1.2)),
                 environment=random_environment(rng, [sky, sky, overcast]))


def forest(rng):
    """Trees with leaves, and dappled shade on the ground."""
    ground, level = _terrain(rng, 30, 2)
    bark, leaf = _earth(rng), [_green(rng), _green(rng)]
    instances = [Instance(ground, _earth(rng)), Instance(_grass(rng, level, (0, 0), 5, 4000, 0.25), leaf[0])]
    for _ in range(rng.integers(4, 12)):
        x, y = rng.uniform(-6, 6, 2)
        trunk, crown = _tree(rng, (x, y, float(level(x, y)) - 0.1), rng.uniform(2, 6), rng.integers(500, 3000))
        instances += [Instance(trunk, bark), Instance(crown, pick(rng, leaf))]
    targets = [(*rng.uniform(-3, 3, 2), rng.uniform(0.5, 2)) for _ in range(4)]
    return Scene("forest", instances, cameras(rng, instances, targets, (2, 8), (1.5, 3)),
                 environment=random_environment(rng, [sky, sky, overcast]))


def leaf_cluster(rng):
    """A close-up of twigs and leaves, many of them backlit."""
    instances = []
    for _ in range(rng.integers(1, 4)):
        trunk, crown = _tree(rng, (*rng.uniform(-0.5, 0.5, 2), 0), rng.uniform(0.8, 1.5), rng.integers(100, 800))
        green = _green(rng, pick(rng, ["thin_leaf", "thin_leaf", "plastic"]))
        instances += [Instance(trunk, matte(rng)), Instance(crown, green)]
    instances.append(Instance(meshes.plane(6, 6), matte(rng)))
    targets = [(*rng.uniform(-0.3, 0.3, 2), rng.uniform(0.6, 1.1)) for _ in range(3)]
    return Scene("leaf_cluster", instances, cameras(rng, instances, targets, (0.6, 1.8), (0.4, 1.6)),
                 environment=random_environment(rng))


def mountains(rng):
    """Bare terrain with rocks, sometimes with water."""
    ground, level = _terrain(rng, 40, rng.uniform(4, 12), 160, rng.uniform(1.8, 2.4))
    instances = [Instance(ground, _earth(rng))]
    for _ in range(rng.integers(5, 40)):
        x, y = rng.uniform(-12, 12, 2)
        scale = rng.uniform(0.2, 2) * rng.uniform(0.6, 1.2, 3)
        place = at((x, y, float(level(x, y)) - 0.2), scale, rng.uniform(0, 6))
        instances.append(Instance(meshes.blob(rng, 14), instances[0].material, place))
    if rng.random() < 0.5:
        water = Material("plastic", (0.02, 0.05, 0.06), 0.05)
        instances.append(Instance(meshes.plane(40, 40), water, at((0, 0, -0.6))))
    targets = [(x, y, float(level(x, y))) for x, y in rng.uniform(-8, 8, (4, 2))]
    return Scene("mountains", instances, cameras(rng, instances, targets, (5, 14), (1.5, 6)),
                 environment=random_environment(rng, [sky, sky, overcast, night]))


def _houses(rng, fronts, n):
    """Blocks of textured houses on both sides of streets."""
    instances = []
    for x in range(-n, n + 1):
        for y in range(-n, n + 1):
            scale = rng.uniform((6, 6, 5), (9, 9, 35))
            house = meshes.box()
            house.uvs = (house.uvs + 0.5) * np.round(scale[2] / 8)
            instances.append(Instance(house, pick(rng, fronts), at((x * 14 + 7, y * 14 + 7, 0), scale)))
    return instances


def city(rng):
    """Streets between houses by day."""
    fronts = [Material(kind, roughness=0.1, texture=random_texture(rng, [facade, facade, bricks]))
              for kind in ("diffuse", "diffuse", "plastic", "plastic", "plastic")]
    instances = [Instance(meshes.plane(200, 200), matte(rng))] + _houses(rng, fronts, 3)
    instances += scatter(rng, palette(rng, 4), 25, (-2.5, 2.5, -20, 20), (0.5, 2.5))
    targets = [(rng.uniform(-4, 4), rng.uniform(-12, 12), rng.uniform(1, 10)) for _ in range(4)]
    return Scene("city", instances, cameras(rng, instances, targets, (5, 40), (1.5, 25)),
                 environment=random_environment(rng, [sky, sky, overcast]))


def night_street(rng):
    """Street lamps and lit signs in the dark; sometimes misty."""
    fronts = [Material("diffuse", texture=random_texture(rng, [facade, bricks])) for _ in range(4)]
    wet = Material("plastic", (0.05, 0.05, 0.05), float(rng.uniform(0.05, 0.4)))
    instances = [Instance(meshes.plane(200, 200), wet)] + _houses(rng, fronts, 2)
    post, lights = material(rng, ("metal",)), []
    for y in np.arange(-15, 16, rng.uniform(5, 10)):
        x = rng.choice([-2.5, 2.5])
        instances.append(Instance(meshes.tube([(x, y, 0), (x, y, 3), (x * 0.9, y, 4), (x * 0.6, y, 4.2)], 0.05), post))
        lights.append(lamp(rng, (x * 0.6, y, 4), rng.uniform(30, 100), 0.12))
    for _ in range(rng.integers(0, 5)):
        sign = at((rng.choice([-2.3, 2.3]), rng.uniform(-12, 12), rng.uniform(2, 5)), rng.uniform(0.2, 0.8))
        instances.append(Instance(solid(rng), glow(rng, rng.uniform(2, 10)), sign))
    instances += scatter(rng, palette(rng, 5), 15, (-2, 2, -15, 15), (0.3, 1.5))
    targets = [(rng.uniform(-2, 2), rng.uniform(-6, 6), rng.uniform(0.5, 2.5)) for _ in range(3)]
    views = cameras(rng, instances, targets, (4, 12), (0.8, 4), bounds=(-2.6, 2.6, -25, 25, 0.5, 5))
    return Scene("night_street", instances, views, lights, random_environment(rng, [night], 0.03),
                 fog=pick(rng, [0, 0, 0, rng.uniform(0.01, 0.05)]))


def fence(rng):
    """Thin bars, wires and netting in front of a scene in daylight."""
    instances, wire = [Instance(meshes.plane(40, 40), matte(rng))], material(rng, ("metal", "plastic", "diffuse"), 0)
    bars = [meshes.tube([(x, 0, 0), (x, 0, 0.7), (x, 0, 1.4)], rng.uniform(0.004, 0.03), 6)
            for x in np.arange(-2, 2, rng.uniform(0.06, 0.2))]
    bars += [meshes.tube([(-2, 0, z), (0, rng.uniform(-0.1, 0), z), (2, 0, z)], 0.008, 6)
             for z in np.arange(0.2, 1.4, rng.uniform(0.1, 0.5))]
    instances.append(Instance(meshes.merge(bars), wire))
    instances += scatter(rng, palette(rng, 5), 14, (-3, 3, 0.5, 5), (0.3, 1.5))
    instances += scatter(rng, palette(rng, 3), 4, (-2, 2, -1.5, -0.4), (0.1, 0.4))
    targets = [(0, 0, 0.7), (0.5, 0.3, 0.4), (-0.6, 0, 1)]
    return Scene("fence", instances, cameras(rng, instances, targets, (1, 4), (0.4, 2)),
                 environment=random_environment(rng, [sky, sky, overcast]))


def ruins(rng):
    """Walls with openings, columns and rubble in the sun."""
    ground, level = _terrain(rng, 30, 0.6)
    materials = palette(rng, 4, kinds=("diffuse",), textured=0.8)
    instances = [Instance(ground, _earth(rng))]
    parts = [(meshes.box, (1, 0.3, 1), (4, 0.5, 3)), (meshes.cylinder, (0.4, 0.4, 1), (0.8, 0.8, 4))]
    for _ in range(rng.integers(4, 10)):
        x, y = rng.uniform(-5, 5, 2)
        part, low, high = pick(rng, parts)
        place = at((x, y, -0.3), rng.uniform(low, high), rng.uniform(0, 6), rng.normal(0, 0.05))
        instances.append(Instance(part(), pick(rng, materials), place))
    instances += scatter(rng, materials, 40, (-5, 5, -5, 5), (0.1, 0.8), -0.05, lambda r: meshes.blob(r, 12, sides=24))
    targets = [(*rng.uniform(-2, 2, 2), rng.uniform(0.2, 1.5)) for _ in range(3)]
    return Scene("ruins", instances, cameras(rng, instances, targets, (2, 8), (1, 3)),
                 environment=random_environment(rng, [sky, overcast, night]))


KINDS = [grass, forest, leaf_cluster, mountains, city, night_street, fence, ruins]
