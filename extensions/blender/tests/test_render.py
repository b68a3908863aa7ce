# SPDX-License-Identifier: MIT OR Apache-2.0
"""The last render: bit-identical to the command line, and one sentence if there is nothing to denoise."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import pytest
from conftest import MODULE, command_line, denoised_by_command_line, multilayer, preferences


def saved(part, scene, path):
    part("render").save(scene, path)
    return path


def test_a_render_gets_the_bits_of_the_command_line(part, scene, queue, tmp_path):
    bpy.ops.render.render()
    noisy = saved(part, scene, tmp_path / "noisy.exr")
    assert bpy.ops.wgdenoise.render() == {"FINISHED"}
    image = bpy.data.images["Scene denoised"]
    assert image.packed_file.data == denoised_by_command_line(noisy, tmp_path / "clean.exr")
    assert image.packed_file.data != noisy.read_bytes()
    first = part("settings").wgdenoise.devices()[0]
    assert queue.message.startswith(f"Denoised on {first.name}") and not queue.failed


def test_the_image_shows_the_last_of_several_renders(scene, tmp_path):
    multilayer(scene)
    scene.render.image_settings.color_depth = "32"
    for seed in (1, 2):
        scene.cycles.seed = seed
        bpy.ops.render.render()
        bpy.ops.wgdenoise.render()
        image = bpy.data.images["Scene denoised"]
        image.save_render(str(tmp_path / "shown.exr"), scene=scene)  # loads its pixels
    (tmp_path / "packed.exr").write_bytes(image.packed_file.data)
    measured = command_line("compare", "--json", tmp_path / "shown.exr", tmp_path / "packed.exr")
    assert json.loads(measured)["l1"] == 0


def test_the_result_survives_saving_and_opening(scene, tmp_path):
    bpy.ops.render.render()
    bpy.ops.wgdenoise.render()
    image = bpy.data.images["Scene denoised"]
    image.use_fake_user = True
    packed = image.packed_file.data
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert bpy.data.images["Scene denoised"].packed_file.data == packed


def test_the_output_settings_stay(part, scene, tmp_path):
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", "RGB", "16"
    bpy.ops.render.render()
    before = {name: getattr(settings, name) for name in settings.bl_rna.properties.keys()}
    saved(part, scene, tmp_path / "noisy.exr")
    assert {name: getattr(settings, name) for name in before} == before


def test_light_groups_are_denoised_if_asked_for(part, scene, tmp_path):
    layer = bpy.context.view_layer
    layer.lightgroups.add(name="key")
    bpy.data.objects["Light"].lightgroup = "key"
    bpy.ops.render.render()
    noisy = saved(part, scene, tmp_path / "noisy.exr")
    scene.wgdenoise.light_groups = True
    bpy.ops.wgdenoise.render()
    packed = bpy.data.images["Scene denoised"].packed_file.data
    assert packed == denoised_by_command_line(noisy, tmp_path / "all.exr", "--layers=auto")
    assert packed != denoised_by_command_line(noisy, tmp_path / "color.exr")


def test_alpha_is_kept_if_asked_for(part, scene, tmp_path):
    scene.render.film_transparent = True
    bpy.ops.render.render()
    noisy = saved(part, scene, tmp_path / "noisy.exr")
    scene.wgdenoise.alpha = "keep"
    bpy.ops.wgdenoise.render()
    packed = bpy.data.images["Scene denoised"].packed_file.data
    assert packed == denoised_by_command_line(noisy, tmp_path / "kept.exr", "--alpha=keep")
    assert packed != denoised_by_command_line(noisy, tmp_path / "denoised.exr")


@pytest.mark.parametrize(("own_denoiser", "color"), [(False, "Combined"), (True, "Noisy Image")])
def test_every_view_layer_is_denoised(part, scene, tmp_path, own_denoiser, color):
    scene.view_layers.new("Second").cycles.denoising_store_passes = True
    scene.view_layers.new("Unused").use = False
    scene.cycles.use_denoising = own_denoiser
    bpy.ops.render.render()
    clean = saved(part, scene, tmp_path / "clean.exr")
    bpy.ops.wgdenoise.render()
    for layer in ("ViewLayer", "Second"):
        command_line("--quality=fast", "--in-place", f"--color={layer}.{color}", clean)
    assert bpy.data.images["Scene denoised"].packed_file.data == clean.read_bytes()


def test_without_passes_the_panel_offers_them_and_says_so_afterwards(part, scene, queue):
    layer = bpy.context.view_layer
    layer.cycles.denoising_store_passes = False
    assert part("render").layers_without_passes(scene) == [layer]
    bpy.ops.render.render()
    bpy.ops.wgdenoise.render()
    assert queue.message.endswith("from color alone")
    bpy.ops.wgdenoise.enable_passes()
    assert layer.cycles.denoising_store_passes and part("render").layers_without_passes(scene) == []
    bpy.ops.render.render()
    bpy.ops.wgdenoise.render()
    assert "color alone" not in queue.message


def leftovers():
    return list(Path(tempfile.gettempdir()).glob("wgdenoise-*"))


def refused(operator, queue):
    """The error message of an operator that fails."""
    before = leftovers()
    with pytest.raises(RuntimeError) as caught:
        operator()
    assert queue.failed and queue.message in str(caught.value)
    assert leftovers() == before
    return queue.message


def test_no_render_is_one_sentence(scene, queue):
    assert refused(bpy.ops.wgdenoise.render, queue) == "There is no render yet: render the image first (F12)."


def test_a_device_that_is_not_there_is_one_sentence(scene, queue):
    bpy.ops.render.render()
    preferences().device = "Voodoo"
    assert "`Voodoo` matches none" in refused(bpy.ops.wgdenoise.render, queue)
    assert "Scene denoised" not in bpy.data.images


def test_no_adapter_is_one_sentence(scene, queue):
    code = f"""
import bpy
bpy.ops.preferences.addon_enable(module="{MODULE}")
bpy.context.scene.render.engine = "CYCLES"
bpy.context.scene.cycles.samples = 1
bpy.context.scene.render.resolution_percentage = 2
bpy.ops.render.render()
try:
    bpy.ops.wgdenoise.render()
except RuntimeError as error:
    print("REFUSED", error)
"""
    none = {name: "/none" for name in ("VK_ICD_FILENAMES", "VK_DRIVER_FILES")}
    run = [sys.executable, "-c", code]
    done = subprocess.run(run, capture_output=True, text=True, env={**os.environ, **none}, timeout=300)
    refusals = [line for line in done.stdout.splitlines() if line.startswith("REFUSED")]
    assert len(refusals) == 1 and "found no Vulkan, Metal or DX12 adapter" in refusals[0], done.stdout + done.stderr


def test_temporary_files_vanish(scene):
    before = leftovers()
    bpy.ops.render.render()
    bpy.ops.wgdenoise.render()
    assert leftovers() == before
