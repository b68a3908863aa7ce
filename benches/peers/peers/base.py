"""What a peer is, and the few things that all of them do: run a command, build a program, judge an output."""

import json
import os
import statistics
import subprocess
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).parents[1]  # benches/peers
ROOT = HERE.parents[1]
CACHE = HERE / ".cache"  # what is built and fetched; git does not see it

IMAGES = "images in memory to an image in memory"
BUFFERS = "buffers on the device"
NETWORK = "the network alone, on the device"

# The largest difference from PyTorch in 32-bit float that still counts as the same network, in outputs from 0 to 1:
# one step of a 16-bit image, and with half precision one step of an 8-bit image.
TOLERANCE = {"f32": 1 / 65535, "f16": 1 / 255}


class Unavailable(Exception):
    """A peer cannot be measured; the message says in one sentence why."""


@dataclass(frozen=True)
class Options:
    """What the user asked for."""

    width: int
    height: int
    burst: int  # timed frames per round
    tiers: tuple[str, ...]  # our networks that the frameworks run
    weights_cache: Path
    timeout: float  # seconds that one command may take
    wgdenoise: Path | None = None
    oidn_webgpu_native: Path | None = None
    burn: Path | None = None


@dataclass(frozen=True)
class Sample:
    """One round of one entry."""

    ms: float
    adapter: str
    check: str = ""  # how far the output is from what it should be


@dataclass
class Entry:
    """A row of the table: one network in one precision on one device."""

    peer: str
    network: str = ""
    precision: str = ""
    timed: str = ""  # what lies between the two looks at the clock
    macs: float | None = None  # multiply-accumulates per pixel
    measure: Callable[[], Sample] | None = field(default=None, repr=False)
    adapter: str = ""
    check: str = ""
    ms: list[float] = field(default_factory=list)  # one per round
    reason: str = ""  # why it was not measured; then `ms` does not count

    def take(self, sample: Sample) -> None:
        self.ms.append(sample.ms)
        self.adapter, self.check = sample.adapter, sample.check or self.check


@dataclass(frozen=True)
class Peer:
    """A denoiser by name; `entries` builds and checks it and may raise Unavailable."""

    name: str
    entries: Callable[[Options], list[Entry]]


def call(command: list[str | Path], timeout: float, cwd: Path = HERE, environment: dict[str, str] | None = None,
         name: str = "") -> str:
    """Standard output of a command; a failure of any kind becomes Unavailable, in which `name` names it."""
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
    """The last line that is no hint: what most likely says what went wrong."""
    lines = [line.strip() for line in (errors.strip() or output).splitlines()]
    return next((line for line in reversed(lines) if line and not line.startswith("note:")), "")


def last_json(text: str) -> dict:
    """The report of a program that prints one line of JSON last."""
    try:
        return json.loads(text.strip().splitlines()[-1])
    except (IndexError, ValueError):
        raise Unavailable("the program printed no report") from None


def existing(path: Path) -> Path:
    """A path that the user gave, or Unavailable."""
    if not path.is_file():
        raise Unavailable(f"{path.name} is not where the command line says; give the path of the built program")
    return path.resolve()


def median_ms(seconds: list[float]) -> float:
    return 1000 * statistics.median(seconds)


def judged(report: dict, precision: str) -> Sample:
    """The sample of a report with seconds, adapter and max_error; Unavailable if the output is wrong."""
    error, allowed = report["max_error"], TOLERANCE[precision]
    if not error <= allowed:  # NaN is wrong, too
        raise Unavailable(f"wrong: its output differs by {error:.1e} from PyTorch's, allowed {allowed:.1e}")
    return Sample(median_ms(report["seconds"]), report["adapter"], f"{error:.0e}")
