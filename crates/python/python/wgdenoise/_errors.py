"""The package's exceptions. Each message is one sentence: what was expected, what was found, what to do."""


class Error(Exception):
    """Everything that wgdenoise raises, except for wrong argument types, which are `TypeError`."""


class ImageError(Error, ValueError):
    """An array has the wrong shape or dtype, is empty, holds no number, or does not match another."""


class WeightsError(Error, ValueError):
    """The weights were made for something else."""


class UsageError(Error, ValueError):
    """An argument is none of the values it may have, or contradicts another."""


class FileError(Error, OSError):
    """A file could not be read or written."""


class AdapterError(Error, RuntimeError):
    """No adapter was found, none matches the name, or it failed to open."""


class OutOfMemoryError(Error, MemoryError):
    """The image does not fit in memory or in `memory_bytes`, even in the smallest tiles."""


class DeviceError(Error, RuntimeError):
    """The device was lost, hangs or computes wrong results. Make a new `Denoiser`."""
