"""Our network in PyTorch: batch norms folded, channels last, inference mode."""

import torch
from torch import nn
from torch.nn.utils.fusion import fuse_conv_bn_weights

from peers.machine import cores
from peers.reference import network, of_input
from workers import common

DTYPES = {"f32": torch.float32, "f16": torch.float16}


def main() -> None:
    p = common.parser()
    p.add_argument("--device", choices=("cpu", "cuda"), required=True)
    p.add_argument("--probe", action="store_true", help="only check that the device exists")
    p.add_argument("--tier")
    p.add_argument("--precision", choices=DTYPES, default="f32")
    o = p.parse_args()
    if o.device == "cuda" and not torch.cuda.is_available():
        raise SystemExit("PyTorch finds no CUDA device")
    if o.probe:
        common.report(o.device, 0.0, [])
        return
    torch.set_num_threads(cores())
    torch.backends.cudnn.benchmark = True
    with torch.inference_mode():
        _measure(o)


def _measure(o) -> None:
    placed = {"device": o.device, "dtype": DTYPES[o.precision], "memory_format": torch.channels_last}
    model = _folded(of_input(network(o.tier))).to(**placed)
    error = common.largest_error(o.check, lambda x: model(torch.from_numpy(x).to(**placed)).float().cpu().numpy())
    frame = torch.rand(1, model.inputs, o.height, o.width).to(**placed)
    common.report(_adapter(o.device), error, common.timed(lambda: _run(model, frame), o.runs))


def _run(model: nn.Module, frame: torch.Tensor) -> None:
    model(frame)
    if frame.is_cuda:
        torch.cuda.synchronize()


def _folded(model: nn.Module) -> nn.Module:
    """Folds batch norms into the convolutions before them: less work, same function."""
    for layer in model.modules():
        norm = getattr(layer, "norm", None)
        if isinstance(norm, nn.BatchNorm2d):
            layer.weight, layer.bias = fuse_conv_bn_weights(
                layer.weight, layer.bias, norm.running_mean, norm.running_var, norm.eps, norm.weight, norm.bias)
            layer.norm = nn.Identity()
    return model


def _adapter(device: str) -> str:
    return torch.cuda.get_device_name() if device == "cuda" else common.cpu_adapter()


if __name__ == "__main__":
    main()
