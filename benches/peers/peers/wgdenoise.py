"""wgdenoise itself, timed with its `bench` in both precisions on the default adapter: every tier, and Open Image
Denoise's networks, whose results agreement.py checks."""

import functools
from pathlib import Path

from peers import oidn_webgpu, reference
from peers.base import IMAGES, ROOT, Entry, Options, Sample, Unavailable, call, existing, last_json, median_ms

TIERS = ("fast", "balanced", "high")
PRECISIONS = ("f32", "f16")
NAME = "wgdenoise"


def entries(options: Options) -> list[Entry]:
    program = _program(options)
    return [_entry(program, tier, precision, options) for tier in TIERS for precision in PRECISIONS]


def oidn_entries(options: Options) -> list[Entry]:
    program = _program(options)
    oidn_webgpu.fetch_weights(options)
    return [Entry(NAME, f"OIDN's {network}", precision, IMAGES, macs,
                  functools.partial(_bench, program, ["--weights", options.weights_cache / file], precision, options))
            for file, (network, macs) in oidn_webgpu.WEIGHTS.items() for precision in PRECISIONS]


def _program(options: Options) -> Path:
    return existing(options.wgdenoise) if options.wgdenoise else _build(options)


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
    entry.measure = functools.partial(_bench, program, ["--quality", tier], precision, options)
    return entry


def _bench(program: Path, weights: list[str | Path], precision: str, options: Options) -> Sample:
    size = ["--width", options.width, "--height", options.height, "--runs", options.burst]
    report = last_json(call([program, "bench", "--json", *weights, "--precision", precision,
                             *map(str, size)], options.timeout))
    return Sample(median_ms(report["seconds"]), report["adapter"])
