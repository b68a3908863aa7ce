# SPDX-License-Identifier: MIT OR Apache-2.0
"""The settings: per scene how to denoise, per machine on which device."""

import bpy
import wgdenoise
from bpy.props import BoolProperty, EnumProperty, PointerProperty, StringProperty


# Blender 5 accepts paths relative to the .blend file only for properties that declare it.
_SAYS_SO = "is_path_supports_blend_relative" in bpy.types.Property.bl_rna.properties
_RELATIVE = {"PATH_SUPPORTS_BLEND_RELATIVE"} if _SAYS_SO else set()


class WGDENOISE_PG_settings(bpy.types.PropertyGroup):
    """The scene's denoising settings."""

    quality: EnumProperty(
        name="Quality",
        description="Each step takes about twice as long as the one before",
        items=[
            ("fast", "Fast", "For previews"),
            ("balanced", "Balanced", "For most renders"),
            ("high", "High", "The least error"),
        ],
        default="balanced",
    )
    alpha: EnumProperty(
        name="Alpha",
        description="What happens to the alpha channel",
        items=[
            ("auto", "Automatic", "Denoise alpha if it is fractional anywhere"),
            ("denoise", "Denoise", "Denoise alpha"),
            ("keep", "Keep", "Leave alpha as it is"),
        ],
        default="auto",
    )
    light_groups: BoolProperty(
        name="Light Groups",
        description="Also denoise light groups and light passes, so that they still add up to the image",
    )
    automatic: BoolProperty(
        name="After Each Render",
        description="Denoise every render as it finishes, and every frame of an animation as it is written",
    )
    files: EnumProperty(
        name="Files",
        description="Where denoised frames go",
        items=[
            ("beside", "Folder Beside", "Into the folder `denoised` beside the frames, under their own names"),
            ("replace", "Same File", "Into the frames themselves: the noisy image is replaced, all other passes stay"),
        ],
        default="beside",
    )
    folder: StringProperty(
        name="Folder",
        description="A folder of OpenEXR files, best with the Denoising Data passes",
        subtype="DIR_PATH",
        options={"ANIMATABLE"} | _RELATIVE,
    )


def _device_names(_self, _context, _text):
    return [device.name for device in wgdenoise.devices()]


class WGDENOISE_AP_preferences(bpy.types.AddonPreferences):
    """The settings of the machine."""

    bl_idname = __package__

    device: StringProperty(
        name="Device",
        description="A part of the device's name. Empty for the fastest kind",
        search=_device_names,
    )

    def draw(self, _context):
        self.layout.prop(self, "device", placeholder="Automatic")


def preferences():
    return bpy.context.preferences.addons[__package__].preferences


def options(scene):
    """The scene's settings as options of `wgdenoise.denoise_exr`."""
    chosen = scene.wgdenoise
    return {
        "quality": chosen.quality,
        "alpha": None if chosen.alpha == "auto" else chosen.alpha,
        "layers": "auto" if chosen.light_groups else None,
        "adapter": preferences().device or None,
    }


def register():
    bpy.utils.register_class(WGDENOISE_PG_settings)
    bpy.utils.register_class(WGDENOISE_AP_preferences)
    bpy.types.Scene.wgdenoise = PointerProperty(type=WGDENOISE_PG_settings)


def unregister():
    del bpy.types.Scene.wgdenoise
    bpy.utils.unregister_class(WGDENOISE_AP_preferences)
    bpy.utils.unregister_class(WGDENOISE_PG_settings)
