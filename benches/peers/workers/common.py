"""Shared by the workers: arguments, the check before timing, and timing."""

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
    p.add_argument("--runs", type=int, default=1, help="timed runs, after one warm-up")
    p.add_argument("--check", type=Path, help="safetensors file with an `input` and the expected `output`")
    return p


def cpu_adapter() -> str:
    return f"{processor()}, {cores()} threads"


def largest_error(path: Path, forward: Callable[[np.ndarray], np.ndarray]) -> float:
    """The largest error of `forward` against the file's output; NaN stays NaN."""
    check = load_file(path)
    return float(np.abs(forward(check["input"]) - check["output"]).max())


def timed(run: Callable[[], object], runs: int) -> list[float]:
    """Seconds of each run, after one warm-up."""
    run()
    seconds = []
    for _ in range(runs):
        begin = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - begin)
    return seconds


def report(adapter: str, error: float, seconds: list[float]) -> None:
    print(json.dumps({"adapter": adapter, "max_error": error, "seconds": seconds}))
