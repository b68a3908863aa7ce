# SPDX-License-Identifier: MIT OR Apache-2.0
"""The render's passes: enabling them, getting them out of Blender, and bringing the result back in.

Python cannot read the passes of the Render Result, but Blender can save them all to an OpenEXR file. The result comes
back as an image with such a file packed into it, with every pass.
"""

import contextlib
from pathlib import Path

import bpy

# In the order to set them, as each one limits the values of the next. Blender before 5.0 has no `media_type`.
_FORMAT = {"media_type": "MULTI_LAYER_IMAGE", "file_format": "OPEN_EXR_MULTILAYER", "color_depth": "32",
           "exr_codec": "ZIP"}  # fmt: skip


_NONE = "There is no render yet: render the image first (F12)."


class Problem(Exception):
    """The reason why there is nothing to denoise, as one sentence for the user."""


class Rendering(Problem):
    """A render is running."""


def layers_without_passes(scene):
    """The view layers that could render Denoising Data but do not."""
    if scene.render.engine != "CYCLES":
        return []
    return [layer for layer in rendered_layers(scene) if not layer.cycles.denoising_store_passes]


def rendered_layers(scene):
    return [layer for layer in scene.view_layers if layer.use]


def save(scene, path):
    """Saves all passes of the last render, in 32-bit float."""
    if bpy.app.is_job_running("RENDER"):
        raise Rendering("A render is running: denoise it once it has ended.")
    result = bpy.data.images.get("Render Result")
    if result is None:
        raise Problem(_NONE)
    try:
        with _multilayer(scene.render.image_settings):
            result.save_render(str(path), scene=scene)
    except RuntimeError as error:
        if "any image data" in str(error):
            raise Problem(_NONE) from error
        raise Problem(f"The render could not be saved for denoising: {str(error).strip()}") from error


@contextlib.contextmanager
def _multilayer(settings):
    """Temporarily sets the scene's output to multilayer OpenEXR."""
    names = [name for name in [*_FORMAT, "color_mode"] if hasattr(settings, name)]
    before = {name: getattr(settings, name) for name in names}
    try:
        for name in names:
            if name in _FORMAT:
                setattr(settings, name, _FORMAT[name])
        yield
    finally:
        for name, value in before.items():
            # Values that the old format does not use may be rejected.
            with contextlib.suppress(TypeError):
                setattr(settings, name, value)


def colors(scene):
    """The passes to denoise, one per view layer. `None` leaves the choice to the denoiser."""
    layers = rendered_layers(scene)
    if len(layers) == 1:
        return [None]
    return [f"{layer.name}.{_color_pass(scene, layer)}" for layer in layers]


def _color_pass(scene, layer):
    """The layer's noisy pass. If Cycles also denoises, it keeps the noisy image beside the denoised one."""
    if scene.render.engine != "CYCLES":
        return "Combined"
    own = scene.cycles.use_denoising and layer.cycles.use_denoising
    return "Noisy Image" if own and layer.cycles.denoising_store_passes else "Combined"


def load(path, name):
    """Packs an OpenEXR file into the image of that name, creating it if necessary."""
    image = bpy.data.images.get(name) or bpy.data.images.new(name, 1, 1, float_buffer=True)
    data = Path(path).read_bytes()
    image.pack(data=data, data_len=len(data))
    image.source = "FILE"
    image.buffers_free()  # otherwise the pixels of an earlier run would stay
    return image


def show(image):
    """Shows the image in the editors that show the Render Result."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            space = area.spaces.active
            if area.type == "IMAGE_EDITOR" and space.image and space.image.type == "RENDER_RESULT":
                space.image = image
