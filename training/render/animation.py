"""Animations of the random scenes by Cycles: a moving camera, moving smaller objects, and optionally one change that
motion vectors do not show or that is hard to follow.

Cycles writes motion vectors only without motion blur. So either nothing moves while the shutter is open, or blurred
frames take their vectors from renders without blur.
"""

import dataclasses

import bpy
import numpy as np

from render import kinds
from render.cycles import OpenImageIO, Renderer, read_image

MOVING = 0.3  # share of the smaller objects
SMALL = 1.5  # maximum extent of a smaller object, meters
CHANGES = "lens", "cut", "rotation", "light", "dusk", "mirror", "blur"
LAMP_STEP = 0.12  # meters per frame, along each axis


class Animation(Renderer):
    """The scene `seed` for `frames` frames. Each file also has the passes `Vector` and `Depth`.

    `change` is one of CHANGES: a wide lens, a cut to another camera halfway, smaller objects that turn, lamps that move
    or that dim by 3 % per frame, a mirror in place of the largest object, or motion blur of half a frame.
    """

    def __init__(self, seed, frames, size, threads=1, change=None):
        if change not in (None, *CHANGES):
            raise SystemExit(f"no change \"{change}\": there are {', '.join(CHANGES)}")
        rng = np.random.default_rng(seed + 7)
        scene = kinds.random_scene(seed)
        if change == "mirror":
            polish_largest(scene)
        if change == "lens":
            widen_lens(scene)
        for instance in scene.instances:
            instance.motion = self._motion(rng, instance, frames)
        super().__init__(scene, size, threads)
        self.kind = scene.kind
        self.blurred = change == "blur"
        render = bpy.context.scene.render
        render.motion_blur_position, render.motion_blur_shutter = "CENTER", 0.5
        bpy.context.view_layer.use_pass_vector = bpy.context.view_layer.use_pass_z = True
        self._spread(frames)
        self.cut = frames // 2 if change == "cut" else frames
        for camera, source in zip(self.cameras, scene.cameras):
            self._move_camera(rng, camera, source, frames)
        if change == "rotation":
            self._turn(rng, scene.instances, frames)
        if change == "light":
            self._move_lamps(rng, frames)
        if change == "dusk":
            self._dim_lamps(frames)

    @staticmethod
    def _motion(rng, instance, frames):
        """The random displacement of an object from the first frame to the last; None if it stays."""
        extent = extent_of(instance)
        if extent < SMALL and instance.material.emission is None and rng.random() < MOVING:
            return (rng.normal(0, 0.05, 3) * extent * (frames - 1)).astype(np.float32)
        return None

    @staticmethod
    def _spread(frames):
        """Stretches the motion, which takes one frame in a still, over all frames."""
        for action in bpy.data.actions:
            curves = [c for layer in action.layers for strip in layer.strips for bag in strip.channelbags
                      for c in bag.fcurves]
            for curve in curves:
                curve.keyframe_points[1].co = (frames - 1, curve.keyframe_points[1].co[1])
                curve.update()

    @staticmethod
    def _move_camera(rng, camera, source, frames):
        """Moves the camera sideways and a little forward, by about one percent of the target's distance per frame.
        Blender's interpolation eases it in and out."""
        position = np.array(source.position)
        ahead = np.array(source.target) - position
        side = np.cross(ahead, (0, 0, 1))
        side *= np.linalg.norm(ahead) / np.linalg.norm(side)
        step = side * rng.uniform(0.006, 0.02) + ahead * rng.uniform(-0.01, 0.01)
        for frame in (-1, frames):
            camera.location = position + step * frame
            camera.keyframe_insert("location", frame=frame)

    @staticmethod
    def _turn(rng, instances, frames):
        """Rotates the smaller objects about their own axes, by up to 5 degrees per frame."""
        objects = [o for o in bpy.data.objects if o.parent and o.type == "MESH"]
        for obj, instance in zip(objects, instances, strict=True):
            if extent_of(instance) < SMALL:
                angle = np.radians(rng.uniform(-5, 5))
                for frame in (-1, frames):
                    obj.rotation_euler[2] = angle * frame
                    obj.keyframe_insert("rotation_euler", frame=frame)

    @staticmethod
    def _move_lamps(rng, frames):
        """Moves point lights by up to 20 cm per frame."""
        for lamp in (o for o in bpy.data.objects if o.type == "LIGHT"):
            start, step = np.array(lamp.location), rng.uniform(-LAMP_STEP, LAMP_STEP, 3)
            for frame in (-1, frames):
                lamp.location = start + step * frame
                lamp.keyframe_insert("location", frame=frame)

    @staticmethod
    def _dim_lamps(frames):
        """Dims point lights by 3 % of their initial power per frame."""
        for lamp in (o.data for o in bpy.data.objects if o.type == "LIGHT"):
            first = lamp.energy
            for frame in (0, frames):
                lamp.energy = first * (1 - 0.03 * frame)
                lamp.keyframe_insert("energy", frame=frame)

    def render_frame(self, frame, samples, seed, path):
        """Writes a frame, counted from 0, as EXR."""
        bpy.context.scene.frame_set(frame)
        camera = int(frame >= self.cut)
        sharp = path.with_suffix(".sharp") if self.blurred else path
        bpy.context.scene.render.use_motion_blur = False
        self.render(camera, 1 if self.blurred else samples, seed, keep=sharp)
        if self.blurred:
            bpy.context.scene.render.use_motion_blur = True
            self.render(camera, samples, seed, keep=path)
            copy_vectors(sharp, path)
            sharp.unlink()


def copy_vectors(source, path):
    """Replaces the passes `Vector` and `Depth` of the EXR file `path` with those of `source`."""
    (spec, pixels), (sharp_spec, sharp_pixels) = read_image(path), read_image(source)
    kept = [i for i, name in enumerate(spec.channelnames) if not is_vector(name)]
    added = [i for i, name in enumerate(sharp_spec.channelnames) if is_vector(name)]
    spec.channelnames = [spec.channelnames[i] for i in kept] + [sharp_spec.channelnames[i] for i in added]
    spec.nchannels = len(spec.channelnames)
    file = OpenImageIO.ImageOutput.create("exr")
    file.open(str(path), spec)
    file.write_image(np.ascontiguousarray(np.concatenate([pixels[..., kept], sharp_pixels[..., added]], -1)))
    file.close()


def is_vector(name):
    return ".Vector." in name or ".Depth." in name


def extent_of(instance):
    return np.ptp(instance.mesh.vertices @ instance.matrix[:3, :3].T, axis=0).max()


def polish_largest(scene):
    largest = max((i for i in scene.instances if i.material.emission is None), key=extent_of)
    largest.material = dataclasses.replace(largest.material, kind="metal", roughness=0.0, texture=None, color=(0.9,) * 3)


def widen_lens(scene):
    for camera in scene.cameras:
        camera.aperture = 0.02 * camera.focus
