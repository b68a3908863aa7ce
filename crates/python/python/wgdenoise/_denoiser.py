"""Denoises arrays: the class `Denoiser` and the function `denoise`."""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping, Sequence
from typing import Any, Callable, NamedTuple, Optional, Union, overload

import numpy as np
import numpy.typing as npt

from . import _wgdenoise
from ._errors import UsageError

Array = npt.NDArray[np.float32]
Layers = Union[Mapping[str, Any], Sequence[Any]]
Progress = Callable[[int, int], object]

_LOG = logging.getLogger("wgdenoise")


class Denoised(NamedTuple):
    """The result of a call with layers or alpha."""

    color: Array
    """Like the input color: height × width × 3 or 4."""
    layers: Union[dict[str, Array], list[Array]]
    """Height × width × 3 each, under the names or in the order of the input layers."""
    alpha: Optional[Array]
    """Height × width, or `None` unless alpha was passed separately."""


class Denoiser:
    """A device with compiled kernels and weights, ready for images of any size.

    Threads may share it.

    Args:
        quality: the built-in weights: "fast", "balanced" or "high". Each takes two to three times as
            long as the one before.
        precision: storage format of intermediate values: "f16" or "f32".
        device: an adapter's number in `devices()` or part of its name; by default the fastest kind.
        weights: a weights file to use instead of the built-in ones, safetensors or TZA.
        memory_bytes: maximum GPU memory for tensors and images; 2 GiB by default. Large images are
            cut into tiles, which does not change the result.
        tile: longest side of a tile in pixels; by default as memory and short dispatches allow.
        timeout: seconds after which an unresponsive device counts as hung; by default 60, and 600 on
            CPU drivers.
        skip_clean: whether constant areas keep their pixels and skip the network.
        keep_memory: whether the GPU memory of one image stays allocated for the next one, which
            reuses it if it has the same size and inputs.

    Notices, such as a feature that the device lacks, go to the logger `wgdenoise` as warnings.

    Raises:
        UsageError: an argument has a value that is not allowed.
        FileError: the weights file cannot be read.
        AdapterError: no adapter was found, none matches the name, or it failed to open.
        DeviceError: the device failed.
    """

    def __init__(
        self,
        quality: str = "balanced",
        precision: str = "f16",
        device: Union[str, int, None] = None,
        *,
        weights: Union[str, os.PathLike[str], None] = None,
        memory_bytes: Optional[int] = None,
        tile: Optional[int] = None,
        timeout: Optional[float] = None,
        skip_clean: bool = True,
        keep_memory: bool = True,
    ) -> None:
        if weights is not None and quality != "balanced":
            raise UsageError("quality chooses among the built-in weights; give it or weights")
        self._network = _wgdenoise.Network(
            {
                "quality": quality,
                "weights": weights,
                "precision": precision,
                "device": None if device is None else str(device),
                "memory_bytes": memory_bytes,
                "tile": tile,
                "timeout": timeout,
                "skip_clean": skip_clean,
                "keep_memory": keep_memory,
            }
        )
        self._log_notices()

    @property
    def device(self) -> str:
        """The adapter's name."""
        return self._network.device

    @property
    def kernels(self) -> str:
        """The running kernel variant: "Simd", "Matrix", "Tiled" or "Plain"."""
        return self._network.kernels

    def __repr__(self) -> str:
        return f"<wgdenoise.Denoiser on {self.device}, {self.kernels} kernels>"

    @overload
    def denoise(
        self,
        color: Any,
        albedo: Any = None,
        normal: Any = None,
        *,
        layers: None = None,
        alpha: None = None,
        input_scale: Optional[float] = None,
        panorama: bool = False,
        srgb: bool = False,
        progress: Optional[Progress] = None,
    ) -> Array: ...

    @overload
    def denoise(
        self,
        color: Any,
        albedo: Any = None,
        normal: Any = None,
        *,
        layers: Optional[Layers] = None,
        alpha: Any = None,
        input_scale: Optional[float] = None,
        panorama: bool = False,
        srgb: bool = False,
        progress: Optional[Progress] = None,
    ) -> Denoised: ...

    def denoise(
        self,
        color: Any,
        albedo: Any = None,
        normal: Any = None,
        *,
        layers: Optional[Layers] = None,
        alpha: Any = None,
        input_scale: Optional[float] = None,
        panorama: bool = False,
        srgb: bool = False,
        progress: Optional[Progress] = None,
    ) -> Union[Array, Denoised]:
        """Denoise one view. All images have the same height and width, rows from the top.

        An image is a NumPy array of float32, float16 or float64 with any strides, or an object in
        main memory with `__array__` or DLPack: tensors of PyTorch, JAX, Dr.Jit.

        Args:
            color: height × width × 3, linear and scene-referred, at any exposure. Or height × width
                × 4, premultiplied by the fourth channel, which is alpha. NaN, infinite pixels and
                fireflies are repaired.
            albedo: height × width × 3, linear, in [0, 1].
            normal: height × width × 3, components in [-1, 1], in camera or world space.
            layers: further images of height × width × 3 that depend on the samples linearly, such as
                light groups, in a list or by name. They are denoised with the color's kernel weights,
                so layers that add up to the noisy color add up to the denoised one.
            alpha: height × width, in [0, 1]; color is premultiplied by it. Like a fourth channel, it
                is denoised if it is fractional anywhere.
            input_scale: the factor that exposes color to a middle gray of 0.18; measured by default.
            panorama: whether the left and right edges join, as in a latlong image.
            srgb: whether to decode three-channel uint8 color, albedo and layers as sRGB.
            progress: called with `(done, total)` in this thread. An exception that it raises stops the
                run and propagates.

        Returns:
            A new float32 array, linear, finite and with the channels of `color`. With `layers` or
            `alpha`, a `Denoised`.

        Raises:
            ImageError: an array cannot be used, or the sizes differ.
            UsageError: arguments contradict each other.
            WeightsError: weights without a kernel pyramid cannot denoise layers or alpha.
            OutOfMemoryError, DeviceError: the device failed.
            KeyboardInterrupt: Ctrl-C was pressed.
        """
        given = {
            "color": color,
            "albedo": albedo,
            "normal": normal,
            "layers": _named(layers),
            "alpha": alpha,
            "srgb": srgb,
        }
        try:
            found = self._network.denoise(given, input_scale, panorama, progress)
        finally:
            self._log_notices()
        if layers is None and alpha is None:
            return found[0]
        denoised = dict(zip(layers, found[1])) if isinstance(layers, Mapping) else found[1]
        return Denoised(found[0], denoised, found[2])

    def _log_notices(self) -> None:
        for notice in self._network.take_notices():
            _LOG.warning("%s", notice)


