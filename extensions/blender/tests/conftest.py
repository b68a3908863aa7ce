# SPDX-License-Identifier: MIT OR Apache-2.0
"""Shared by the tests: the installed extension, and small renders.

WGDENOISE_EXTENSION names the package to test. Blender installs it into a folder that lasts for the session.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

_RESOURCES = tempfile.TemporaryDirectory(prefix="blender-user-")
os.environ["BLENDER_USER_RESOURCES"] = _RESOURCES.name  # before bpy is imported

import bpy

REPOSITORY = Path(__file__).parents[3]
PACKAGE = Path(os.environ["WGDENOISE_EXTENSION"]).resolve()
MODULE = "bl_ext.user_default.wgdenoise"


@pytest.fixture(scope="session")
def installed():
    """Installs and enables the extension as "Install from Disk" does."""
    bpy.ops.preferences.addon_enable(module="bl_pkg")
    bpy.ops.extensions.package_install_files(filepath=str(PACKAGE), repo="user_default", enable_on_install=True)
    assert MODULE in bpy.context.preferences.addons
    return MODULE


@pytest.fixture
def part(installed, scene):
    """A function that returns the extension's module of a given name."""
    return lambda name: sys.modules[f"{MODULE}.{name}"]


@pytest.fixture
def queue(part):
    return part("jobs").QUEUE


@pytest.fixture
def scene(installed, tmp_path):
    """Blender's default scene, set up for fast renders into `tmp_path`, with nothing rendered."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=False)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 8, False
    scene.render.resolution_x, scene.render.resolution_y = 96, 64
    scene.render.resolution_percentage = 100
    scene.render.filepath = str(tmp_path / "frame_")
    scene.wgdenoise.quality = "fast"
    bpy.context.view_layer.cycles.denoising_store_passes = True
    preferences().device = ""
    yield scene
    queue = sys.modules[f"{MODULE}.jobs"].QUEUE
    queue.close()
    queue.message, queue.failed = "", False


def preferences():
    return bpy.context.preferences.addons[MODULE].preferences


def multilayer(scene):
    """Sets the output to OpenEXR MultiLayer."""
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"


def command_line(*words):
    """The output of the program in the package's wheel, run in a process without Blender."""
    import wgdenoise

    environment = {**os.environ, "PYTHONPATH": str(Path(wgdenoise.__file__).parents[1])}
    run = [sys.executable, "-m", "wgdenoise", *map(str, words)]
    done = subprocess.run(run, capture_output=True, text=True, timeout=600, env=environment)
    assert done.returncode == 0, done.stderr
    return done.stdout


def denoised_by_command_line(source, target, *flags):
    """The bytes that the program writes for a file."""
    command_line("--quality=fast", *flags, source, target)
    return target.read_bytes()
