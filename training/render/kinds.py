"""Random scenes for training; `random_scene(seed)` is the same scene for every renderer.

The kinds (kinds_indoor.py, kinds_outdoor.py, kinds_studio.py) differ in their sources of noise and of detail.
"""

import dataclasses

import numpy as np

from . import kinds_indoor, kinds_outdoor, kinds_studio, meshes
from .textures import random_heights

KINDS = {kind.__name__: kind for kind in kinds_indoor.KINDS + kinds_outdoor.KINDS + kinds_studio.KINDS}


def random_scene(seed, kind=None):
    """A scene of a random or the given kind, determined by the seed alone."""
    rng = np.random.default_rng(seed)
    name = list(KINDS)[rng.integers(len(KINDS))]
    scene = KINDS[kind or name](rng)
    scene.cameras = scene.cameras[:rng.integers(2, 4)]
    if rng.random() < 0.25:
        _lens(rng, scene)
    if rng.random() < 0.15:
        _motion(rng, scene)
    _exposure(scene, 10 ** rng.uniform(-1, 2))  # brighter ones overflow the half floats of stored views
    if rng.random() < 0.8:
        _bumps(rng, scene)
    return scene


def _lens(rng, scene):
    """Adds depth of field, with a lens radius of up to a few percent of the focus distance."""
    for camera in scene.cameras:
        camera.focus *= rng.uniform(0.6, 1.3)
        camera.aperture = camera.focus * 10 ** rng.uniform(-2.8, -1.8)


def _motion(rng, scene):
    """Moves some of the smaller objects while the shutter is open."""
    for instance in scene.instances:
        extent = np.ptp(instance.mesh.vertices @ instance.matrix[:3, :3].T, axis=0).max()
        if extent < 1.5 and instance.material.emission is None and rng.random() < 0.4:
            instance.motion = (rng.normal(0, 0.15, 3) * extent).astype(np.float32)


def _bumps(rng, scene):
    """Gives most materials with uvs a bump map with a slope of 0.1 to 1."""
    changed = {}
    for instance in scene.instances:
        m = instance.material
        if m.emission is not None or instance.mesh.uvs is None:
            continue
        if id(m) not in changed:
            slope = 10 ** rng.uniform(-1, 0)
            changed[id(m)] = (m, _bumpy(rng, instance, slope) if rng.random() < 0.6 else m)
        instance.material = changed[id(m)][1]


def _bumpy(rng, instance, slope):
    """The instance's material with a bump map of this root mean square slope on the instance."""
    heights = random_heights(rng)
    steepness = len(heights) * np.sqrt(2 * np.square(np.gradient(heights)).mean())  # per uv
    metres = slope * meshes.uv_size(instance.mesh, instance.matrix) / max(steepness, 1e-3)
    return dataclasses.replace(instance.material, bump=(heights * metres).astype(np.float32))


def _exposure(scene, factor):
    """Multiplies all light in the scene by `factor`."""
    scaled = {}
    for instance in scene.instances:
        m = instance.material
        if m.emission is not None:
            bright = dataclasses.replace(m, emission=tuple(np.array(m.emission) * factor))
            instance.material = scaled.setdefault(id(m), bright)
    for light in scene.lights:
        light.power = tuple(np.array(light.power) * factor)
    if scene.environment is not None:
        scene.environment = (scene.environment * factor).astype(np.float32)
