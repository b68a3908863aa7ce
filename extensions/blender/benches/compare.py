# SPDX-License-Identifier: MIT OR Apache-2.0
"""Compares wgdenoise with Blender's own denoiser, Open Image Denoise, on the test scenes of docs/quality.md.

    cd training && python render_dataset.py cycles --out ../target/test --scenes 90020:90030 --views 1 \\
        --progressive --reference 2048 --samples 1,2,5,8,10,25,32,50,100,128,200
    cd .. && python extensions/blender/benches/compare.py target/test     # bpy 5.0, PyTorch and wgdenoise installed

Blender renders each scene with its denoiser on (its defaults: high quality, albedo and normals prefiltered accurately)
and keeps the noisy image beside the result; wgdenoise denoises that noisy image from the same file. The references are
those of the views, rendered with other seeds. Time is measured on the first scene: for Blender, what the denoiser adds
to a render of one sample; for wgdenoise, the whole call from file to file. Prints tables in Markdown.
"""

import argparse
import statistics
import sys
import tempfile
import time
from pathlib import Path

REPOSITORY = Path(__file__).parents[3]
sys.path.append(str(REPOSITORY / "training"))

import bpy
import wgdenoise
from render import cycles, kinds
from views import read_view

SAMPLES = 8, 64
SEED = 1
TIMED_SIZE = 960, 540
ROUNDS = 3
TIERS = "fast", "balanced", "high"


def render(renderer, samples, path, denoise):
    """Renders the first view into a multilayer file."""
    scene = bpy.context.scene
    scene.cycles.use_denoising, scene.cycles.denoiser = denoise, "OPENIMAGEDENOISE"
    scene.camera = renderer.cameras[0]
    scene.cycles.samples, scene.cycles.seed = samples, SEED
    scene.render.filepath = str(path.resolve())
    bpy.ops.render.render(write_still=True)


def color(path, name="Combined"):
    """A pass of a file, height × width × 3."""
    file = cycles.OpenImageIO.ImageInput.open(str(path))
    names = list(file.spec().channelnames)
    pixels = file.read_image("float")
    file.close()
    return pixels[..., [next(i for i, each in enumerate(names) if each.endswith(f"{name}.{axis}")) for axis in "RGB"]]


def errors(view, folder):
    """Rows of (scene, samples, method, metrics) for a view."""
    number = int(view.stem.removeprefix("cycles").split("_")[0])
    reference = read_view(view)["ref"][:3].permute(1, 2, 0).float().numpy()
    scene, own, clean = kinds.random_scene(number), folder / "own.exr", folder / "clean.exr"
    renderer = cycles.Renderer(scene, reference.shape[1::-1], threads=2)
    for samples in SAMPLES:
        render(renderer, samples, own, True)
        images = {"noisy": color(own, "Noisy Image"), "Blender's own": color(own)}
        for tier in TIERS:
            wgdenoise.denoise_exr(own, clean, quality=tier, force=True)
            images[f"wgdenoise {tier}"] = color(clean)
        for name, image in images.items():
            yield scene.kind, samples, name, wgdenoise.compare(image, reference)


def seconds(function, *arguments):
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


def times(view, folder):
    """Median seconds by method. The methods take turns, so that other work on the machine affects all of them."""
    number = int(view.stem.removeprefix("cycles").split("_")[0])
    renderer = cycles.Renderer(kinds.random_scene(number), TIMED_SIZE, threads=2)
    own, clean = folder / "own.exr", folder / "clean.exr"
    found = {}
    for _ in range(ROUNDS + 1):
        without = seconds(render, renderer, 1, own, False)
        for prefilter in ("NONE", "ACCURATE"):
            bpy.context.scene.cycles.denoising_prefilter = prefilter
            added = seconds(render, renderer, 1, own, True) - without
            found.setdefault(f"Blender's own, prefilter {prefilter.lower()}", []).append(added)
        for tier in TIERS:
            run = seconds(lambda: wgdenoise.denoise_exr(own, clean, quality=tier, force=True))
            found.setdefault(f"wgdenoise {tier}", []).append(run)
    return {name: statistics.median(each[1:]) for name, each in found.items()}  # the first round warms up


def print_errors(views, folder):
    print("| scene | samples | | L1 | PSNR | SSIM |\n|---|---:|---|---:|---:|---:|")
    for view in views:
        for kind, samples, name, error in errors(view, folder):
            print(f"| {kind} | {samples} | {name} | {error.l1:.4f} | {error.psnr:.1f} | {error.ssim:.3f} |", flush=True)


def print_times(view, folder):
    print(f"\n| {TIMED_SIZE[0]}×{TIMED_SIZE[1]} | seconds |\n|---|---:|")
    for name, found in times(view, folder).items():
        print(f"| {name} | {found:.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("views", type=Path, help="folder of the test views")
    parser.add_argument("--only", choices=("errors", "times"), help="measure one of the two")
    o = parser.parse_args()
    views = sorted(o.views.glob("cycles*_v0.npz"))
    with tempfile.TemporaryDirectory() as folder:
        if o.only != "times":
            print_errors(views, Path(folder))
        if o.only != "errors":
            print_times(views[0], Path(folder))


if __name__ == "__main__":
    main()
