"""The interface of peers, and their shared code: running commands, building programs, judging outputs."""

import json
import os
import statistics
import subprocess
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).parents[1]  # benches/peers
ROOT = HERE.parents[1]
CACHE = HERE / ".cache"  # builds and downloads; git ignores it

IMAGES = "images in memory to an image in memory"
BUFFERS = "buffers on the device"
NETWORK = "the network alone, on the device"

# Largest accepted difference from PyTorch in 32-bit float, for outputs in 0..1: one step of a 16-bit image, or in half
# precision one step of an 8-bit image.
TOLERANCE = {"f32": 1 / 65535, "f16": 1 / 255}


class Unavailable(Exception):
    """A peer cannot be measured; the message is one sentence with the reason."""


@dataclass(frozen=True)
class Options:
    """The user's options."""

    width: int
    height: int
    burst: int  # timed frames per round
    tiers: tuple[str, ...]  # our networks to run in the frameworks
    weights_cache: Path
    timeout: float  # seconds allowed per command
    wgdenoise: Path | None = None
    oidn_webgpu_native: Path | None = None
    burn: Path | None = None


@dataclass(frozen=True)
class Sample:
    """The result of one round of one entry."""

    ms: float
    adapter: str
    check: str = ""  # the largest error of the output


@dataclass
class Entry:
    """A row of the table: one network in one precision on one device."""

    peer: str
    network: str = ""
    precision: str = ""
    timed: str = ""  # what the clock covers
    macs: float | None = None  # multiply-accumulates per pixel
    measure: Callable[[], Sample] | None = field(default=None, repr=False)
    adapter: str = ""
    check: str = ""
    ms: list[float] = field(default_factory=list)  # one per round
    reason: str = ""  # why it was not measured; if set, ignore `ms`

    def take(self, sample: Sample) -> None:
        self.ms.append(sample.ms)
        self.adapter, self.check = sample.adapter, sample.check or self.check


@dataclass(frozen=True)
class Peer:
    """A denoiser. `entries` builds and checks it, and may raise Unavailable."""

    name: str
    entries: Callable[[Options], list[Entry]]


def call(command: list[str | Path], timeout: float, cwd: Path = HERE, environment: dict[str, str] | None = None,
         name: str = "") -> str:
    """Returns a command's standard output. Any failure becomes Unavailable and calls the command `name`."""
    name = name or Path(command[0]).name
    try:
        done = subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=timeout, cwd=cwd,
                              env=os.environ | (environment or {}), check=False)
    except OSError as e:
        raise Unavailable(f"{name} cannot be started: {e.strerror}") from None
    except subprocess.TimeoutExpired:
        raise Unavailable(f"{name} took longer than {timeout:.0f} s") from None
    if done.returncode != 0:
        complaint = _complaint(done.stderr, done.stdout) or f"exit code {done.returncode}"
        raise Unavailable(f"{name} failed: {complaint}")
    return done.stdout


def _complaint(errors: str, output: str) -> str:
    """The last line that is not a hint, which is most likely the error."""
    lines = [line.strip() for line in (errors.strip() or output).splitlines()]
    return next((line for line in reversed(lines) if line and not line.startswith("note:")), "")


def last_json(text: str) -> dict:
    """Parses the report of a program whose last line is JSON."""
    try:
        return json.loads(text.strip().splitlines()[-1])
    except (IndexError, ValueError):
        raise Unavailable("the program printed no report") from None


def existing(path: Path) -> Path:
    """Returns the path; raises Unavailable if there is no file."""
    if not path.is_file():
        raise Unavailable(f"{path.name} is not at the given path; give the path of the built program")
    return path.resolve()


def median_ms(seconds: list[float]) -> float:
    return 1000 * statistics.median(seconds)


def judged(report: dict, precision: str) -> Sample:
    """Turns a report with seconds, adapter and max_error into a sample; raises Unavailable if the output is wrong."""
    error, allowed = report["max_error"], TOLERANCE[precision]
    if not error <= allowed:  # NaN is wrong too
        raise Unavailable(f"wrong: its output differs by {error:.1e} from PyTorch's, allowed {allowed:.1e}")
    return Sample(median_ms(report["seconds"]), report["adapter"], f"{error:.0e}")
