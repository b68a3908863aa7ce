"""Writes docs/hard-cases.md: our engine and Open Image Denoise on the hard cases.

    python benches/peers/hard_cases.py

Needs cargo, an adapter, and the packages numpy, safetensors and pyoidn.
"""

import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pyoidn
from safetensors.numpy import load_file, save_file

ROOT = Path(__file__).resolve().parents[2]


def main():
    with tempfile.TemporaryDirectory() as folder:
        inputs, outputs = Path(folder) / "inputs.safetensors", Path(folder) / "outputs.safetensors"
        hard_cases("inputs", inputs)
        save_file({name: denoise(image) for name, image in load_file(inputs).items()}, outputs)
        hard_cases("page", outputs, ROOT / "docs")


def hard_cases(*arguments):
    program = ["cargo", "run", "--release", "--quiet", "--package", "wgdenoise-testing", "--bin", "hard_cases", "--"]
    subprocess.run([*program, *map(str, arguments)], cwd=ROOT, check=True)


def denoise(image):
    """Denoises linear color [h,w,3] in the high quality mode, on the CPU."""
    device = pyoidn.Device(pyoidn.OIDN_DEVICE_TYPE_CPU)
    device.commit()
    color, output = np.ascontiguousarray(image), np.zeros_like(image)
    with pyoidn.Filter(device, pyoidn.OIDN_FILTER_TYPE_RT) as f:
        f.set_image("color", color, pyoidn.OIDN_FORMAT_FLOAT3)
        f.set_image("output", output, pyoidn.OIDN_FORMAT_FLOAT3)
        f.set_bool("hdr", True)
        f.set_quality(pyoidn.OIDN_QUALITY_HIGH)
        f.commit()
        f.execute()
    if error := device.get_error():
        raise SystemExit(f"Open Image Denoise: {error}")
    return output


if __name__ == "__main__":
    main()
