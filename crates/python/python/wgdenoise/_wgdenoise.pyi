"""The compiled half of the package; `wgdenoise` wraps all of it."""

import logging
from typing import Any, Callable, Optional, final

import numpy as np
import numpy.typing as npt

__version__: str

__all__ = ["Network", "__version__", "compare", "denoise_files", "devices", "run_command"]

@final
class Network:
    def __new__(cls, settings: dict[str, Any]) -> Network: ...
    @property
    def device(self) -> str: ...
    @property
    def kernels(self) -> str: ...
    def take_notices(self) -> list[str]: ...
    def denoise(
        self,
        given: dict[str, Any],
        input_scale: Optional[float],
        panorama: bool,
        progress: Optional[Callable[[int, int], object]],
    ) -> tuple[
        npt.NDArray[np.float32], list[npt.NDArray[np.float32]], Optional[npt.NDArray[np.float32]]
    ]: ...

def compare(image: object, reference: object) -> tuple[float, float, float, float, float, int]: ...
def devices() -> list[tuple[str, str, str, str, str]]: ...
def denoise_files(
    words: list[str],
    logger: logging.Logger,
    progress: Optional[Callable[[int, int], object]],
) -> None: ...
def run_command(words: list[str]) -> int: ...
