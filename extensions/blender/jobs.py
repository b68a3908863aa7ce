# SPDX-License-Identifier: MIT OR Apache-2.0
"""Denoising jobs and their queue. Blender's main thread polls the queue."""

import collections
import tempfile
from pathlib import Path

import bpy

from . import render, settings
from .work import Call, Job

_POLL = 0.1  # seconds


def of_render(scene):
    """The job that denoises the last render into an image in Blender."""
    folder = tempfile.TemporaryDirectory(prefix="wgdenoise-")
    path, name = Path(folder.name, "render.exr"), f"{scene.name} denoised"
    try:
        render.save(scene, path)
    except BaseException:
        folder.cleanup()
        raise
    options = {**settings.options(scene), "in_place": True}
    calls = [Call([path], path, {**options, "color": color}) for color in render.colors(scene)]
    return Job(calls, lambda: render.show(render.load(path, name)), folder)


def of_folder(scene):
    """The job that denoises the scene's folder of frames."""
    given = scene.wgdenoise.folder
    if not given:
        raise render.Problem("No folder is set: choose a folder of rendered frames.")
    if given.startswith("//") and not bpy.data.filepath:
        raise render.Problem(f"{given} is relative to the Blender file, which has not been saved yet: save it first.")
    folder = Path(bpy.path.abspath(given))
    frames = sorted(path for path in folder.glob("*") if path.suffix.lower() == ".exr")
    if not frames:
        raise render.Problem(f"{folder} has no OpenEXR files: render frames as OpenEXR MultiLayer into it.")
    return of_files(scene, frames)


def of_files(scene, paths):
    """The job that denoises files from one folder."""
    options = settings.options(scene)
    if scene.wgdenoise.files == "replace":
        return Job([Call([path], path, {**options, "in_place": True}) for path in paths])
    target = paths[0].parent / "denoised"
    return Job([Call(paths, f"{target}/", {**options, "parents": True, "force": True})])


class Queue:
    """Runs one job at a time and keeps the outcome of the last one."""

    def __init__(self):
        self.waiting = collections.deque()  # functions that make a job; any thread may append
        self.job = None
        self.message, self.failed = "", False

    @property
    def busy(self):
        return self.job is not None or bool(self.waiting)

    def add(self, make):
        """Adds a job, created by `make`. In background mode nobody polls, so it runs at once."""
        if bpy.app.background:
            self._make(make, self.run)
        else:
            self.waiting.append(make)

    def poll(self):
        """Starts waiting jobs and finishes ended ones. A timer calls this in the main thread."""
        if self.job is not None and not self.job.is_alive():
            self.finish(self.job)
        if self.job is None and self.waiting:
            self._make(self.waiting.popleft(), self.start)
        if self.busy:
            redraw()
        return _POLL

    def _make(self, make, begin):
        try:
            job = make()
        except render.Rendering:
            self.waiting.appendleft(make)
        except Exception as problem:  # a timer that raises would be the last one
            self.fail(str(problem))
        else:
            begin(job)

    def start(self, job):
        """Starts a job; `poll` finishes it."""
        self.job, self.message, self.failed = job, "", False
        job.start()

    def run(self, job):
        """Runs a job to its end."""
        self.job, self.message, self.failed = job, "", False
        job.run()
        self.finish(job)

    def finish(self, job):
        """Delivers the result of an ended job and removes its temporary files."""
        self.job = None
        try:
            if not job.error and not job.canceled and job.deliver:
                job.deliver()
        except Exception as error:  # a timer that raises would be the last one
            job.error = f"The result could not be shown: {error}"
        finally:
            if job.folder:
                job.folder.cleanup()
        job.done = True
        self._conclude(job)

    def _conclude(self, job):
        if job.error:
            self.fail(job.error)
            return
        self.failed = False
        note = ", from color alone" if job.color_alone else ""
        self.message = "Canceled" if job.canceled else f"Denoised on {job.device}{note}"
        redraw()

    def fail(self, sentence):
        self.message, self.failed = sentence, True
        redraw()

    def cancel(self):
        """Stops the current job and drops the waiting ones."""
        self.waiting.clear()
        if self.job is not None:
            self.job.cancel()

    def close(self):
        """Cancels, then waits until the thread has ended."""
        self.cancel()
        if self.job is not None:
            self.job.join()
            self.finish(self.job)


QUEUE = Queue()


def redraw():
    """Redraws the properties editors, which show the panel."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()
