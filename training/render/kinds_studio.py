"""Random close-range arrangements: clutter, fur, wires, glass, metal, lights and smooth gradients."""

import numpy as np

from . import meshes
from .placing import at, glow, knot, lamp, material, matte, palette, panel, pick, scatter, solid, stack, table
from .scene import Instance, Material, Scene
from .textures import bricks, checker, dots, interior, marble, noise, overcast, picture, random_environment
from .textures import random_texture, sky, stripes, studio, text, wood
from .viewpoints import cameras


def _backdrop(rng, textured=0.3, size=6.0):
    """A floor that curves up into a wall behind the objects."""
    a = np.linspace(0, np.pi / 2, 12)
    profile = [(-size, 0)] + [(size / 2 + np.sin(t), 1 - np.cos(t)) for t in a] + [(size / 2 + 1, size)]
    strip = np.array([[(x, y, z) for x in (size, -size)] for y, z in profile])
    return Instance(meshes.sheet(strip), matte(rng, textured))


def _lights(rng):
    """A random mix of overhead softboxes, lamps and an environment; returns instances, lights, environment."""
    instances, lights, environment = [], [], None
    for _ in range(rng.integers(0, 3)):
        place = rng.uniform((-2, -2, 1.5), (2, 1, 3))
        instances.append(panel(rng, place, *rng.uniform(0.1, 1.5, 2), rng.uniform(3, 20), rng.uniform(-0.6, 0.6)))
    if rng.random() < 0.5:
        place = rng.uniform((-1.5, -2, 0.8), (1.5, 1, 2.5))
        lights.append(lamp(rng, place, rng.uniform(3, 15), 10 ** rng.uniform(-2, -0.7)))
    if rng.random() < 0.5 or not (instances or lights):
        environment = random_environment(rng)
    return instances, lights, environment


def _scene(rng, kind, instances, targets, distance, height, light=None):
    """The scene under the given or a random light (see _lights)."""
    panels, lights, environment = light or _lights(rng)
    instances = instances + panels
    return Scene(kind, instances, cameras(rng, instances, targets, distance, height), lights, environment)


def tabletop(rng):
    """Many small objects on a table."""
    top = table(rng, material(rng, ("diffuse", "plastic", "plastic"), 0.6), 1.4, 0.9, 0.75)
    things = scatter(rng, palette(rng, 8), rng.integers(10, 45), (-0.6, 0.6, -0.35, 0.35), (0.02, 0.22), 0.75)
    targets = [(*rng.uniform(-0.3, 0.3, 2), 0.8) for _ in range(3)]
    return _scene(rng, "tabletop", [_backdrop(rng), top] + things, targets, (0.35, 1.3), (0.85, 1.6))


def heap(rng):
    """Solids of all materials on the floor."""
    things = scatter(rng, palette(rng, 8), rng.integers(8, 40), (-1.2, 1.2, -1.2, 1.2), (0.1, 0.7))
    things += stack(rng, palette(rng, 4), rng.integers(0, 7), (0, 0, 0), 0.5)
    targets = [(0, 0, 0.2), (0.4, 0.3, 0.3), (-0.5, -0.2, 0.2)]
    return _scene(rng, "heap", [_backdrop(rng)] + things, targets, (1, 4), (0.3, 2))


def product(rng):
    """One object under softboxes: smooth gradients and glossy highlights."""
    thing = Instance(solid(rng), material(rng, textured=0.2), at(scale=rng.uniform(0.7, 1.2, 3), turn=rng.uniform(0, 6)))
    light = [panel(rng, (0, 0, 3), 2, 2, 4)], [], random_environment(rng, [studio], rng.uniform(0.1, 1))
    return _scene(rng, "product", [_backdrop(rng, 0.1), thing], [(0, 0, 0.5)], (1, 2.2), (0.3, 1.6), light)


