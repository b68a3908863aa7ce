"""Our network in ONNX Runtime on the CPU."""

from pathlib import Path

import numpy as np
import onnxruntime

from peers.machine import cores
from workers import common


def main() -> None:
    p = common.parser()
    p.add_argument("--model", type=Path, required=True)
    o = p.parse_args()
    session = _session(o.model)
    (source,) = session.get_inputs()

    def run(x: np.ndarray) -> np.ndarray:
        return session.run(None, {source.name: x})[0]

    frame = np.random.default_rng(1).random((1, source.shape[1], o.height, o.width), np.float32)
    error = common.largest_error(o.check, run)
    common.report(common.cpu_adapter(), error, common.timed(lambda: run(frame), o.runs))


def _session(model: Path) -> onnxruntime.InferenceSession:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = cores()
    return onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])


if __name__ == "__main__":
    main()
