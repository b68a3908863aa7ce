"""Measures `--temporal` on animations with motion vectors and prints the tables of docs/temporal.md.

    python render_animations.py --out animations --scenes 95001:95009
    python -m quality.temporal --data animations

Open Image Denoise and the program denoise each frame alone; the program also uses one and two frames to each side. L1
and relative MSE are those of docs/quality.md. References with few samples are noisy themselves, which adds to all
errors; so L1 is also measured against denoised references, which favor neither side when the same frames are denoised
with and without `--temporal`. Flicker is SMAPE between a frame and the previous one, moved along the motion vectors,
where both see the surface. Hidden pixels are those that the previous frame does not see.
"""

import argparse
import subprocess
import tempfile
from collections import defaultdict
from pathlib import Path

import numpy as np
import OpenEXR
import pyoidn
import torch
from torch.nn import functional as F

from metrics import display, exposure_of, figures
from quality.oidn import Oidn

LAYERS = dict(color="Combined.RGB", albedo="Denoising Albedo.RGB", normal="Denoising Normal.XYZ", motion="Vector.XYZW")
SETTINGS = {"alone": [], "`--temporal`": ["--temporal"], "`--temporal=2`": ["--temporal=2"]}
FIGURES = "l1", "relmse", "clean", "flicker", "hidden"
HIDDEN = 1.0  # pixels by which the way there and back may miss a surface that both frames see
OTHER = 0.1  # albedo difference from which it is another surface


def read(path):
    """{name: [C,H,W]}: the layers of a frame written by Blender."""
    part = OpenEXR.File(str(path), separate_channels=True).parts[0]

    def layer(name):
        prefix, axes = name.rsplit(".", 1)
        return torch.from_numpy(np.stack([part.channels[f"ViewLayer.{prefix}.{axis}"].pixels for axis in axes])).float()

    return {name: layer(source) for name, source in LAYERS.items()}


def moved(image, offsets):
    """`image` [C,H,W] sampled at the offset positions [2,H,W], and a mask [H,W] of the positions inside it."""
    h, w = image.shape[1:]
    y, x = torch.meshgrid(torch.arange(h), torch.arange(w), indexing="ij")
    x, y = x + offsets[0], y + offsets[1]
    grid = torch.stack([(2 * x + 1) / w - 1, (2 * y + 1) / h - 1], -1)[None]
    inside = (x > -0.5) & (x < w - 0.5) & (y > -0.5) & (y < h - 0.5)
    return F.grid_sample(image[None], grid, padding_mode="border", align_corners=False)[0], inside


def back(motion):
    """Blender's motion vectors to the previous frame as image offsets: x right, y down."""
    return motion[:2] * torch.tensor([1.0, -1.0]).view(2, 1, 1)


def ahead(motion):
    return motion[2:] * torch.tensor([-1.0, 1.0]).view(2, 1, 1)


class Scene:
    """The frames of an animation, read once."""

    def __init__(self, folder):
        self.folder = folder
        self.references = [read(path) for path in sorted(folder.glob("reference.*.exr"))]
        self.counts = sorted({int(path.name[1:].split(".")[0]) for path in folder.glob("n*.exr")})
        self.seen = [self._seen(i) for i in range(1, len(self.references))]
        self.clean = [self._denoised(frame) for frame in self.references]

    def _seen(self, i):
        """A mask [H,W] of the pixels of frame i that the previous frame sees too."""
        way = back(self.references[i]["motion"])
        before = self.references[i - 1]
        there, inside = moved(ahead(before["motion"]), way)
        albedo, _ = moved(before["albedo"], way)
        same = (albedo - self.references[i]["albedo"]).abs().mean(0) < OTHER  # across a cut, the way back also returns
        return inside & same & ((way + there).norm(dim=0) < HIDDEN)

    def noisy(self, count):
        return [read(path) for path in sorted(self.folder.glob(f"n{count}.*.exr"))]

    @staticmethod
    def _denoised(frame):
        planes = [np.ascontiguousarray(frame[name].permute(1, 2, 0)) for name in ("color", "albedo", "normal")]
        return torch.from_numpy(pyoidn.denoise(*planes, hdr=True, clean_aux=True)).permute(2, 0, 1)

    def errors(self, images):
        """Lists per frame of L1, relative MSE, L1 to denoised references, flicker and L1 of hidden pixels."""
        found = defaultdict(list)
        for image, reference, clean in zip(images, self.references, self.clean):
            error = figures(image, reference["color"])
            found["l1"].append(error["l1"])
            found["relmse"].append(error["relmse"])
            found["clean"].append(figures(image, clean)["l1"])
        for i, seen in enumerate(self.seen, 1):
            before, _ = moved(images[i - 1], back(self.references[i]["motion"]))
            smape = (images[i] - before).abs() / (images[i].abs() + before.abs() + 1e-3)
            found["flicker"].append(float(smape[:, seen].mean()))
            if not seen.all():
                scale = exposure_of(self.references[i]["color"])
                a, b = (display(x * scale) for x in (images[i], self.references[i]["color"]))
                found["hidden"].append(float((a - b).abs()[:, ~seen].mean()))
        return found


def by_program(program, scene, count, options):
    """The frames as denoised by the program."""
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([program, scene.folder / f"n{count}.####.exr", out, "--quiet", *options], check=True)
        return [read(path)["color"] for path in sorted(Path(out).glob("*.exr"))]


def measure(program, scenes):
    """{(samples, method): {figure: mean over the scenes}}."""
    found, oidn = defaultdict(lambda: defaultdict(list)), Oidn("high")
    for scene in scenes:
        for count in scene.counts:
            stacks = [torch.cat([f["color"], f["albedo"], f["normal"]]) for f in scene.noisy(count)]
            results = {"OIDN high": [oidn(stack, "color,albedo,normal") for stack in stacks]}
            results |= {name: by_program(program, scene, count, o) for name, o in SETTINGS.items()}
            for method, images in results.items():
                for name, values in scene.errors(images).items():
                    found[count, method][name].append(sum(values) / len(values))
        flicker = scene.errors(scene.clean)["flicker"]
        found["", "reference, denoised"]["flicker"].append(sum(flicker) / len(flicker))
    return found


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--data", type=Path, required=True, help="folder of render_animations.py")
    p.add_argument("--program", type=Path, default=Path("../target/release/wgdenoise"))
    p.add_argument("--each", action="store_true", help="a table for each scene instead of their means")
    o = p.parse_args()
    torch.set_num_threads(1)
    scenes = [Scene(folder) for folder in sorted(o.data.iterdir()) if any(folder.glob("reference.*.exr"))]
    if o.each:
        for scene in scenes:
            print(table(scene.folder.name, measure(o.program, [scene])), flush=True)
    else:
        print(table(f"{len(scenes)} scenes", measure(o.program, scenes)))


def table(title, found):
    """The figures of `measure` as a Markdown table."""
    lines = [title, "", "| samples | method | L1 | relative MSE | L1, denoised reference | flicker | L1 of hidden pixels |",
             "|---|---|---|---|---|---|---|"]
    for (count, method), values in sorted(found.items(), key=lambda item: str(item[0][0]).zfill(4)):
        cells = [f"{np.mean(values[name]):.4f}" if values[name] else "" for name in FIGURES]
        lines.append(f"| {count} | {method} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
