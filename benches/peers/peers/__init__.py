"""The denoisers that run.py measures, in the order of the table: ours first, then the others."""

from peers import burn, oidn, oidn_webgpu, onnx_runtime, pytorch, wgdenoise
from peers.base import Peer

ALL: tuple[Peer, ...] = (
    Peer("wgdenoise", wgdenoise.entries),
    Peer("wgdenoise-oidn", wgdenoise.oidn_entries),
    Peer("oidn-cpu", oidn.cpu),
    Peer("oidn-cuda", oidn.cuda),
    Peer("oidn-webgpu-native", oidn_webgpu.entries),
    Peer("burn", burn.entries),
    Peer("onnxruntime", onnx_runtime.entries),
    Peer("pytorch-cpu", pytorch.cpu),
    Peer("pytorch-cuda", pytorch.cuda),
)
