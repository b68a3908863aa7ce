"""Denoises files with the command line's own code."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable
from typing import Callable, Optional, Union

from . import _wgdenoise
from ._errors import UsageError

Path = Union[str, "os.PathLike[str]"]

_LOG = logging.getLogger("wgdenoise")


def denoise_exr(
    src: Union[Path, Iterable[Path]],
    dst: Path,
    *,
    progress: Optional[Callable[[int, int], object]] = None,
    **options: Union[str, float, bool, Path, None],
) -> None:
    """Denoise image files as `wgdenoise [OPTIONS] IN... OUT` does, in this process.

    An EXR file keeps every part, channel and attribute; only the denoised color changes. Albedo and
    normal are found by their names. PNG and JPEG work as well.

    Args:
        src: an image, a sequence such as `beauty.####.exr`, or several of them.
        dst: the output file, or a folder or pattern for several.
        progress: called with `(done, total)` in this thread, where each image counts 1000. An
            exception that it raises stops the run and propagates.
        **options: the command line's flags with underscores for dashes: `quality="high"`,
            `force=True`, `layers="auto"`, `frames="1-48"`. `True` passes a flag without a value;
            `False` and `None` omit it.

    The program's output goes to the logger `wgdenoise`: messages at the level `INFO`, failures of
    single images in a batch at `ERROR`. Ctrl-C raises `KeyboardInterrupt`. No partial outputs are
    left behind.

    Raises:
        FileError: an input could not be read, or an output could not be written.
        UsageError: the options are wrong.
        AdapterError, DeviceError: as in `Denoiser`.
    """
    sources = [src] if isinstance(src, (str, os.PathLike)) else list(src)
    if not sources:
        raise UsageError("src is empty, expected an image or several")
    given = {name: value for name, value in options.items() if value not in (False, None)}
    flags = [_flag(name, value) for name, value in given.items()]
    files = [os.fspath(path) for path in (*sources, dst)]
    _wgdenoise.denoise_files(["wgdenoise", *flags, "--", *files], _LOG, progress)


def _flag(name: str, value: object) -> str:
    flag = "--" + name.replace("_", "-")
    if value is True:
        return flag
    return f"{flag}={os.fspath(value) if isinstance(value, os.PathLike) else value}"
