# SPDX-License-Identifier: MIT OR Apache-2.0
"""The panel in the render properties, and the entry in the image editor's menu."""

import textwrap

import bpy

from . import jobs, render, settings

_CHARACTER = 6.5  # width of an average character in pixels, at a scale of 1
_MARGIN = 50  # pixels of the panel's width that text cannot use: borders, icon


class WGDENOISE_PT_render(bpy.types.Panel):
    """The denoising panel, for every render engine."""

    bl_label = "wgdenoise"
    bl_idname = "WGDENOISE_PT_render"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"

    def draw(self, context):
        layout, scene = self.layout, context.scene
        layout.use_property_split = True
        layout.use_property_decorate = False
        draw_job(layout, characters(context))
        draw_passes(layout, scene)
        column = layout.column()
        for name in ("quality", "alpha", "light_groups", "automatic"):
            column.prop(scene.wgdenoise, name)
        column.prop(settings.preferences(), "device", placeholder="Automatic")
        draw_frames(layout, scene)


def characters(context):
    """The number of characters that fit on a line."""
    if context.region is None:
        return 40
    width = context.region.width / context.preferences.system.ui_scale
    return max(10, int((width - _MARGIN) / _CHARACTER))


def draw_job(layout, width):
    """Draws the button or the progress, and the outcome of the last job in lines of at most `width` characters."""
    queue = jobs.QUEUE
    if queue.job is not None:
        row = layout.row()
        row.progress(factor=queue.job.fraction, text=_progress_text(queue))
        row.operator("wgdenoise.cancel", text="", icon="CANCEL")
        layout.label(text=queue.job.device or "Opening the device…")
    else:
        layout.operator("wgdenoise.render", icon="RENDER_RESULT")
    if queue.message:
        box = layout.column(align=True)
        box.alert = queue.failed
        lines = textwrap.wrap(queue.message, width)
        for number, line in enumerate(lines):
            box.label(text=line, icon=("ERROR" if queue.failed else "INFO") if number == 0 else "BLANK1")


def _progress_text(queue):
    if queue.job.canceled:
        return "Stopping…"
    more = f", {len(queue.waiting)} waiting" if queue.waiting else ""
    return f"Denoising: {queue.job.fraction:.0%}{more}"


def draw_passes(layout, scene):
    """Draws what is missing for a sharp result."""
    if scene.render.engine != "CYCLES":
        layout.label(text="Only Cycles has Denoising Data: color alone", icon="INFO")
    elif render.layers_without_passes(scene):
        layout.operator("wgdenoise.enable_passes", icon="RENDERLAYERS")


def draw_frames(layout, scene):
    """Draws the settings for rendered frames on disk."""
    column = layout.column(heading="Frames")
    column.prop(scene.wgdenoise, "files")
    column.prop(scene.wgdenoise, "folder")
    column.operator("wgdenoise.folder", icon="FILE_FOLDER")


def draw_menu(self, _context):
    self.layout.separator()
    self.layout.operator("wgdenoise.render", icon="RENDER_RESULT")


def register():
    bpy.utils.register_class(WGDENOISE_PT_render)
    bpy.types.IMAGE_MT_image.append(draw_menu)


def unregister():
    bpy.types.IMAGE_MT_image.remove(draw_menu)
    bpy.utils.unregister_class(WGDENOISE_PT_render)
