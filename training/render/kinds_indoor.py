"""Random rooms, lit mostly by indirect light."""

import numpy as np

from . import meshes
from .placing import at, glow, lamp, material, matte, palette, panel, pick, room, scatter, stack, table, wall
from .scene import Instance, Material, Scene
from .textures import overcast, picture, random_environment, random_texture, sky, text
from .viewpoints import cameras


def _size(rng, low=3.0, high=7.0):
    return rng.uniform(low, high), rng.uniform(low, high), rng.uniform(2.3, 3.5)


def _inside(rng, instances, w, d, h):
    """Cameras within a room, aimed between its floor and half its height."""
    targets = rng.uniform((-w / 4, -d / 4, 0.2), (w / 4, d / 4, h / 2), (4, 3))
    bounds = -w / 2 + 0.2, w / 2 - 0.2, -d / 2 + 0.2, d / 2 - 0.2, 0.15, h - 0.15
    return cameras(rng, instances, targets, (0.7, max(w, d)), (0.4, h * 0.75), bounds=bounds)


def _furniture(rng, materials, w, d, n):
    """Tables, piles of boxes, cupboards and scattered objects."""
    area = -w / 2 + 0.4, w / 2 - 0.4, -d / 2 + 0.4, d / 2 - 0.4
    instances = scatter(rng, materials, n, area, (0.15, 0.9))
    for _ in range(rng.integers(1, 4)):
        x, y = rng.uniform(area[0], area[1]), rng.uniform(area[2], area[3])
        if rng.random() < 0.5:
            instances += stack(rng, materials, rng.integers(2, 6), (x, y, 0), rng.uniform(0.3, 0.8))
        else:
            instances.append(table(rng, pick(rng, materials), 1.2, 0.7, 0.75, (x, y)))
            around = x - 0.5, x + 0.5, y - 0.25, y + 0.25
            instances += scatter(rng, materials, rng.integers(2, 9), around, (0.05, 0.25), 0.75)
    return instances


def window_room(rng):
    """Daylight through one or two windows."""
    w, d, h = _size(rng)
    instances = room(rng, w, d, h, rng.integers(1, 3)) + _furniture(rng, palette(rng, 5), w, d, rng.integers(3, 12))
    return Scene("window_room", instances, _inside(rng, instances, w, d, h),
                 environment=random_environment(rng, [sky, sky, overcast], rng.uniform(1, 4)))


def small_window(rng):
    """Very little light, all from a small pane in a wall."""
    w, d, h = _size(rng, 2.5, 5)
    instances = room(rng, w, d, h) + _furniture(rng, palette(rng, 5), w, d, rng.integers(2, 10))
    pane = rng.uniform(-w / 3, w / 3), d / 2 - 0.01, rng.uniform(0.6, h - 0.6)
    instances.append(panel(rng, pane, rng.uniform(0.05, 0.6), rng.uniform(0.05, 0.6), 20, tilt=-np.pi / 2))
    return Scene("small_window", instances, _inside(rng, instances, w, d, h))


def blinds(rng):
    """Stripes of sunlight through the slats of a blind."""
    w, d, h = _size(rng, 3, 6)
    instances = room(rng, w, d, h, 4, textured=0.1) + _furniture(rng, palette(rng, 4), w, d, rng.integers(2, 8))
    slat, turn = meshes.plane(w, rng.uniform(0.04, 0.12)), rng.uniform(0.3, 1.2)
    slats = [meshes.moved(slat, at((0, y, z), tilt=turn)) for z in np.arange(0.05, h, 0.12) for y in (-d / 2, d / 2)]
    instances.append(Instance(meshes.merge(slats), matte(rng, 0)))
    return Scene("blinds", instances, _inside(rng, instances, w, d, h), environment=random_environment(rng, [sky], 3))


def ceiling_light(rng):
    """A closed room under area lights."""
    w, d, h = _size(rng)
    instances = room(rng, w, d, h) + _furniture(rng, palette(rng, 6), w, d, rng.integers(4, 16))
    for _ in range(rng.integers(1, 4)):
        place = rng.uniform(-w / 3, w / 3), rng.uniform(-d / 3, d / 3), h - 0.02
        instances.append(panel(rng, place, *rng.uniform(0.1, 1.2, 2), rng.uniform(5, 30)))
    return Scene("ceiling_light", instances, _inside(rng, instances, w, d, h))


