# SPDX-License-Identifier: MIT OR Apache-2.0
"""The operators behind the buttons. From the interface, denoising runs in the background; scripts wait for it."""

import bpy

from . import jobs, render

_STEP = 0.1  # seconds between checks of the job


class _Denoising:
    """An operator that runs a job: Esc cancels it, the status bar shows its progress."""

    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, _context):
        return not jobs.QUEUE.busy

    def execute(self, context):
        """Runs the job and returns when everything is denoised, for scripts."""
        try:
            job = self.make(context.scene)
        except render.Problem as problem:
            return self.refuse(problem)
        jobs.QUEUE.run(job)
        return self.conclude(job)

    def invoke(self, context, _event):
        if bpy.app.background:
            return self.execute(context)
        try:
            self.job = self.make(context.scene)
        except render.Problem as problem:
            return self.refuse(problem)
        jobs.QUEUE.start(self.job)
        manager = context.window_manager
        self.timer = manager.event_timer_add(_STEP, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS":
            jobs.QUEUE.cancel()
            return {"RUNNING_MODAL"}
        if not self.job.done:
            context.workspace.status_text_set(f"Denoising: {self.job.fraction:.0%}    Esc: Cancel")
            return {"PASS_THROUGH"}
        context.workspace.status_text_set(None)
        context.window_manager.event_timer_remove(self.timer)
        return self.conclude(self.job)

    def refuse(self, problem):
        jobs.QUEUE.fail(str(problem))
        self.report({"ERROR"}, str(problem))
        return {"CANCELLED"}

    def conclude(self, job):
        if job.error:
            self.report({"ERROR"}, job.error)
        else:
            self.report({"INFO"}, jobs.QUEUE.message)
        return {"CANCELLED"} if job.error or job.canceled else {"FINISHED"}


class WGDENOISE_OT_render(_Denoising, bpy.types.Operator):
    """Denoise the last render into a new image that has all of its passes"""

    bl_idname = "wgdenoise.render"
    bl_label = "Denoise Render"

    def make(self, scene):
        return jobs.of_render(scene)


class WGDENOISE_OT_folder(_Denoising, bpy.types.Operator):
    """Denoise all OpenEXR files of a folder"""

    bl_idname = "wgdenoise.folder"
    bl_label = "Denoise Folder"

    def make(self, scene):
        return jobs.of_folder(scene)


class WGDENOISE_OT_cancel(bpy.types.Operator):
    """Stop denoising after the current tile"""

    bl_idname = "wgdenoise.cancel"
    bl_label = "Cancel"

    def execute(self, _context):
        jobs.QUEUE.cancel()
        return {"FINISHED"}


class WGDENOISE_OT_enable_passes(bpy.types.Operator):
    """Render albedo and normals along with the image; they make denoising much sharper"""

    bl_idname = "wgdenoise.enable_passes"
    bl_label = "Enable Denoising Data"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        for layer in render.layers_without_passes(context.scene):
            layer.cycles.denoising_store_passes = True
        return {"FINISHED"}


_CLASSES = WGDENOISE_OT_render, WGDENOISE_OT_folder, WGDENOISE_OT_cancel, WGDENOISE_OT_enable_passes


def register():
    for each in _CLASSES:
        bpy.utils.register_class(each)


def unregister():
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