def gradients(rng):
    """Plain glossy and matt balls without texture: soft shadows and reflections."""
    materials = palette(rng, 6, kinds=("diffuse", "plastic", "metal"), textured=0)
    make = lambda r: pick(r, [meshes.sphere(64), meshes.rounded(0.3), meshes.torus()])
    things = scatter(rng, materials, rng.integers(3, 14), (-1, 1, -1, 1), (0.2, 0.8), make=make)
    targets = [(0, 0, 0.3), (0.4, 0, 0.2)]
    return _scene(rng, "gradients", [_backdrop(rng, 0)] + things, targets, (1, 3), (0.3, 1.8))


def fur(rng):
    """Balls and pebbles with thousands of hairs."""
    instances = [_backdrop(rng)]
    for i in range(rng.integers(1, 4)):
        place = at((0.9 * i - 0.9, rng.uniform(-0.4, 0.4), 0), rng.uniform(0.5, 0.9))
        body = meshes.moved(meshes.blob(rng, rng.integers(2, 6)), place)
        roots, normals = meshes.surface_points(rng, body, rng.integers(3000, 9000))
        length, width, droop = rng.uniform((0.03, 0.002, 0), (0.25, 0.01, 1.5))
        hair = meshes.strands(rng, roots, normals, length, width, droop)
        coat = material(rng, ("diffuse", "plastic"), 0.2)
        instances += [Instance(body, coat), Instance(hair, coat)]
    return _scene(rng, "fur", instances, [(-0.9, 0, 0.3), (-0.5, 0, 0.4), (-0.9, 0, 0.5)], (0.8, 2), (0.3, 1.3))


def wires(rng):
    """Bent wires, cages and grids, in places finer than a pixel."""
    instances, metals = [_backdrop(rng)], palette(rng, 4, kinds=("metal", "plastic", "diffuse"), textured=0)
    for _ in range(rng.integers(3, 9)):
        walk = np.cumsum(rng.normal(0, 0.12, (40, 3)), 0) * (1, 1, 0.4) + (0, 0, 0.5)
        instances.append(Instance(meshes.tube(walk, 10 ** rng.uniform(-2.8, -1.7)), pick(rng, metals)))
    gap, turn = rng.uniform(0.02, 0.1), rng.uniform(0, 3)
    bars = [meshes.tube([(x, 0, 0), (x, 0, 0.5), (x, 0, 1)], gap * 0.1, 6) for x in np.arange(-0.5, 0.5, gap)]
    bars += [meshes.moved(bar, _quarter()) for bar in bars]
    for i in range(2):
        place = at(rng.uniform((-0.6, -0.6, 0), (0.6, 0.6, 0.1)), turn=turn + i)
        instances.append(Instance(meshes.merge(bars), pick(rng, metals), place))
    return _scene(rng, "wires", instances, [(0, 0, 0.5), (0.2, 0, 0.4), (-0.2, 0, 0.3)], (0.9, 2.5), (0.3, 1.5))


def _quarter():
    """Turns the xz plane by 90 degrees about its point (0, 0.5)."""
    return np.array([[0, 0, 1, -0.5], [0, 1, 0, 0], [-1, 0, 0, 0.5], [0, 0, 0, 1]])


def caustics(rng):
    """Glass and polished metal under small bright lamps: bright spots and rare, very bright samples."""
    materials = palette(rng, 3, kinds=("glass",)) + palette(rng, 2, kinds=("metal",)) + palette(rng, 1)
    things = scatter(rng, materials, rng.integers(3, 14), (-0.7, 0.7, -0.7, 0.7), (0.15, 0.6))
    lights = [lamp(rng, rng.uniform((-1.5, -1.5, 0.8), (1.5, 1, 2)), rng.uniform(2, 12), 10 ** rng.uniform(-2, -1))
              for _ in range(rng.integers(1, 4))]
    light = [], lights, random_environment(rng, mean=rng.uniform(0.02, 0.3))
    targets = [(0, 0, 0.15), (0.2, 0.2, 0.1)]
    return _scene(rng, "caustics", [_backdrop(rng)] + things, targets, (0.7, 2), (0.3, 1.5), light)