def lampshades(rng):
    """Lamps in opaque or translucent shades: light goes up and down, and reaches the rest indirectly."""
    w, d, h = _size(rng, 2.5, 5)
    instances = room(rng, w, d, h) + _furniture(rng, palette(rng, 6), w, d, rng.integers(3, 12))
    shade, lights = pick(rng, [Material("thin_leaf", (0.8, 0.7, 0.5)), matte(rng, 0)]), []
    open_cone = meshes.lathe([(0.22, 0), (rng.uniform(0.1, 0.2), 0.3)])
    for _ in range(rng.integers(1, 4)):
        x, y, z = rng.uniform(-w / 3, w / 3), rng.uniform(-d / 3, d / 3), rng.uniform(0.8, h - 0.4)
        instances.append(Instance(open_cone, shade, at((x, y, z))))
        lights.append(lamp(rng, (x, y, z + 0.12), rng.uniform(3, 15), 0.04))
    return Scene("lampshades", instances, _inside(rng, instances, w, d, h), lights)


def hidden_light(rng):
    """Lamps behind screens and above a false ceiling."""
    w, d, h = _size(rng)
    instances = room(rng, w, d, h) + _furniture(rng, palette(rng, 5), w, d, rng.integers(3, 10))
    for side in (-1, 1):
        light = panel(rng, (side * (w / 2 - 0.1), 0, h - 0.15), 0.1, d * 0.8, rng.uniform(10, 60), tilt=np.pi)
        cover = Instance(meshes.box(), matte(rng, 0), at((side * (w / 2 - 0.15), 0, h - 0.3), (0.3, d, 0.08)))
        instances += [light, cover] if side == 1 or rng.random() < 0.5 else []
    screen = at((rng.uniform(-w / 4, w / 4), 0, 0), (0.06, d * 0.5, h * 0.6), rng.uniform(0, 3))
    instances.append(Instance(meshes.box(), matte(rng), screen))
    return Scene("hidden_light", instances, _inside(rng, instances, w, d, h))


def door_ajar(rng):
    """A dark room next to a bright one, joined by a narrow gap."""
    w, d, h = _size(rng, 2.5, 4)
    instances = room(rng, 2 * w, d, h) + _furniture(rng, palette(rng, 6), 2 * w, d, rng.integers(6, 18))
    gap = rng.uniform(0.05, 0.8)
    y = rng.uniform(-d / 2 + 0.1, d / 2 - gap - 0.1)
    instances.append(Instance(wall(d, h, (y, y + gap, 0.001, h * 0.8)), matte(rng), at(turn=np.pi / 2)))
    instances.append(panel(rng, (w / 2, 0, h - 0.02), w * 0.5, d * 0.4, rng.uniform(10, 40)))
    targets = [(-w / 2, 0, 0.5), (0, y, 1.0), (-w / 3, d / 4, 0.3)]
    bounds = -w + 0.2, -0.2, -d / 2 + 0.2, d / 2 - 0.2, 0.2, h - 0.2
    return Scene("door_ajar", instances, cameras(rng, instances, targets, (1, w), (0.5, h * 0.7), bounds=bounds))


def dark_room(rng):
    """Only small colored emitters: LEDs, candles, a screen."""
    w, d, h = _size(rng, 2.5, 5)
    instances = room(rng, w, d, h) + _furniture(rng, palette(rng, 6), w, d, rng.integers(5, 15))
    lights = [lamp(rng, rng.uniform((-w / 2.2, -d / 2.2, 0.1), (w / 2.2, d / 2.2, h - 0.1)), rng.uniform(0.1, 2),
                   rng.uniform(0.005, 0.05)) for _ in range(rng.integers(1, 8))]
    if rng.random() < 0.4:
        instances.append(panel(rng, (0, d / 2 - 0.05, 1.2), 0.9, 0.5, 3, tilt=-np.pi / 2))
    return Scene("dark_room", instances, _inside(rng, instances, w, d, h), lights)


