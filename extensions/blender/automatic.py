# SPDX-License-Identifier: MIT OR Apache-2.0
"""Denoises automatically after a render and after each frame. Blender calls the handlers in the render's thread."""

import os
import time
from pathlib import Path

import bpy
from bpy.app.handlers import persistent

from . import jobs, render


class _Render:
    """The current render."""

    began = 0.0
    wrote = False


@persistent
def begin(_scene, _=None):
    _Render.began, _Render.wrote = time.time(), False


@persistent
def written(scene, _=None):
    """Denoises the file that the render has just written."""
    if not scene.wgdenoise.automatic:
        return
    _Render.wrote = True
    path = written_file(scene, _Render.began)
    jobs.QUEUE.add(lambda: _of_file(scene.name, path))


@persistent
def complete(scene, _=None):
    """Denoises the render unless it was written to files."""
    if scene.wgdenoise.automatic and not _Render.wrote:
        name = scene.name
        jobs.QUEUE.add(lambda: jobs.of_render(bpy.data.scenes[name]))


@persistent
def forget(*_):
    """Cancels the queue when another Blender file opens, because results then have no destination."""
    jobs.QUEUE.cancel()


def written_file(scene, since):
    """The current frame's file if it was written after the time `since`, else `None`.

    An animation's file names contain the frame, a still image's does not; Blender does not tell which one it renders.
    """
    output = scene.render
    still = bpy.path.abspath(output.filepath)
    if output.use_file_extension and not still.endswith(output.file_extension):
        still += output.file_extension
    found = [path for path in (output.frame_path(frame=scene.frame_current), still) if os.path.isfile(path)]
    # File systems with a resolution of a second may round down.
    fresh = [path for path in found if os.path.getmtime(path) >= since - 1]
    return Path(max(fresh, key=os.path.getmtime)) if fresh else None


def _of_file(scene_name, path):
    if path is None or path.suffix.lower() != ".exr":
        raise render.Problem("Only frames in OpenEXR files are denoised: set the output to OpenEXR MultiLayer.")
    return jobs.of_files(bpy.data.scenes[scene_name], [path])


def poll():
    return jobs.QUEUE.poll()


_HANDLERS = {"render_init": begin, "render_write": written, "render_complete": complete, "load_pre": forget}


def register():
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)
    # Persistent, to outlive the Blender file.
    bpy.app.timers.register(poll, persistent=True)


def unregister():
    bpy.app.timers.unregister(poll)
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
    jobs.QUEUE.close()
