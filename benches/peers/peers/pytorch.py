"""Our network in PyTorch: on the CPU in 32-bit float, on CUDA in half precision."""

import functools

from peers import reference
from peers.base import NETWORK, Entry, Options, Sample, judged
from peers.python import run_worker, version


def cpu(options: Options) -> list[Entry]:
    return _entries(options, "cpu", "f32")


def cuda(options: Options) -> list[Entry]:
    return _entries(options, "cuda", "f16")


def _entries(options: Options, device: str, precision: str) -> list[Entry]:
    run_worker(options, "pytorch", "--probe", "--device", device)
    return [Entry(f"PyTorch {version('torch')}", tier, precision, NETWORK, reference.macs(tier),
                  functools.partial(_measure, tier, device, precision, options))
            for tier in options.tiers]


def _measure(tier: str, device: str, precision: str, options: Options) -> Sample:
    check = reference.check_file(tier, options.weights_cache)
    return judged(run_worker(options, "pytorch", "--tier", tier, "--check", check, "--device", device,
                             "--precision", precision), precision)
