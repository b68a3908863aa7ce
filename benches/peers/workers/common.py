"""What the workers share: their arguments, the check before the clock and the clock."""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from safetensors.numpy import load_file

from peers.machine import cores, processor


def parser() -> argparse.ArgumentParser:
    p = argparse.ArgumentParser()
    p.add_argument("--width", type=int, required=True)
    p.add_argument("--height", type=int, required=True)
    p.add_argument("--runs", type=int, default=1, help="timed runs, after one that warms up")
    p.add_argument("--check", type=Path, help="safetensors file with an `input` and the `output` to expect")
    return p


def cpu_adapter() -> str:
    return f"{processor()}, {cores()} threads"


def largest_error(path: Path, forward: Callable[[np.ndarray], np.ndarray]) -> float:
    """How far `forward` is from the output that the file expects; NaN stays NaN."""
    check = load_file(path)
    return float(np.abs(forward(check["input"]) - check["output"]).max())


def timed(run: Callable[[], object], runs: int) -> list[float]:
    """Seconds of each run, after one that warms up."""
    run()
    seconds = []
    for _ in range(runs):
        begin = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - begin)
    return seconds


def report(adapter: str, error: float, seconds: list[float]) -> None:
    print(json.dumps({"adapter": adapter, "max_error": error, "seconds": seconds}))
