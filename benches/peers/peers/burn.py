"""Our network on Burn's wgpu backend, with the small program in `burn`, a separate package."""

import functools
from pathlib import Path

from peers import reference
from peers.base import CACHE, HERE, NETWORK, Entry, Options, Sample, Unavailable, call, existing, judged, last_json

VERSION = "0.22.1"  # as in burn/Cargo.toml
PROGRAM = "wgdenoise-peer-burn"
PRECISIONS = ("f32", "f16")


def entries(options: Options) -> list[Entry]:
    program = existing(options.burn) if options.burn else _build(options)
    return [Entry(f"Burn {VERSION}", tier, precision, NETWORK, reference.macs(tier),
                  functools.partial(_measure, program, tier, precision, options))
            for tier in options.tiers for precision in PRECISIONS]


def _build(options: Options) -> Path:
    folder = CACHE / "burn-target"
    call(["cargo", "build", "--release", "--locked", "--manifest-path", HERE / "burn" / "Cargo.toml",
          "--target-dir", folder], options.timeout)
    return existing(folder / "release" / PROGRAM)


def _measure(program: Path, tier: str, precision: str, options: Options) -> Sample:
    if reference.topology(tier) != "unet":
        raise Unavailable("the program has only the network that outputs color")
    check = reference.check_file(tier, options.weights_cache)
    size = ["--width", str(options.width), "--height", str(options.height)]
    report = last_json(call([program, "--weights", reference.weights_file(tier), "--check", check, *size,
                             "--runs", str(options.burst), "--precision", precision], options.timeout))
    report["adapter"] += f", {report['compiler']}"
    return judged(report, precision)