def corridor(rng):
    """A long corridor with lamps at intervals and doors at the sides; sometimes misty."""
    w, d, h = rng.uniform(1.2, 2.5), rng.uniform(8, 20), rng.uniform(2.2, 3.2)
    instances, door, light = room(rng, w, d, h), matte(rng), glow(rng, rng.uniform(3, 20))
    for y in np.arange(-d / 2 + 1, d / 2, rng.uniform(1.5, 4)):
        side = rng.choice([-1, 1])
        instances.append(Instance(meshes.box(), door, at((side * w / 2, y, 0), (rng.uniform(0.05, 0.3), 0.9, 2))))
        if rng.random() < 0.6:
            instances.append(Instance(meshes.plane(0.2, 0.8), light, at((0, y, h - 0.02), tilt=np.pi)))
    instances.append(Instance(meshes.plane(0.3, 0.3), light, at((0, -d / 4, h - 0.02), tilt=np.pi)))
    instances += scatter(rng, palette(rng, 4), rng.integers(2, 10), (-w / 2.5, w / 2.5, -d / 2, d / 2), (0.1, 0.5))
    targets = [(0, -d / 4, 1), (0, d / 4, 1), (w / 3, 0, 1)]
    bounds = -w / 2 + 0.2, w / 2 - 0.2, -d / 2 + 0.2, d / 2 - 0.2, 0.2, h - 0.2
    views = cameras(rng, instances, targets, (2, d / 2), (0.5, 2), bounds=bounds)
    return Scene("corridor", instances, views, fog=pick(rng, [0, 0, 0, rng.uniform(0.02, 0.15)]))


def misty_hall(rng):
    """Columns in fog, lit by openings or lamps."""
    w, d, h = rng.uniform(6, 12), rng.uniform(6, 12), rng.uniform(4, 7)
    instances, column = room(rng, w, d, h, 1), material(rng, ("diffuse", "plastic"))
    for x in np.linspace(-w / 3, w / 3, rng.integers(2, 5)):
        instances += [Instance(meshes.cylinder(), column, at((x, y, 0), (0.5, 0.5, h))) for y in (-d / 4, d / 4)]
    lights = [lamp(rng, rng.uniform((-w / 3, -1, 1), (w / 3, 1, h - 1)), 30, 0.06) for _ in range(2)]
    instances += scatter(rng, palette(rng, 4), 6, (-w / 3, w / 3, -d / 3, d / 3), (0.3, 1))
    return Scene("misty_hall", instances, _inside(rng, instances, w, d, h), lights,
                 random_environment(rng, [overcast], 3), fog=10 ** rng.uniform(-1.8, -0.7))


def shelves(rng):
    """A wall of shelves full of books and small objects."""
    w, h, levels = rng.uniform(1.5, 3), 2.4, rng.integers(3, 7)
    instances, materials, board = room(rng, 4, 4, h), palette(rng, 9), material(rng, ("diffuse", "plastic"))
    for z in np.linspace(0.05, 2.0, levels):
        instances.append(Instance(meshes.box(), board, at((0, 1.75, z - 0.03), (w, 0.4, 0.03))))
        x = -w / 2
        while x < w / 2 - 0.1 and rng.random() < 0.97:
            scale = rng.uniform((0.015, 0.15, 0.12), (0.07, 0.28, 0.27))
            instances.append(Instance(meshes.box(), pick(rng, materials), at((x + scale[0] / 2, 1.75, z), scale)))
            x += scale[0] + (0.002 if rng.random() < 0.9 else 0.15)
    instances.append(panel(rng, (rng.uniform(-1, 1), rng.uniform(-1, 1), h - 0.05), *rng.uniform(0.05, 1, 2), 15))
    targets = [(rng.uniform(-w / 3, w / 3), 1.6, rng.uniform(0.3, 1.8)) for _ in range(3)]
    bounds = -1.8, 1.8, -1.8, 1.2, 0.2, 2.2
    return Scene("shelves", instances, cameras(rng, instances, targets, (0.5, 3), (0.4, 1.9), bounds=bounds))


def gallery(rng):
    """Pictures and text on the walls, a glossy floor and spotlights."""
    w, d, h = _size(rng, 4, 8)
    instances, lights = room(rng, w, d, h, textured=0.2), []
    for x in np.arange(-w / 2 + 0.8, w / 2 - 0.5, 1.4):
        paper = Material(pick(rng, ["diffuse", "plastic"]), texture=random_texture(rng, [picture, text]))
        frame = meshes.moved(meshes.plane(), at((x, d / 2 - 0.03, 1.4), rng.uniform(0.5, 1.2), tilt=np.pi / 2))
        instances.append(Instance(frame, paper))
        lights.append(lamp(rng, (x, d / 2 - 0.8, h - 0.2), rng.uniform(2, 8), rng.uniform(0.01, 0.1)))
    instances += scatter(rng, palette(rng, 4), rng.integers(1, 6), (-w / 3, w / 3, -d / 3, d / 3), (0.3, 1.2))
    targets = [(rng.uniform(-w / 3, w / 3), d / 2 - 0.1, rng.uniform(0.8, 1.6)) for _ in range(3)]
    bounds = -w / 2 + 0.2, w / 2 - 0.2, -d / 2 + 0.2, d / 2 - 0.5, 0.3, h - 0.2
    return Scene("gallery", instances, cameras(rng, instances, targets, (0.8, d), (0.6, 2), bounds=bounds), lights)


