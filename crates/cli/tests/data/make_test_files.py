#!/usr/bin/env python3
"""Writes this folder's EXR files, one for each pass layout that renderers use.

  pip install bpy==5.0.1 OpenEXR numpy
  python ../../samples/render_samples.py --small FOLDER
  python make_test_files.py FOLDER

All pixels come from the small Blender renders in FOLDER; blender5_parts.exr and light_groups.exr are two of them,
unchanged.
"""
import os
import shutil
import sys

import numpy as np
import OpenEXR

HERE = os.path.dirname(os.path.abspath(__file__))
LAYER = "ViewLayer"


def layer_channels(file, layer, letters):
    """The channels `ViewLayer.<layer>.<letter>` of a render, from any part, as arrays by letter."""
    found = {name: channel.pixels for part in file.parts for name, channel in part.channels.items()}
    return {letter: found[f"{LAYER}.{layer}.{letter}"] for letter in letters}


def header(compression, **attributes):
    return {"compression": compression, "type": OpenEXR.scanlineimage, **attributes}


def write(name, parts):
    """Writes (header, channels) pairs as the parts of one file in this folder."""
    OpenEXR.File([OpenEXR.Part(head, channels) for head, channels in parts]).write(os.path.join(HERE, name))


def as_type(channels, dtype, prefix=""):
    return {prefix + letter: np.ascontiguousarray(pixels, dtype) for letter, pixels in channels.items()}


def blender4_single_part(single):
    """Blender's interleaved layout, with the one pass name that Blender 5 changed reset to 4.x."""
    part = single.parts[0]
    channels = {name.replace("Object Index", "IndexOB"): c.pixels for name, c in part.channels.items()}
    kept = {k: v for k, v in part.header.items() if isinstance(v, str) and k != "name"}
    write("blender4_single_part.exr", [(header(OpenEXR.ZIP_COMPRESSION, **kept), channels)])


def mitsuba_like(single):
    channels = {**as_type(layer_channels(single, "Noisy Image", "RGB"), np.float32),
                **as_type(layer_channels(single, "Denoising Albedo", "RGB"), np.float32, "albedo."),
                **as_type(layer_channels(single, "Denoising Normal", "XYZ"), np.float32, "sh_normal.")}
    write("mitsuba_like.exr", [(header(OpenEXR.ZIP_COMPRESSION), channels)])


def karma_like(single):
    normal = dict(zip("RGB", layer_channels(single, "Denoising Normal", "XYZ").values()))
    passes = (("C", layer_channels(single, "Noisy Image", "RGB"), np.float16),
              ("albedo", layer_channels(single, "Denoising Albedo", "RGB"), np.float16), ("N", normal, np.float32))
    write("karma_like.exr", [(header(OpenEXR.ZIP_COMPRESSION, name=name), as_type(channels, dtype))
                             for name, channels, dtype in passes])


def plain_rgb(parts):
    """37 x 23 pixels in 16 x 16 tiles; the data window lies inside the display window."""
    color = {k: v[8:31, 4:41] for k, v in layer_channels(parts, "Noisy Image", "RGB").items()}
    tiles = OpenEXR.TileDescription()
    tiles.xSize = tiles.ySize = 16
    tiles.mode, tiles.roundingMode = OpenEXR.ONE_LEVEL, OpenEXR.ROUND_DOWN
    head = header(OpenEXR.PIZ_COMPRESSION, tiles=tiles, dataWindow=((5, 3), (41, 25)), displayWindow=((0, 0), (63, 47)))
    write("plain_rgb.exr", [(head | {"type": OpenEXR.tiledimage}, as_type(color, np.float16))])


def rgba_zips(parts):
    """Writes a file with custom attributes and the chromaticities of Rec. 2020."""
    rec2020 = (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290)
    head = header(OpenEXR.ZIPS_COMPRESSION, chromaticities=rec2020, shot="still life 010", exposureBias=-0.5)
    write("rgba_zips.exr", [(head, as_type(layer_channels(parts, "Noisy Image", "RGBA"), np.float16))])


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    parts_path = os.path.join(sys.argv[1], "blender5_parts.exr")
    shutil.copyfile(parts_path, os.path.join(HERE, "blender5_parts.exr"))
    shutil.copyfile(os.path.join(sys.argv[1], "light_groups.exr"), os.path.join(HERE, "light_groups.exr"))
    parts = OpenEXR.File(parts_path, separate_channels=True)
    single = OpenEXR.File(os.path.join(sys.argv[1], "blender_interleaved.exr"), separate_channels=True)
    for make in (blender4_single_part, mitsuba_like, karma_like):
        make(single)
    for make in (plain_rgb, rgba_zips):
        make(parts)


if __name__ == "__main__":
    main()
