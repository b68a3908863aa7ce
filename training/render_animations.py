"""Renders short animations with motion vectors, noisy and as references, with Blender's Cycles, to measure `--temporal`.

    pip install bpy==5.0.1 numpy   needs Python 3.11
    python render_animations.py --out animations --scenes 95001:95009
    python render_animations.py --out changes --frames 12 --size 160 --scenes 96022 96010-lens 96011-cut 96014-mirror

Writes OUT/SCENE/n8.####.exr for 8 samples, and so on, and OUT/SCENE/reference.####.exr. Skips existing frames, so the
same command continues an interrupted run. A frame of 192x192 pixels takes about a minute on one core.
"""

import argparse
import itertools
import sys
from pathlib import Path

from render.job import parse_size
from render_dataset import number_range


def scenes_of(text):
    """Parses `3:5` to scenes 3 and 4, or `3` or `3-cut` to one scene: [(scene, change)]."""
    if ":" in text:
        return [(scene, None) for scene in number_range(text)]
    scene, _, change = text.partition("-")
    return [(int(scene), change or None)]


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--out", type=Path, required=True, help="folder for the animations")
    p.add_argument("--scenes", type=scenes_of, nargs="+", required=True, metavar="A:B|A-CHANGE",
                   help="random scenes A to B-1, or scene A with one of the changes of render/animation.py")
    p.add_argument("--frames", type=int, default=5)
    p.add_argument("--size", type=parse_size, default=(192, 192), help="192 or 480x270")
    p.add_argument("--samples", default="2,8,32", help="of the noisy frames")
    p.add_argument("--reference", type=int, default=128, help="samples of the references")
    p.add_argument("--threads", type=int, default=1)
    return p.parse_args()


def main():
    o = arguments()
    from render.animation import Animation  # needs bpy

    images = [(f"n{count}", count, count) for count in map(int, o.samples.split(","))]
    images.append(("reference", o.reference, 999))  # name, samples, seed
    for scene, change in itertools.chain(*o.scenes):
        folder = o.out / "-".join(filter(None, (str(scene), change)))
        folder.mkdir(parents=True, exist_ok=True)
        animation = None
        for frame in range(o.frames):
            for name, count, seed in images:
                path = folder / f"{name}.{frame + 1:04d}.exr"
                if path.exists():
                    continue
                animation = animation or Animation(scene, o.frames, o.size, o.threads, change)
                animation.render_frame(frame, count, 1000 * frame + seed, path)
            print(f"{folder.name}: frame {frame + 1} of {o.frames}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
