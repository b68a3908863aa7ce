"""Lists the machine's adapters and measures the error of images."""

from __future__ import annotations

from typing import NamedTuple

from . import _wgdenoise


class Device(NamedTuple):
    """An adapter of this machine: a GPU, or a driver that computes on the CPU."""

    number: int
    """The number for `device=`, which also takes part of a name."""
    name: str
    type: str
    """`DiscreteGpu`, `IntegratedGpu`, `VirtualGpu`, `Cpu` or `Other`."""
    backend: str
    """`Vulkan`, `Metal` or `Dx12`."""
    driver: str
    driver_info: str
    """The driver's version."""


class Metrics(NamedTuple):
    """How close an image is to its reference. Smaller is better, except for `psnr` and `ssim`.

    L1, PSNR and SSIM compare what a display shows: exposed so that the reference's log-average
    luminance is 0.18, clipped to [0, 1] and sRGB-encoded. The others compare linear light.
    """

    l1: float
    """Mean absolute difference, 0 to 1."""
    psnr: float
    """In dB, at most 120."""
    ssim: float
    """Structural similarity, -1 to 1."""
    relmse: float
    """Mean relative squared error, without the worst 0.1 % of the pixels."""
    smape: float
    """Symmetric mean absolute percentage error, 0 to 1."""
    bad: int
    """Number of pixels that are NaN or infinite; they count as 0."""


def devices() -> list[Device]:
    """All adapters of this machine, the fastest kind first; empty if there is none."""
    return [Device(number, *device) for number, device in enumerate(_wgdenoise.devices())]


def compare(image: object, reference: object) -> Metrics:
    """Measure the error of an image against its reference.

    Both are height × width × 3 arrays of linear, scene-referred color, as `denoise` takes them.

    Raises:
        ImageError: an array cannot be used, or the two differ in size.
    """
    return Metrics(*_wgdenoise.compare(image, reference))