def glass_still(rng):
    """Glass vessels on a table in a bright room."""
    top = table(rng, material(rng, ("diffuse", "plastic"), 0.7), 1.2, 0.9, 0.75)
    make = lambda r: pick(r, [meshes.vase(r, 0.02), meshes.vase(r), meshes.sphere(48), meshes.torus()])
    glasses, area = palette(rng, 4, kinds=("glass",)), (-0.4, 0.4, -0.3, 0.3)
    things = scatter(rng, glasses, rng.integers(3, 12), area, (0.08, 0.3), 0.75, make)
    things += scatter(rng, palette(rng, 4), rng.integers(0, 6), (-0.5, 0.5, -0.35, 0.35), (0.04, 0.15), 0.75)
    light = [], [], random_environment(rng, [interior, studio, overcast])
    targets = [(0, 0, 0.85), (0.2, 0.1, 0.85)]
    return _scene(rng, "glass_still", [_backdrop(rng), top] + things, targets, (0.4, 1.1), (0.85, 1.4), light)


def neon(rng):
    """Glowing shapes in the dark."""
    things = scatter(rng, palette(rng, 5), rng.integers(4, 14), (-1, 1, -1, 1), (0.15, 0.6))
    for _ in range(rng.integers(2, 7)):
        place = at(rng.uniform((-1, -1, 0.1), (1, 1, 1)), rng.uniform(0.1, 0.6), rng.uniform(0, 6), rng.uniform(0, 3))
        things.append(Instance(pick(rng, [solid, knot, knot])(rng), glow(rng, 10 ** rng.uniform(-0.3, 1.3)), place))
    targets = [(0, 0, 0.3), (0.3, 0.3, 0.5)]
    return _scene(rng, "neon", [_backdrop(rng)] + things, targets, (1.2, 3.5), (0.4, 2), ([], [], None))


def patterns(rng):
    """High-frequency textures on boards, boxes and the ground at all angles."""
    fine = [checker, stripes, bricks, dots, text]
    materials = [Material(kind, roughness=float(rng.uniform(0.05, 0.5)), texture=random_texture(rng, fine))
                 for kind in ("diffuse", "plastic") * 3]
    ground = meshes.plane(12, 12)
    ground.uvs = ground.uvs * rng.uniform(0.5, 3)
    things = scatter(rng, materials, rng.integers(4, 16), (-1.5, 1.5, -1.5, 1.5), (0.2, 1))
    for _ in range(rng.integers(1, 5)):
        board = at(rng.uniform((-1.5, -1.5, 0.3), (1.5, 1.5, 1)), rng.uniform(0.4, 1), *rng.uniform(0, 6, 2))
        things.append(Instance(meshes.plane(), pick(rng, materials), board))
    instances = [Instance(ground, pick(rng, materials))] + things
    return _scene(rng, "patterns", instances, [(0, 0, 0.3), (0.5, 0, 0.4)], (1, 4), (0.3, 2.5))


def mirrors(rng):
    """Mirrors and glossy boards that reflect the objects."""
    things = scatter(rng, palette(rng, 6), rng.integers(5, 18), (-1, 1, -1, 1), (0.15, 0.6))
    for i in range(rng.integers(1, 4)):
        shiny = Material("metal", tuple(rng.uniform(0.7, 0.95, 3)), float(rng.choice([0, 0.05, 0.2, 0.35])))
        angle = rng.uniform(0, 6.3)
        place = at((1.8 * np.cos(angle), 1.8 * np.sin(angle), 0), (1.8, 0.03, 1.6), angle + np.pi / 2)
        things.append(Instance(meshes.box(), shiny, place))
    return _scene(rng, "mirrors", [_backdrop(rng)] + things, [(0, 0, 0.3), (0.3, 0.3, 0.3)], (1, 2.5), (0.4, 1.6))


