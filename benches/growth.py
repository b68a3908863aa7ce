"""Measure how the time and memory of a frame grow with its size; draw docs/performance/growth.svg and print a table.

    cargo build --release
    python benches/growth.py

Every round runs `wgdenoise bench` once at each size, so that drifts in the machine's speed affect all sizes alike.
Results are medians over the rounds, relative to frames of 1024x1024.
"""

import argparse
import json
import statistics
import subprocess
from pathlib import Path

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
UNIT = (1024, 1024)
SIZES = (512, 512), UNIT, (1920, 1080), (2048, 2048), (3840, 2160), (7680, 4320)
TIERS = "fast", "balanced"


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--program", type=Path, default=ROOT / "target/release/wgdenoise")
    p.add_argument("--rounds", type=int, default=3)
    p.add_argument("--out", type=Path, default=ROOT / "docs/performance/growth.svg")
    return p.parse_args()


def bench(program, tier, size):
    """The report of one frame after a warm-up."""
    command = [program, "bench", "--quality", tier, "--runs", "1", "--json"]
    command += ["--width", str(size[0]), "--height", str(size[1])]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def measure(program, rounds):
    """{(tier, size): reports of all rounds}."""
    reports = {(tier, size): [] for tier in TIERS for size in SIZES}
    for _ in range(rounds):
        for (tier, size), found in reports.items():
            found.append(bench(program, tier, size))
    return reports


def rows(reports):
    """Rows of tier, size, seconds, nanoseconds per pixel, these relative to the unit, tiles, and memory in MiB."""
    seconds = {key: statistics.median(r["median_seconds"] for r in found) for key, found in reports.items()}
    each = {(tier, size): 1e9 * s / (size[0] * size[1]) for (tier, size), s in seconds.items()}
    for (tier, size), found in reports.items():
        nanoseconds = each[tier, size]
        yield (tier, size, seconds[tier, size], nanoseconds, nanoseconds / each[tier, UNIT], found[0]["tiles"],
               found[0]["memory_bytes"] / 2**20)


def draw(table, adapter, out):
    figure, (time, memory) = pyplot.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    for tier in TIERS:
        own = [row for row in table if row[0] == tier]
        megapixels = [row[1][0] * row[1][1] / 1e6 for row in own]
        time.plot(megapixels, [row[4] for row in own], marker="o", label=tier)
        memory.plot(megapixels, [row[6] for row in own], marker="o", label=tier)
    time.axhspan(0.9, 1.1, alpha=0.15)
    time.set(ylabel="time per pixel, 1024×1024 = 1", ylim=(0, 1.5))
    memory.set(ylabel="GPU memory, MiB", ylim=(0, None))
    for axes in (time, memory):
        axes.set(xlabel="megapixels", xscale="log")
        axes.grid(alpha=0.3)
        axes.legend()
    figure.suptitle(adapter, fontsize=9)
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out, metadata={"Date": None})


def main():
    o = arguments()
    reports = measure(o.program, o.rounds)
    table = list(rows(reports))
    draw(table, next(iter(reports.values()))[0]["adapter"], o.out)
    print("| weights | size | seconds | ns per pixel | relative to 1024×1024 | tiles | GPU memory |\n|---|---|---|---|---|---|---|")
    for tier, (width, height), seconds, each, relative, tiles, memory in table:
        print(f"| {tier} | {width}×{height} | {seconds:.2f} | {each:.0f} | {relative:.2f} | {tiles} | {memory:.0f} MiB |")


if __name__ == "__main__":
    main()
