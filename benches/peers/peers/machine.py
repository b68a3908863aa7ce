"""The description of this machine for the table."""

import os
import platform
import time
from pathlib import Path

from peers.base import ROOT, Unavailable, call


def cores() -> int:
    """The number of cores available to this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def processor() -> str:
    about = Path("/proc/cpuinfo")
    lines = about.read_text().splitlines() if about.exists() else []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "CPU"


def about() -> dict:
    return {"processor": processor(), "cores": cores(), "system": platform.platform(),
            "date": time.strftime("%Y-%m-%d", time.gmtime()), "commit": _commit()}


def _commit() -> str:
    try:
        return call(["git", "describe", "--always", "--dirty"], 60, cwd=ROOT).strip()
    except Unavailable:  # not a git checkout
        return "unknown"
