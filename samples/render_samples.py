#!/usr/bin/env python3
"""Renders this folder's still life with Blender's Cycles, as sample and test input for the denoiser.

  pip install bpy==5.0.1                       Blender as a Python module; needs Python 3.11
  python render_samples.py                     still_life_8spp.exr and still_life_reference.exr, next to this file
  python render_samples.py --only noisy        one of the two ("noisy" or "reference")
  python render_samples.py --small FOLDER      the small renders for crates/cli/tests/data/make_test_files.py
"""
import argparse
import os
import time

import bpy

import still_life

SIZE = (576, 432)
NOISY_SAMPLES, REFERENCE_SAMPLES = 8, 350
NOISY_SEED, REFERENCE_SEED = 1, 2  # different seeds: the reference must not share the noise


def set_up(size, samples, seed):
    """Sets up plain Monte Carlo: Cycles on the CPU without clamping, denoising or adaptive sampling."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size
    cycles = scene.cycles
    cycles.samples, cycles.seed, cycles.use_adaptive_sampling, cycles.use_denoising = samples, seed, False, False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy, cycles.max_bounces = 1.0, 8
    cycles.caustics_reflective = False  # their fireflies would survive in a reference of a few minutes
    cycles.use_light_tree = False  # with three lights, plain light sampling is as good and faster


def store_passes(depth):
    """Enables the passes that a denoiser reads, and some that it must leave untouched."""
    layer = bpy.context.view_layer
    layer.cycles.denoising_store_passes = True
    layer.use_pass_z = depth
    layer.use_pass_object_index = layer.use_pass_cryptomatte_object = True
    layer.pass_cryptomatte_depth = 2


def render(path, multilayer, **image_settings):
    settings = bpy.context.scene.render.image_settings
    settings.media_type = "MULTI_LAYER_IMAGE" if multilayer else "IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER" if multilayer else "OPEN_EXR"
    settings.color_depth, settings.exr_codec = "16", "ZIP"
    for key, value in image_settings.items():
        setattr(settings, key, value)
    bpy.context.scene.render.filepath = os.path.abspath(path)
    start = time.time()
    bpy.ops.render.render(write_still=True)
    print(f"{path}: {time.time() - start:.0f} s, {os.path.getsize(path)} bytes")


def render_noisy(folder):
    set_up(SIZE, NOISY_SAMPLES, NOISY_SEED)
    store_passes(depth=False)  # "Denoising Depth" is stored anyway
    render(os.path.join(folder, "still_life_8spp.exr"), multilayer=True)


def render_reference(folder):
    set_up(SIZE, REFERENCE_SAMPLES, REFERENCE_SEED)
    render(os.path.join(folder, "still_life_reference.exr"), multilayer=False, color_mode="RGB")


def render_small(folder):
    """Small renders in both of Blender's layouts: one part per pass, and all passes in one part."""
    bpy.data.objects["sky"].visible_camera = False
    bpy.context.scene.render.film_transparent = True  # so that alpha is 0 in the window
    set_up((48, 36), NOISY_SAMPLES, NOISY_SEED)
    store_passes(depth=True)
    bpy.context.scene.cycles.use_denoising = True  # adds the pass "Noisy Image"; "Combined" is then denoised
    render(os.path.join(folder, "blender5_parts.exr"), multilayer=True)
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 40, 30
    render(os.path.join(folder, "blender_interleaved.exr"), multilayer=True, use_exr_interleave=True, color_depth="32")


def render_light_groups(folder):
    """A small render whose three light groups add up to the picture, in 32-bit floats so that they do so closely."""
    groups = {"key": ["Area"], "lamp": ["Point", "globe"], "sky": ["sky"]}
    for group, names in groups.items():
        bpy.ops.scene.view_layer_add_lightgroup(name=group)
        for name in names:
            bpy.data.objects[name].lightgroup = group
    set_up((64, 48), NOISY_SAMPLES, NOISY_SEED)
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_object_index = layer.use_pass_cryptomatte_object = False
    render(os.path.join(folder, "light_groups.exr"), multilayer=True, use_exr_interleave=True, color_depth="32")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=("noisy", "reference"))
    parser.add_argument("--small", metavar="FOLDER")
    options = parser.parse_args()
    here = os.path.dirname(os.path.abspath(__file__))
    still_life.build()
    if options.small:
        render_small(options.small)
        return render_light_groups(options.small)
    if options.only != "reference":
        render_noisy(here)
    if options.only != "noisy":
        render_reference(here)


if __name__ == "__main__":
    main()
