"""Animations of the random scenes by Cycles: a moving camera, and smaller objects that move.

Nothing moves while the shutter is open, since Cycles has motion vectors only without motion blur.
"""

import bpy
import numpy as np

from render import kinds
from render.cycles import Renderer

MOVING = 0.3  # share of the smaller objects


class Animation(Renderer):
    """The scene `seed` for `frames` frames. Each file also has the passes `Vector` and `Depth`."""

    def __init__(self, seed, frames, size, threads=1):
        rng = np.random.default_rng(seed + 7)
        scene = kinds.random_scene(seed)
        for instance in scene.instances:
            instance.motion = self._motion(rng, instance, frames)
        super().__init__(scene, size, threads)
        self.kind = scene.kind
        bpy.context.scene.render.use_motion_blur = False
        bpy.context.view_layer.use_pass_vector = bpy.context.view_layer.use_pass_z = True
        self._spread(frames)
        self._move_camera(rng, scene.cameras[0], frames)

    @staticmethod
    def _motion(rng, instance, frames):
        """The way of an object from the first frame to the last."""
        extent = np.ptp(instance.mesh.vertices @ instance.matrix[:3, :3].T, axis=0).max()
        if extent < 1.5 and instance.material.emission is None and rng.random() < MOVING:
            return (rng.normal(0, 0.05, 3) * extent * (frames - 1)).astype(np.float32)
        return None

    @staticmethod
    def _spread(frames):
        """Spreads the motion, which lasts one frame in a still, over all frames."""
        for action in bpy.data.actions:
            curves = [c for layer in action.layers for strip in layer.strips for bag in strip.channelbags
                      for c in bag.fcurves]
            for curve in curves:
                curve.keyframe_points[1].co = (frames - 1, curve.keyframe_points[1].co[1])
                curve.update()

    def _move_camera(self, rng, camera, frames):
        """Moves the camera sideways and a little forward, by about a percent of the target's distance a frame."""
        position = np.array(camera.position)
        ahead = np.array(camera.target) - position
        side = np.cross(ahead, (0, 0, 1))
        side *= np.linalg.norm(ahead) / np.linalg.norm(side)
        step = side * rng.uniform(0.006, 0.02) + ahead * rng.uniform(-0.01, 0.01)
        for frame in (-1, frames):
            self.cameras[0].location = position + step * frame
            self.cameras[0].keyframe_insert("location", frame=frame)

    def render_frame(self, frame, samples, seed, path):
        """Writes the frame, counted from 0, as EXR."""
        bpy.context.scene.frame_set(frame)
        self.render(0, samples, seed, keep=path)
