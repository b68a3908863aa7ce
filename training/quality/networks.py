"""The shipped networks, read from their weights files, so that PyTorch measures what the program loads."""

import hashlib
import re
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open

from inference import denoise
from model import TOPOLOGIES, network_for, parameter_count


class Network:
    """A network from a weights file. Call it with a render [9,H,W] and the inputs to use; it returns linear color
    [3,H,W]."""

    def __init__(self, path):
        self.path = Path(path)
        metadata, state = _read(self.path)
        self.name, self.provenance = metadata["name"], metadata.get("provenance", "unknown provenance")
        topology = _topology(metadata, self.path)
        self.model = network_for(topology, [int(w) for w in metadata["widths"].split(",")], state).eval()
        _fill(self.model, state, self.path)
        self.parameters, self.macs = parameter_count(self.model), macs_per_pixel(self.model)
        self.digest = hashlib.sha256(self.path.read_bytes()).hexdigest()[:12]

    def __call__(self, image, inputs):
        return denoise(self.model, image, inputs)

    def checkpoint(self):
        """A checkpoint with the entries of `best.pt`, see run.py. Batch norm keeps the file's statistics."""
        trained = re.fullmatch("data: .*?; training: (.*); license: .*?", self.provenance)  # as export.py writes it
        return dict(tier=self.name, topology=self.model.topology, widths=self.model.widths,
                    history=[trained[1] if trained else self.provenance], ema=self.model.state_dict())

    def row(self):
        """Identifies this network in the tables."""
        return dict(method=self.name, file=self.path.name, digest=self.digest, parameters=self.parameters,
                    macs=self.macs)


def load_all(paths):
    """The networks of the weights files, cheapest first."""
    return sorted(map(Network, paths), key=lambda n: n.macs)


def _read(path):
    """The metadata and float32 tensors of a weights file."""
    try:
        with safe_open(path, "pt") as f:
            metadata, state = f.metadata() or {}, {k: f.get_tensor(k).float() for k in f.keys()}
    except (OSError, SafetensorError) as e:
        raise SystemExit(f"{path}: not a readable weights file: {e}") from None
    if metadata.get("format") != "wgdenoise":
        raise SystemExit(f"{path}: not a wgdenoise weights file; export.py writes them")
    return metadata, state


def _topology(metadata, path):
    topology = metadata.get("topology")
    if topology not in TOPOLOGIES:
        raise SystemExit(f"{path}: topology {topology}; expected one of {', '.join(TOPOLOGIES)}")
    return topology


def _fill(model, state, path):
    missing = {k for k in model.state_dict() if not k.endswith("num_batches_tracked")} ^ state.keys()
    if missing:
        raise SystemExit(f"{path}: {min(missing)} is missing from the file or unknown to the network; export it again")
    model.load_state_dict(state, strict=False)


def macs_per_pixel(model):
    """Multiply-adds per image pixel with all inputs, as `wgdenoise info` and `bench` count them."""
    total = 0
    for name, layer in model.named_modules():
        if isinstance(layer, (torch.nn.Conv2d, torch.nn.ConvTranspose2d)):
            level = model.levels if name.startswith("mid") else int((re.findall(r"\d+", name) or "0")[0])
            uses = 4 if isinstance(layer, torch.nn.ConvTranspose2d) else 1  # each weight meets one output pixel in four
            total += layer.weight.numel() / uses / 4**level
    return total
