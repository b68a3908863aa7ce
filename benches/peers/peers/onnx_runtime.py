"""Our network in ONNX Runtime on the CPU, exported by PyTorch."""

import functools
from pathlib import Path

from peers import reference
from peers.base import NETWORK, Entry, Options, Sample, judged
from peers.python import run_worker, version


def entries(options: Options) -> list[Entry]:
    name = f"ONNX Runtime {version('onnxruntime')}"
    return [Entry(name, tier, "f32", NETWORK, reference.macs(tier),
                  functools.partial(_measure, tier, _export(tier, options), options))
            for tier in options.tiers]


def _export(tier: str, options: Options) -> Path:
    path = options.weights_cache / f"{tier}-{reference.digest(tier)}.onnx"
    if not path.exists():
        run_worker(options, "export_onnx", "--tier", tier, "--out", path)
    return path


def _measure(tier: str, model: Path, options: Options) -> Sample:
    check = reference.check_file(tier, options.weights_cache)
    return judged(run_worker(options, "onnx_runtime", "--model", model, "--check", check), "f32")
