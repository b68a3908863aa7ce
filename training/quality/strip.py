"""Draws one frame of an animation for docs/temporal.md: as rendered, denoised alone, by `--temporal`, and the reference.

    python -m quality.strip --scene changes/96010-lens --out ../docs/temporal/wide_lens.jpg

The second row shows flicker: each image's difference from its previous frame, moved along the motion vectors, six times
as bright. Pixels that the previous frame does not see are black.
"""

import argparse
from pathlib import Path

import torch
from PIL import Image

from metrics import display, exposure_of
from quality.temporal import Scene, back, by_program, moved

GAIN = 6


def rows(scene, program, count, at):
    """[2][4] images [3,H,W] in [0,1] of frame `at`, counted from 0."""
    alone, averaged = by_program(program, scene, count, []), by_program(program, scene, count, ["--temporal"])
    noisy = [frame["color"] for frame in scene.noisy(count)]
    scale = exposure_of(scene.references[at]["color"])
    way, seen = back(scene.references[at]["motion"]), scene.seen[at - 1]
    top, bottom = [], []
    for images in (noisy, alone, averaged, scene.clean):
        now, before = (display(image * scale) for image in (images[at], moved(images[at - 1], way)[0]))
        top.append(now)
        bottom.append((now - before).abs() * GAIN * seen)
    return top, bottom


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--scene", type=Path, required=True, help="a folder that render_animations.py wrote")
    p.add_argument("--out", type=Path, required=True)
    p.add_argument("--program", type=Path, default=Path("../target/release/wgdenoise"))
    p.add_argument("--samples", type=int, default=8)
    p.add_argument("--frame", type=int, default=6, help="counted from 0")
    o = p.parse_args()
    torch.set_num_threads(1)
    strip = torch.cat([torch.cat(row, 2) for row in rows(Scene(o.scene), o.program, o.samples, o.frame)], 1)
    pixels = (strip.clamp(0, 1) * 255).round().byte().permute(1, 2, 0).numpy()
    o.out.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(o.out, quality=90)


if __name__ == "__main__":
    main()
