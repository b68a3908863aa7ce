"""Measures Python's overhead per frame: `wgdenoise bench` and a `Denoiser` take turns.

    python crates/python/benches/overhead.py --rounds 10

Both run the same code on the test card of `wgdenoise bench`, in separate processes, after a warm-up
frame. On a busy machine the second figure is more telling: the time to read three arrays, measured
with a call that then fails, plus the time to copy the result out.
"""

import argparse
import json
import statistics
import subprocess
import sys
import time

import numpy as np

import wgdenoise

CALLS = """
import sys, time
import numpy as np
import wgdenoise

side, runs, quality = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
y, x = np.mgrid[:side, :side].astype(np.uint32)
albedo = np.dstack([x / side, y / side, ((x ^ y) & 15) / 15]).astype(np.float32)
color, normal = 4 * albedo * albedo, 2 * albedo - 1
denoiser = wgdenoise.Denoiser(quality)
denoiser.denoise(color, albedo, normal)
for _ in range(runs):
    start = time.perf_counter()
    denoiser.denoise(color, albedo, normal)
    print(time.perf_counter() - start)
"""


def output(*command: str) -> str:
    run = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=True)
    return run.stdout


def rust(side: int, runs: int, quality: str) -> list[float]:
    size = ["--width", str(side), "--height", str(side)]
    words = ["bench", "--json", *size, "--runs", str(runs), "--quality", quality]
    return json.loads(output("-m", "wgdenoise", *words))["seconds"]


def python(side: int, runs: int, quality: str) -> list[float]:
    return [float(line) for line in output("-c", CALLS, str(side), str(runs), quality).split()]


def copies(side: int) -> float:
    """Return the seconds to read three arrays and to copy one, median of 20."""
    color, albedo, normal = np.random.default_rng(1).random((3, side, side, 3), np.float32)
    denoiser = wgdenoise.Denoiser("fast")

    def once() -> float:
        start = time.perf_counter()
        try:
            denoiser.denoise(color, albedo, normal, input_scale=0.0)
        except wgdenoise.ImageError:
            color.copy()
        return time.perf_counter() - start

    return statistics.median(once() for _ in range(20))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=1024)
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--quality", default="balanced")
    args = parser.parse_args()
    arguments = (args.side, args.runs, args.quality)
    ratios = []
    for _ in range(args.rounds):
        # The fastest run is the one least disturbed by other work on the machine.
        theirs, ours = min(rust(*arguments)), min(python(*arguments))
        ratios.append(ours / theirs)
        print(f"Rust {theirs * 1e3:.1f} ms, Python {ours * 1e3:.1f} ms: {ours / theirs - 1:+.1%}")
    print(f"median {statistics.median(ratios) - 1:+.1%} over {args.rounds} rounds")
    print(f"copies alone: {copies(args.side) * 1e3:.1f} ms")


if __name__ == "__main__":
    main()
