"""Our networks: their size from the weights files, and their expected output from PyTorch in 32-bit float."""

import functools
import hashlib
import json
import re
import sys
from pathlib import Path

from peers.base import ROOT, TOLERANCE, Unavailable

sys.path.append(str(ROOT / "training"))

SIZE = (64, 96)  # rows and columns of the checked input, multiples of 16
SEED = 1


def weights_file(tier: str) -> Path:
    return ROOT / "weights" / f"{tier}.safetensors"


def digest(tier: str) -> str:
    """A hash for the names of derived files, so that new weights get new files."""
    return hashlib.sha256(weights_file(tier).read_bytes()).hexdigest()[:12]


@functools.cache
def header(tier: str) -> dict:
    """The header of the weights file, read without any package."""
    data = weights_file(tier).read_bytes()
    return json.loads(data[8:8 + int.from_bytes(data[:8], "little")])


def topology(tier: str) -> str:
    return header(tier)["__metadata__"]["topology"]


@functools.cache
def macs(tier: str) -> float:
    """Multiply-accumulates per pixel with nine input channels."""
    levels = header(tier)["__metadata__"]["widths"].count(",")
    shapes = {name: about["shape"] for name, about in header(tier).items() if name.endswith(".weight")}
    return sum(_layer_macs(name, shape, levels) for name, shape in shapes.items() if len(shape) == 4)


def _layer_macs(name: str, shape: list[int], levels: int) -> float:
    """A layer's multiply-accumulates per image pixel; `level` counts how often its output is halved."""
    level = levels if name.startswith("mid") else int((re.findall(r"\d+", name) or "0")[0])
    rows, columns, outputs, inputs = shape[2], shape[3], shape[0], shape[1]
    uses = 4 if name.startswith("dec_up") else 1  # each weight meets one output pixel in four
    return rows * columns * outputs * inputs / uses / 4**level


@functools.cache
def network(tier: str):
    """The network as defined in training/, in PyTorch's evaluation mode."""
    try:
        from quality.networks import Network
    except ImportError as e:
        raise Unavailable(f"the expected output needs PyTorch and safetensors: {e}") from None
    return Network(weights_file(tier)).model


def of_input(model):
    """The network as a function of only its input, whose first three channels also serve as the light that it
    gathers."""
    import torch

    class OfInput(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.model, self.inputs, self.levels = model, model.inputs, model.levels

        def forward(self, x):
            return self.model(x, torch.cat([x[:, :3], torch.ones_like(x[:, :1])], 1).float())

    return model if model.topology == "unet" else OfInput()


def check_file(tier: str, cache: Path) -> Path:
    """A safetensors file with a fixed random `input` and PyTorch's `output`, both NCHW."""
    path = cache / f"check-{tier}-{digest(tier)}.safetensors"
    if not path.exists():
        _write_check(path, of_input(network(tier)))
    return path


def _write_check(path: Path, model) -> None:
    import torch
    from safetensors.torch import save_file

    noise = torch.rand((1, model.inputs, *SIZE), generator=torch.Generator().manual_seed(SEED))
    with torch.inference_mode():
        output = model(noise)
    path.parent.mkdir(parents=True, exist_ok=True)
    save_file({"input": noise, "output": output.clone()}, path)


def check_program(program: Path, tier: str, precision: str) -> str:
    """The program's error against PyTorch in the encoding of the network's output, using EXR files."""
    try:
        error = _program_error(program, tier, precision)
    except ImportError as e:
        return f"not checked: {e}"
    except SystemExit as e:  # the training scripts report errors this way
        raise Unavailable(str(e)) from None
    if not error <= TOLERANCE[precision]:
        raise Unavailable(f"wrong: its output differs by {error:.1e} from PyTorch's, allowed {TOLERANCE[precision]:.1e}")
    return f"{error:.0e}"


def _program_error(program: Path, tier: str, precision: str) -> float:
    import torch
    from inference import denoise
    from quality.precision import run
    from transfer import autoexposure, transfer

    image = torch.rand((9, *SIZE), generator=torch.Generator().manual_seed(SEED))
    scale = autoexposure(image[:3])
    found, expected = run(program, image, weights_file(tier), precision), denoise(network(tier), image)
    return float((transfer(found * scale) - transfer(expected * scale)).abs().max())
