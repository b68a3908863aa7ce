#!/usr/bin/env python3
# SPDX-License-Identifier: MIT OR Apache-2.0
"""Compares wgdenoise with Blender's own denoiser, Open Image Denoise, on random scenes of training/render.

    python extensions/blender/benches/compare.py --out target/blender-bench      # bpy 5.0 and wgdenoise installed

Blender renders each scene with its denoiser on (its defaults: high quality, albedo and normals prefiltered accurately)
and keeps the noisy image beside the result; wgdenoise denoises that noisy image of the same file. Blender's time is what
the denoiser adds to the render, wgdenoise's is the whole call from file to file. References are rendered once, with
another seed. Prints a table in Markdown.
"""

import argparse
import statistics
import sys
import time
from pathlib import Path

REPOSITORY = Path(__file__).parents[3]
sys.path.append(str(REPOSITORY / "training"))

import bpy  # noqa: E402
import wgdenoise  # noqa: E402
from render import cycles, kinds  # noqa: E402

SIZE = 480, 270
SCENES = 90003, 90004, 90005, 90007  # no network has been trained on these
SAMPLES = 8, 64
REFERENCE = 1024
SEED, REFERENCE_SEED = 1, 2
ROUNDS = 3
TIERS = "fast", "balanced", "high"


def timed(function, *arguments):
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


def median_of_rounds(function, *arguments):
    return statistics.median(timed(function, *arguments) for _ in range(ROUNDS))


def render(renderer, samples, seed, path, denoise):
    """Renders one view into a multilayer file."""
    scene = bpy.context.scene
    scene.cycles.use_denoising = denoise
    scene.cycles.denoiser = "OPENIMAGEDENOISE"
    scene.camera = renderer.cameras[0]
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.render.filepath = str(path.resolve())
    bpy.ops.render.render(write_still=True)


def channels(path):
    """The color that a file shows, height × width × 3."""
    file = cycles.OpenImageIO.ImageInput.open(str(path))
    names = list(file.spec().channelnames)
    pixels = file.read_image("float")
    file.close()
    combined = [next(i for i, name in enumerate(names) if name.endswith(f"Combined.{axis}")) for axis in "RGB"]
    return pixels[..., combined]


def measure(renderer, samples, folder, reference):
    """Rows of (method, seconds or `None`, metrics) for one scene."""
    plain, own = folder / f"noisy_{samples}.exr", folder / f"oidn_{samples}.exr"
    render(renderer, 1, SEED, plain, True)  # warm: kernels and denoiser are loaded
    without = median_of_rounds(render, renderer, samples, SEED, plain, False)
    with_it = median_of_rounds(render, renderer, samples, SEED, own, True)
    rows = [("noisy", None, plain), ("Blender's OIDN", with_it - without, own)]
    for tier in TIERS:
        clean = folder / f"{tier}_{samples}.exr"
        seconds = median_of_rounds(lambda: wgdenoise.denoise_exr(own, clean, quality=tier, force=True))
        rows.append((f"wgdenoise {tier}", seconds, clean))
    expected = channels(reference)
    return [(name, seconds, wgdenoise.compare(channels(path), expected)) for name, seconds, path in rows]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="folder for the renders; references in it are reused")
    parser.add_argument("--references-only", action="store_true")
    o = parser.parse_args()
    print("| scene | samples | | L1 | PSNR | SSIM | seconds |\n|---|---:|---|---:|---:|---:|---:|")
    for number in SCENES:
        scene = kinds.random_scene(number)
        folder = o.out / str(number)
        folder.mkdir(parents=True, exist_ok=True)
        renderer = cycles.Renderer(scene, SIZE, threads=2)
        reference = folder / "reference.exr"
        if not reference.exists():
            render(renderer, REFERENCE, REFERENCE_SEED, reference, False)
        for samples in () if o.references_only else SAMPLES:
            for name, seconds, error in measure(renderer, samples, folder, reference):
                shown = "" if seconds is None else f"{seconds:.2f}"
                print(f"| {scene.kind} | {samples} | {name} | {error.l1:.4f} | {error.psnr:.1f} | {error.ssim:.3f} "
                      f"| {shown} |", flush=True)


if __name__ == "__main__":
    main()
