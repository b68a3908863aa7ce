# SPDX-License-Identifier: MIT OR Apache-2.0
"""wgdenoise in Blender: denoises the render, a folder of frames, or every render as it finishes."""

from . import automatic, operators, panel, settings

_PARTS = settings, operators, panel, automatic


def register():
    for part in _PARTS:
        part.register()


def unregister():
    for part in reversed(_PARTS):
        part.unregister()