@overload
def denoise(
    color: Any,
    albedo: Any = None,
    normal: Any = None,
    *,
    layers: None = None,
    alpha: None = None,
    input_scale: Optional[float] = None,
    panorama: bool = False,
    srgb: bool = False,
    progress: Optional[Progress] = None,
    quality: str = "balanced",
    precision: str = "f16",
    device: Union[str, int, None] = None,
    **options: Any,
) -> Array: ...


@overload
def denoise(
    color: Any,
    albedo: Any = None,
    normal: Any = None,
    *,
    layers: Optional[Layers] = None,
    alpha: Any = None,
    input_scale: Optional[float] = None,
    panorama: bool = False,
    srgb: bool = False,
    progress: Optional[Progress] = None,
    quality: str = "balanced",
    precision: str = "f16",
    device: Union[str, int, None] = None,
    **options: Any,
) -> Denoised: ...


def denoise(
    color: Any,
    albedo: Any = None,
    normal: Any = None,
    *,
    layers: Optional[Layers] = None,
    alpha: Any = None,
    input_scale: Optional[float] = None,
    panorama: bool = False,
    srgb: bool = False,
    progress: Optional[Progress] = None,
    quality: str = "balanced",
    precision: str = "f16",
    device: Union[str, int, None] = None,
    **options: Any,
) -> Union[Array, Denoised]:
    """Denoise one view with a new `Denoiser`.

    Each call opens the device and compiles the kernels; a `Denoiser` does so once for any number of
    images. `quality`, `precision`, `device` and further options are those of `Denoiser`; everything
    else is as in `Denoiser.denoise`.
    """
    return Denoiser(quality, precision, device, **options).denoise(
        color,
        albedo,
        normal,
        layers=layers,
        alpha=alpha,
        input_scale=input_scale,
        panorama=panorama,
        srgb=srgb,
        progress=progress,
    )


def _named(layers: Optional[Layers]) -> list[tuple[str, Any]]:
    """Layers with the names that error messages use."""
    if layers is None:
        return []
    if isinstance(layers, Mapping):
        return [(f"layer `{name}`", layer) for name, layer in layers.items()]
    return [(f"layer {index}", layer) for index, layer in enumerate(layers)]
