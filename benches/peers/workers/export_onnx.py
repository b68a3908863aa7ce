"""Exports our network as ONNX, for images whose sides are any multiples of 16."""

import contextlib
import json
import sys
from pathlib import Path

import torch

from peers.reference import SIZE, network, of_input
from workers import common


def main() -> None:
    p = common.parser()
    p.add_argument("--tier", required=True)
    p.add_argument("--out", type=Path, required=True)
    o = p.parse_args()
    o.out.parent.mkdir(parents=True, exist_ok=True)
    with contextlib.redirect_stdout(sys.stderr):  # the exporter prints
        _export(o.tier, o.out)
    print(json.dumps({"file": o.out.name}))


def _export(tier: str, path: Path) -> None:
    model = of_input(network(tier))
    sides = {axis: 2**model.levels * torch.export.Dim(name) for axis, name in ((2, "rows"), (3, "columns"))}
    unfinished = path.with_suffix(".part")
    torch.onnx.export(model, (torch.rand(1, model.inputs, *SIZE),), unfinished, dynamo=True, external_data=False,
                      dynamic_shapes=(sides,), input_names=["input"], output_names=["output"])
    unfinished.rename(path)


if __name__ == "__main__":
    main()
