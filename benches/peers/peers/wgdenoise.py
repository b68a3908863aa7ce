"""wgdenoise itself, by its own `bench`: every tier, in both precisions, on the default adapter."""

from pathlib import Path

from peers import reference
from peers.base import IMAGES, ROOT, Entry, Options, Sample, Unavailable, call, existing, last_json, median_ms

TIERS = ("fast", "balanced", "high")
PRECISIONS = ("f32", "f16")
NAME = "wgdenoise"


def entries(options: Options) -> list[Entry]:
    program = existing(options.wgdenoise) if options.wgdenoise else _build(options)
    return [_entry(program, tier, precision, options) for tier in TIERS for precision in PRECISIONS]


def _build(options: Options) -> Path:
    folder = ROOT / "target"
    call(["cargo", "build", "--release", "--locked", "--target-dir", folder], options.timeout, cwd=ROOT)
    return existing(folder / "release" / NAME)


def _entry(program: Path, tier: str, precision: str, options: Options) -> Entry:
    entry = Entry(NAME, tier, precision, IMAGES, reference.macs(tier))
    try:
        entry.check = reference.check_program(program, tier, precision)
    except Unavailable as wrong:
        entry.reason = str(wrong)
    entry.measure = lambda: _bench(program, tier, precision, options)
    return entry


def _bench(program: Path, tier: str, precision: str, options: Options) -> Sample:
    size = ["--width", options.width, "--height", options.height, "--runs", options.burst]
    report = last_json(call([program, "bench", "--json", "--quality", tier, "--precision", precision,
                             *map(str, size)], options.timeout))
    return Sample(median_ms(report["seconds"]), report["adapter"])
