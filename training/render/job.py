"""Renders all views of one scene, each as a reference and several noisy images, for training.

    python -m render.job cycles 7 --out views --samples random:3 --reference 512
    python -m render.job cycles 0 --out views --blend kitchen.blend --samples 2,10,50 --reference 4000

render_dataset.py runs one such process per scene. Views are written from last to first, so view 0 marks the scene as
complete. Existing views are not rendered again.
"""

import argparse
import importlib
import os
import re
from pathlib import Path

import numpy as np

from render import kinds
from write_view import write_view

CHUNKS = 4  # independent parts of a reference; their spread gives its error
REFERENCE, NOISY, COUNTS = range(3)  # purposes of seeds
LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


def seed_sequence(scene, view, purpose, index=0):
    """An independent seed sequence for every scene (by name), view, purpose and index."""
    return np.random.SeedSequence([view, purpose, index, *scene.encode()])


def noise_seed(*key):
    """A seed of 31 bits, which all renderers accept."""
    return int(seed_sequence(*key).generate_state(1)[0]) >> 1


def sample_counts(text, scene, view):
    """Parses "4,16,64" to these counts; for "random:3", draws three distinct ones log-uniformly from 1 to 256."""
    if not text.startswith("random:"):
        return sorted({int(count) for count in text.split(",")})
    rng, counts = np.random.default_rng(seed_sequence(scene, view, COUNTS)), set()
    while len(counts) < int(text.removeprefix("random:")):
        counts.add(round(2 ** rng.uniform(0, 8)))
    return sorted(counts)


def render_reference(renderer, scene, view, samples):
    """The mean of CHUNKS renders with different seeds, and its relative error.

    A pixel's relative error is the standard error of its mean luminance, estimated from the chunks, over that luminance
    plus 1 % of the image's mean. The result is the mean over all pixels.
    """
    total, luminances = 0, []
    for index in range(CHUNKS):
        chunk = renderer.render(view, -(-samples // CHUNKS), noise_seed(scene, view, REFERENCE, index))
        chunk = np.nan_to_num(chunk, nan=0, posinf=0, neginf=0)  # a bad pixel counts as black
        total = total + chunk
        luminances.append(np.tensordot(LUMINANCE, chunk[:3], 1))
    mean = np.mean(luminances, 0)
    error = np.std(luminances, 0, ddof=1) / CHUNKS**0.5
    return total / CHUNKS, float(np.mean(error / (mean + 0.01 * mean.mean() + 1e-8)))


def render_view(renderer, o, scene, view, kind):
    """Renders one view of the scene named `scene`; stores it under its final name once complete."""
    path = o.out / f"{scene}_v{view}.npz"
    if path.exists():
        return
    reference, error = render_reference(renderer, scene, view, o.reference)
    noisy = list((progressive if o.progressive else independent)(renderer, o, scene, view))
    part = path.with_suffix(".part")
    write_view(part, reference, noisy, kind=kind, ref_relerr=error)
    os.replace(part, path)


def independent(renderer, o, scene, view):
    """The noisy images, rendered independently."""
    for count in sample_counts(o.samples, scene, view):
        keep = dict(keep=o.out / "exr" / f"{scene}_v{view}_{count}spp.exr") if o.exr else {}
        yield count, renderer.render(view, count, noise_seed(scene, view, NOISY, count), **keep)


def progressive(renderer, o, scene, view):
    """The noisy images, each adding samples to the previous one: half the work, and nearly as good for measurements.

    Their errors are correlated, and samples drawn in parts are a little less evenly spread."""
    mean, done = 0.0, 0
    for count in sample_counts(o.samples, scene, view):
        more = renderer.render(view, count - done, noise_seed(scene, view, NOISY, count))
        mean, done = mean + (more - mean) * ((count - done) / count), count
        yield count, mean


def open_scene(o):
    """The renderer, the scene's name and kind, and its number of views."""
    module = importlib.import_module(f"render.{o.renderer}")
    if o.blend:
        renderer = module.BlendRenderer(o.blend, o.size, o.threads)
        return renderer, blend_name(o.blend), "blend", len(renderer.views)
    scene = kinds.random_scene(o.seed)
    renderer = module.Renderer(scene, o.size or (192, 192), o.threads, o.filter)
    return renderer, f"{o.renderer}{o.seed:06d}", scene.kind, len(scene.cameras)


def blend_name(path):
    """The name of a user's scene. In a view's name "_v" precedes the view's number, so scene names avoid it."""
    return Path(path).stem.replace("_v", "-v")


def parse_size(text):
    """Parses "192" or "480x270" to (width, height)."""
    if not re.fullmatch(r"[1-9]\d*(x[1-9]\d*)?", text):
        raise argparse.ArgumentTypeError(f"{text}: expected a size such as 192 or 480x270")
    width, _, height = text.partition("x")
    return int(width), int(height or width)


def parse_samples(text):
    """Checks that sample_counts understands `text`, and returns it."""
    if not re.fullmatch(r"random:[1-9]|[1-9]\d*(,[1-9]\d*)*", text):
        raise argparse.ArgumentTypeError(f"{text}: expected counts such as 4,16,64 or random:3 (at most random:9)")
    return text


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("renderer", help="cycles, mitsuba or luxcore")
    p.add_argument("seed", type=int, help="number of the random scene; unused with --blend")
    p.add_argument("--out", type=Path, required=True, help="folder for the views")
    p.add_argument("--size", type=parse_size, help="192 or 480x270; default 192, or the size in the .blend file")
    p.add_argument("--samples", type=parse_samples, default="random:3", help="of the noisy images: 4,16,64 or random:3")
    p.add_argument("--reference", type=int, default=512, help="samples of the reference")
    p.add_argument("--views", type=int, default=99, help="maximum number of views")
    p.add_argument("--threads", type=int, default=1)
    p.add_argument("--filter", choices=("narrow", "gaussian"), default="narrow", help="pixel filter")
    p.add_argument("--blend", help="a Blender file instead of a random scene (cycles)")
    p.add_argument("--progressive", action="store_true", help="noisy images share samples; for measurements only")
    p.add_argument("--gpu", action="store_true", help="render on the GPU (cycles)")
    p.add_argument("--exr", action="store_true", help="also save the noisy images as EXR in OUT/exr (cycles)")
    return p.parse_args()


def main():
    o = arguments()
    (o.out / "exr" if o.exr else o.out).mkdir(parents=True, exist_ok=True)
    renderer, scene, kind, views = open_scene(o)
    if o.gpu:
        renderer.use_gpu()
    for view in reversed(range(min(views, o.views))):
        render_view(renderer, o, scene, view, kind)


if __name__ == "__main__":
    main()