def stairs(rng):
    """A flight of stairs with a railing of thin bars."""
    instances, steps = room(rng, 5, 6, 4), rng.integers(6, 14)
    step, rail = material(rng, ("diffuse", "plastic")), material(rng, ("metal", "plastic"), 0)
    for i in range(steps):
        x, y, z = 0, -2 + i * 0.3, i * 0.18
        instances.append(Instance(meshes.box(), step, at((x, y, z), (1.6, 0.32, 0.18))))
        instances += [Instance(meshes.cylinder(8), rail, at((s, y, z), (0.025, 0.025, 1.1))) for s in (-0.75, 0.75)]
    slope = np.linspace((0, -2, 1.1), (0, -2 + steps * 0.3, 1.1 + steps * 0.18), 3)
    rails = [meshes.tube(slope + (s, 0, 0), 0.03) for s in (-0.75, 0.75)]
    instances.append(Instance(meshes.merge(rails), rail))
    place = rng.uniform((-2, -2, 3.5), (2, 2, 3.9))
    instances.append(panel(rng, place, *rng.uniform(0.2, 1.5, 2), rng.uniform(5, 25)))
    targets = [(0, -1, 0.8), (0, 0, 1.4), (0, 0.5, 1)]
    bounds = -2.3, 2.3, -2.8, 2.8, 0.3, 3.7
    return Scene("stairs", instances, cameras(rng, instances, targets, (1.5, 4), (0.5, 3), bounds=bounds))


def curtains(rng):
    """A room divided by hanging, translucent cloth."""
    w, d, h = _size(rng, 3, 6)
    instances = room(rng, w, d, h) + _furniture(rng, palette(rng, 5), w, d, rng.integers(3, 10))
    x = np.linspace(-w / 2, w / 2 * rng.uniform(0, 1), 160)
    folds = rng.uniform(0.03, 0.12) * np.sin(x * rng.uniform(10, 40) + np.sin(3 * x)) + d * rng.uniform(-0.2, 0.3)
    cloth = meshes.sheet(np.stack([np.stack([x, folds, np.full(160, z)], -1) for z in (0.03, h / 2, h - 0.05)]))
    instances.append(Instance(cloth, Material("thin_leaf", tuple(rng.uniform(0.3, 0.9, 3)))))
    place = rng.uniform(-w / 4, w / 4), d / 2 - 0.02, h / 2
    instances.append(panel(rng, place, w * 0.3, h * 0.4, 15, tilt=-np.pi / 2))
    return Scene("curtains", instances, _inside(rng, instances, w, d, h))


def pipes(rng):
    """A machine room: pipes with right-angled bends along three axes, gratings, bare lamps."""
    w, d, h = _size(rng, 3, 6)
    instances, metals = room(rng, w, d, h), palette(rng, 5, kinds=("metal", "metal", "plastic", "diffuse"), textured=0.1)
    for _ in range(rng.integers(8, 30)):
        axes, steps = rng.integers(0, 3, 7), rng.choice([-1, 1], (7, 1)) * rng.uniform(0.3, 1.5, (7, 1))
        corners = rng.uniform((-w / 3, -d / 3, 0.2), (w / 3, d / 3, h - 0.2)) + np.cumsum(steps * np.eye(3)[axes], 0)
        corners = np.clip(corners, (-w / 2, -d / 2, 0.05), (w / 2, d / 2, h - 0.05))
        path = np.concatenate([np.linspace(a, b, 12) for a, b in zip(corners[:-1], corners[1:]) if (a != b).any()])
        instances.append(Instance(meshes.tube(path, rng.uniform(0.01, 0.09), 12), pick(rng, metals)))
    bars = [meshes.moved(meshes.box(), at((x, 0, 0.5), (0.01, d, 0.03))) for x in np.arange(-w / 2, w / 2, 0.08)]
    instances.append(Instance(meshes.merge(bars), pick(rng, metals)))
    places = rng.uniform((-w / 3, -d / 3, 1), (w / 3, d / 3, h - 0.1), (2, 3))
    lights = [lamp(rng, place, rng.uniform(2, 15), 0.05) for place in places]
    return Scene("pipes", instances, _inside(rng, instances, w, d, h), lights)


KINDS = [window_room, small_window, blinds, ceiling_light, lampshades, hidden_light, door_ajar, dark_room, corridor,
         misty_hall, shelves, gallery, stairs, curtains, pipes]
