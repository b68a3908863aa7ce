"""Measure the program from its start to the finished file, and where that time goes; print a table.

    cargo build --release
    pip install OpenEXR
    python benches/whole_program.py

The frames are the sample with its albedo, normals and alpha, repeated to 1024x1024 and 3840x2160 pixels. A cold start
has no cache of compiled kernels, neither ours nor the driver's (Mesa's; other drivers keep theirs). Each round runs
every row once; results are medians over the rounds.
"""

import argparse
import os
import re
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).resolve().parent.parent
SAMPLE = ROOT / "samples/still_life_8spp.exr"
SIZES = (1024, 1024), (3840, 2160)
STEPS = "read", "prepared", "denoised", "written"
UNITS = {"ms": 1e-3, "s": 1.0}


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--program", type=Path, default=ROOT / "target/release/wgdenoise")
    p.add_argument("--tiers", nargs="+", default=["fast", "balanced"])
    p.add_argument("--rounds", type=int, default=3)
    return p.parse_args()


def frame(path, size):
    """Writes all channels of the sample in one part, repeated to the size, with its original compression."""
    parts = OpenEXR.File(str(SAMPLE), separate_channels=True).parts
    width, height = size

    def repeated(pixels):
        times = [-(-side // own) for side, own in zip((height, width), pixels.shape)]
        return np.ascontiguousarray(np.tile(pixels, times)[:height, :width])

    channels = {name: repeated(channel.pixels) for part in parts for name, channel in part.channels.items()}
    header = {"compression": parts[0].compression(), "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, channels).write(str(path))


def run(program, tier, source, folder, caches):
    """Seconds of the whole process, and of the steps that it reports."""
    out = folder / "out.exr"
    environment = os.environ | {"XDG_CACHE_HOME": str(caches), "MESA_SHADER_CACHE_DIR": str(caches)}
    start = time.monotonic()
    command = [program, source, out, "--quality", tier, "--verbose", "--force"]
    told = subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stderr
    whole = time.monotonic() - start
    found = dict(re.findall(r"(\w+) in ([\d.]+\w+)", told))
    return [whole, *(seconds(found[step]) for step in STEPS)]


def seconds(text):
    number, unit = re.fullmatch(r"([\d.]+)(\w+)", text).groups()
    return float(number) * UNITS[unit]


def measure(o, folder):
    """{(tier, size, start): seconds of every run}."""
    sources = {size: folder / f"{size[0]}.exr" for size in SIZES}
    for size, path in sources.items():
        frame(path, size)
    found = {(tier, size, start): [] for tier in o.tiers for size in SIZES for start in ("cold", "warm")}
    for _ in range(o.rounds):
        for (tier, size, start), runs in found.items():
            if start == "cold":
                caches = Path(tempfile.mkdtemp(dir=folder))
            runs.append(run(o.program, tier, sources[size], folder, caches))
    return found


def main():
    o = arguments()
    with tempfile.TemporaryDirectory() as folder:
        found = measure(o, Path(folder))
    print("| weights | size | start | whole, s | read | prepared | denoised | written | rest |\n|---|---|---|---|---|---|---|---|---|")
    for (tier, (width, height), start), runs in found.items():
        whole, *steps = (statistics.median(column) for column in zip(*runs))
        shares = " | ".join(f"{s / whole:.0%}" for s in [*steps, max(0.0, whole - sum(steps))])
        print(f"| {tier} | {width}×{height} | {start} | {whole:.2f} | {shares} |")


if __name__ == "__main__":
    main()
