"""Intel Open Image Denoise 2.5.1, with its own oidnBenchmark, both from the PyPI package pyoidn.

The library has two networks for color, albedo and normal; its symbols call them `rt_hdr_alb_nrm_small` and
`rt_hdr_alb_nrm`. `fast` runs the small one, `balanced` and `high` the base one: at 512x512 on a CPU, `-v 2` reports 85
MB of memory for `fast` and 155 MB for the other two, which also take the same time.
"""

import functools
import importlib.util
import re
from pathlib import Path

from peers.base import BUFFERS, Entry, Options, Sample, Unavailable, call

# Network and multiply-accumulates per pixel with nine input channels, counted from the weight shapes.
SMALL, BASE = ("small", 62136), ("base", 125406)
QUALITIES = {"fast": SMALL, "balanced": BASE, "high": BASE}


def cpu(options: Options) -> list[Entry]:
    return _entries(options, "cpu", "f32")


def cuda(options: Options) -> list[Entry]:
    return _entries(options, "cuda", "its own")


def _entries(options: Options, device: str, precision: str) -> list[Entry]:
    benchmark = home() / "bin" / "oidnBenchmark"
    benchmark.chmod(0o755)
    listed = _call([benchmark, "--list_devices"], options.timeout)
    if device.upper() not in re.findall(r"Type: (\w+)", listed):
        raise Unavailable(f"Open Image Denoise finds no {device.upper()} device on this machine")
    return [Entry("OIDN 2.5.1", f"{network}, `{quality}`", precision, BUFFERS, macs,
                  functools.partial(_measure, benchmark, device, quality, options))
            for quality, (network, macs) in QUALITIES.items()]


def home() -> Path:
    """The library's folder, found without loading the library."""
    package = importlib.util.find_spec("pyoidn")
    if package is None or package.origin is None:
        raise Unavailable("the Python package pyoidn is not installed")
    return Path(package.origin).parent / "oidn"


def _measure(benchmark: Path, device: str, quality: str, options: Options) -> Sample:
    """Runs oidnBenchmark once: the mean over the timed frames; the first of the `-n` frames is a warm-up."""
    size = [str(options.width), str(options.height)]
    printed = _call([benchmark, "-d", device, "-r", "RT.hdr_alb_nrm.*", "-s", *size, "-q", quality,
                     "-n", str(1 + options.burst), "-v", "2"], options.timeout)
    ms = re.search(r"([\d.]+) msec/image", printed)
    if ms is None:
        raise Unavailable("oidnBenchmark printed no time")
    return Sample(float(ms[1]), _adapter(printed))


def _adapter(printed: str) -> str:
    about = (re.search(rf"{key}\s*: (.*)", printed) for key in ("Device", "ISA"))
    return ", ".join(found[1].strip() for found in about if found)


def _call(command: list[str | Path], timeout: float) -> str:
    return call(command, timeout, environment={"LD_LIBRARY_PATH": str(home() / "lib")})
