"""Write the EMA weights of a checkpoint as a safetensors file for the denoiser.

    python export.py RUN/best.pt mine.safetensors

Convolution weights are stored as F16, biases and batch norm as F32. The norm is not folded; the program does that.
"""

import argparse
import json
from pathlib import Path

import torch
from safetensors.torch import save

from run import load_checkpoint

DATA = "path-traced renders of random procedural scenes by Cycles, Mitsuba 3 and LuxCore"
FORMAT = dict(format="wgdenoise", format_version="1", inputs="color,albedo,normal", transfer_function="pu",
              norm_eps="1e-5")


def tensors_of(state):
    """The file's tensors from a state dict: same names, convolutions in half precision, no batch counters."""
    kept = {k: v for k, v in state.items() if not k.endswith("num_batches_tracked")}
    return {k: v.to(torch.float16 if v.ndim == 4 else torch.float32).contiguous() for k, v in kept.items()}


def save_weights(path, state, topology, widths, name, provenance):
    """Write a weights file; `widths` runs from the full-resolution level to the bottom."""
    tensors = tensors_of(state)
    bad = [k for k, v in tensors.items() if not torch.isfinite(v).all()]
    if bad:
        raise SystemExit(f"{path}: {bad[0]} has values that are not finite in the stored type; train with a lower rate")
    metadata = dict(FORMAT, topology=topology, widths=",".join(map(str, widths)), name=name, provenance=provenance)
    path.write_bytes(_sorted_header(save(tensors, metadata)))


def _sorted_header(data):
    """The file with sorted metadata. The library orders it randomly, but equal weights should give equal files."""
    end = 8 + int.from_bytes(data[:8], "little")
    header = json.loads(data[8:end])
    header["__metadata__"] = dict(sorted(header["__metadata__"].items()))
    text = json.dumps(header, separators=(",", ":")).encode().ljust(end - 8)
    return data[:8] + text + data[end:]


def provenance(checkpoint, options):
    """The text of the provenance entry in the metadata."""
    training = "; then ".join(checkpoint["history"])
    return f"data: {options.data}; training: {training}; license: {options.license}"


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("checkpoint", type=Path)
    p.add_argument("weights", type=Path)
    p.add_argument("--data", default=DATA, help="description of the training data, for the provenance entry")
    p.add_argument("--license", default="MIT OR Apache-2.0", help="license of the weights, for the provenance entry")
    o = p.parse_args()
    c = load_checkpoint(o.checkpoint)
    o.weights.parent.mkdir(parents=True, exist_ok=True)
    save_weights(o.weights, c["ema"], c["topology"], c["widths"], c["tier"], provenance(c, o))
    print(f"{o.weights}: {o.weights.stat().st_size / 1e6:.2f} MB, {provenance(c, o)}")


if __name__ == "__main__":
    main()
