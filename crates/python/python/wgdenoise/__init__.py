"""Removes Monte Carlo noise from path-traced images, on any GPU or on a CPU driver.

    clean = wgdenoise.denoise(color, albedo, normal)

takes and returns arrays of height × width × 3. `Denoiser` keeps the device and its kernels for further
images; `denoise_exr` denoises files like the command `wgdenoise`.
"""

from __future__ import annotations

import os

from ._denoiser import Denoised, Denoiser, denoise
from ._errors import (
    AdapterError,
    DeviceError,
    Error,
    FileError,
    ImageError,
    OutOfMemoryError,
    UsageError,
    WeightsError,
)
from ._files import denoise_exr
from ._tools import Device, Metrics, compare, devices
from ._wgdenoise import __version__

# As on the command line: Mesa's device-select layer reorders adapters for desktops, and complains on stderr outside a
# desktop session.
os.environ.setdefault("NODEVICE_SELECT", "1")

__all__ = [
    "AdapterError",
    "Denoised",
    "Denoiser",
    "Device",
    "DeviceError",
    "Error",
    "FileError",
    "ImageError",
    "Metrics",
    "OutOfMemoryError",
    "UsageError",
    "WeightsError",
    "__version__",
    "compare",
    "denoise",
    "denoise_exr",
    "devices",
]
