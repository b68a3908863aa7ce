"""Runs peers that are Python packages in separate processes, to isolate crashes and leaks."""

import importlib.metadata
import sys
from pathlib import Path

from peers.base import Options, Unavailable, call, last_json


def version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        raise Unavailable(f"the Python package {package} is not installed") from None


def run_worker(options: Options, name: str, *arguments: str | Path) -> dict:
    """The report of `python -m workers.NAME`, which also gets the size and the number of frames."""
    frames = ["--width", str(options.width), "--height", str(options.height), "--runs", str(options.burst)]
    command = [sys.executable, "-m", f"workers.{name}", *frames, *arguments]
    return last_json(call(command, options.timeout, name=name))
