"""Measure what averaging frames along their motion does to moving scenes; print a table.

    cargo build --release -p path_tracer
    pip install OpenEXR
    python demo/path_tracer/benches/temporal.py target/temporal

Each case is rendered with few samples per pixel, denoised frame by frame and over time, and compared with a denoised
render of many samples. References from an earlier run are reused. Values are display values in sRGB, exposed so that
the reference's log-average luminance is 0.18. Means over the second half of the frames:

    error     mean absolute difference from the reference
    hidden    the same, in pixels that the last frame did not show
    flicker   mean absolute difference from the last frame, where the motion vectors lead
"""

import argparse
import subprocess
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).resolve().parent.parent.parent.parent
CASES = {
    "still-life, camera": "--scene still-life --orbit 0.5",
    "still-life, spheres": "--scene still-life --animate",
    "still-life, both": "--scene still-life --orbit -0.5 --animate",
    "sky, both": "--scene sky --orbit 0.5 --animate",
    "fireflies, both": "--scene fireflies --orbit 0.5 --animate",
    "caustics, spheres": "--scene caustics --animate",
}
# Surfaces are different if their distances differ by more than this share.
SAME_DEPTH = 0.05


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("folder", type=Path, help="for the frames")
    p.add_argument("--program", type=Path, default=ROOT / "target/release/path_tracer")
    p.add_argument("--size", default="160x120")
    p.add_argument("--frames", type=int, default=10)
    p.add_argument("--reference-spp", type=int, default=128)
    p.add_argument("--spp", default="1")
    p.add_argument("--quality", default="fast")
    return p.parse_args()


def draw(args, folder, case):
    """Renders a case: the references only if they are missing, the others always."""
    folder.mkdir(parents=True, exist_ok=True)

    def run(*more):
        common = [args.program.resolve(), "--size", args.size, "--frames", str(args.frames), "--start", "0.8"]
        subprocess.run([*common, *case.split(), *more], cwd=folder, check=True, stdout=subprocess.DEVNULL)

    if not (folder / f"reference.{args.frames:04}.exr").exists():
        spp = str(args.reference_spp)
        run("--seed", "1000000", "--spp", spp, "--quality", "high", "--out", "many.exr", "--denoised", "reference.exr")
    for name, more in ("alone", []), ("averaged", ["--temporal"]):
        run("--spp", args.spp, "--quality", args.quality, "--out", "noisy.exr", "--denoised", f"{name}.exr", *more)


def read(path):
    """The channels by name."""
    channels = OpenEXR.File(str(path), separate_channels=True).parts[0].channels
    return {name: channel.pixels.astype(np.float64) for name, channel in channels.items()}


def light(channels):
    return np.stack([channels[name] for name in "RGB"], axis=-1)


def displayed(linear, exposure):
    x = np.clip(linear * exposure, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def exposure(linear):
    luminance = linear @ [0.2126, 0.7152, 0.0722]
    return 0.18 / np.exp(np.log(luminance[luminance > 0]).mean())


class Way:
    """The way from each pixel to its surface's position in the last frame."""

    def __init__(self, frame, last):
        y, x = np.indices(frame["Z"].shape)
        x, y = x + frame["motion.X"], y + frame["motion.Y"]
        height, width = frame["Z"].shape
        inside = (x >= 0) & (y >= 0) & (x <= width - 1) & (y <= height - 1)
        x, y = np.where(inside, x, 0), np.where(inside, y, 0)
        self.x, self.y = np.minimum(x.astype(int), width - 2), np.minimum(y.astype(int), height - 2)
        self.tx, self.ty = (x - self.x)[..., None], (y - self.y)[..., None]
        near = np.stack([last["Z"][self.y + j, self.x + i] for j in (0, 1) for i in (0, 1)])
        same = np.abs(near - frame["Z"]) <= SAME_DEPTH * frame["Z"]
        self.seen = inside & same.any(axis=0)

    def follow(self, image):
        """The last frame's image sampled bilinearly at the surfaces' positions."""
        rows = [(1 - self.tx) * image[self.y + j, self.x] + self.tx * image[self.y + j, self.x + 1] for j in (0, 1)]
        return (1 - self.ty) * rows[0] + self.ty * rows[1]


def measure(args, folder):
    """Error, error in hidden pixels, and flicker, for each kind of frames."""
    found = {name: [] for name in ("alone", "averaged", "reference")}
    for frame in range(args.frames // 2 + 1, args.frames + 1):
        way = Way(*(read(folder / f"noisy.{number:04}.exr") for number in (frame, frame - 1)))
        truth = light(read(folder / f"reference.{frame:04}.exr"))
        scale = exposure(truth)
        for name, values in found.items():
            now, last = (
                displayed(light(read(folder / f"{name}.{number:04}.exr")), scale) for number in (frame, frame - 1)
            )
            off = np.abs(now - displayed(truth, scale)).mean(axis=-1)
            change = np.abs(now - way.follow(last)).mean(axis=-1)
            values.append([off.mean(), off[~way.seen].mean(), change[way.seen].mean(), (~way.seen).mean()])
    return {name: np.nanmean(values, axis=0) for name, values in found.items()}


def main():
    args = arguments()
    print("| case | error | | hidden | | flicker | | of the reference |")
    print("|---|---|---|---|---|---|---|---|")
    for name, case in CASES.items():
        folder = (args.folder / name.replace(", ", "-")).resolve()
        draw(args, folder, case)
        found = measure(args, folder)
        pairs = [f"{found['alone'][i]:.4f} | {found['averaged'][i]:.4f}" for i in range(3)]
        print(f"| {name} | {' | '.join(pairs)} | {found['reference'][2]:.4f} |", flush=True)


if __name__ == "__main__":
    main()