def debris(rng):
    """Hundreds of small objects in the air, near and far."""
    materials = palette(rng, 7)
    shapes = [meshes.sphere(16), meshes.box(), meshes.cone(0, 12), meshes.cylinder(12), meshes.blob(rng, 5, sides=16)]
    things = []
    for _ in range(rng.integers(60, 300)):
        place = at(rng.uniform((-1.5, -1.5, 0.1), (1.5, 1.5, 2)), 10 ** rng.uniform(-1.8, -0.7), *rng.uniform(0, 6, 2))
        things.append(Instance(pick(rng, shapes), pick(rng, materials), place))
    return _scene(rng, "debris", [_backdrop(rng)] + things, [(0, 0, 0.8), (0.4, 0, 0.6)], (1, 3.5), (0.4, 2))


def maze(rng):
    """Boards with slots and gaps, and lamps between them: layers of shadows."""
    materials, boards = [matte(rng, 0.2) for _ in range(4)], []
    for _ in range(rng.integers(8, 22)):
        size = rng.uniform((0.3, 0.02, 0.2), (1.2, 0.06, 1))
        board = at((*rng.uniform(-1.5, 1.5, 2), 0), size, rng.uniform(0, 3))
        boards.append(Instance(meshes.box(), pick(rng, materials), board))
    lights = [lamp(rng, rng.uniform((-1, -1, 0.3), (1, 1, 1.2)), rng.uniform(0.5, 5), 10 ** rng.uniform(-2, -0.8))
              for _ in range(rng.integers(2, 5))]
    targets = [(0, 0, 0.2), (0.5, 0.5, 0.2), (-0.5, 0, 0.2)]
    return _scene(rng, "maze", [_backdrop(rng)] + boards, targets, (1.2, 3.5), (0.8, 2.5), ([], lights, None))


def pool(rng):
    """Waves on water over a tiled or stony bottom."""
    waves = meshes.heightfield((noise(rng, 128, rng.uniform(1.8, 2.6), 4) - 0.5) * 10 ** rng.uniform(-1.6, -0.8), 6)
    bottom = Material("diffuse", texture=random_texture(rng, [bricks, checker, marble]))
    water = Material("glass", (0.9, 0.97, 0.97), 0.0, 1.33)
    instances = [Instance(meshes.plane(8, 8), bottom), Instance(waves, water, at((0, 0, rng.uniform(0.2, 0.6))))]
    instances += scatter(rng, palette(rng, 5), rng.integers(3, 12), (-1.5, 1.5, -1.5, 1.5), (0.2, 0.9))
    light = [], [lamp(rng, (1, 1, 2.5), rng.uniform(0, 20), 0.1)], random_environment(rng, [sky, overcast, studio])
    return _scene(rng, "pool", instances, [(0, 0, 0.3), (0.4, 0, 0.2), (-0.5, 0.3, 0.2)], (1.2, 3.5), (0.8, 2), light)


def macro(rng):
    """Small objects at very close range, most of them out of focus."""
    ground = Instance(meshes.plane(), Material("plastic", texture=random_texture(rng, [wood, marble, text, picture])))
    things = scatter(rng, palette(rng, 7), rng.integers(15, 50), (-0.2, 0.2, -0.2, 0.2), (0.005, 0.06))
    scene = _scene(rng, "macro", [ground] + things, rng.uniform((-0.1, -0.1, 0.01), (0.1, 0.1, 0.02), (3, 3)),
                   (0.08, 0.3), (0.04, 0.2))
    for camera in scene.cameras:
        camera.aperture = camera.focus * 10 ** rng.uniform(-2.3, -1.4)
    return scene


KINDS = [tabletop, heap, product, gradients, fur, wires, caustics, glass_still, neon, patterns, mirrors, debris, maze,
         pool, macro]
