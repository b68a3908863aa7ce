"""The package's exceptions. Each message is one sentence: what was expected, what was found, what to do."""


class Error(Exception):
    """Base of all exceptions that wgdenoise raises, except for wrong argument types, which are `TypeError`."""


class ImageError(Error, ValueError):
    """An array has the wrong shape or dtype, is empty, has no finite value, or does not match another."""


class WeightsError(Error, ValueError):
    """The weights do not suit the task."""


class UsageError(Error, ValueError):
    """An argument has a value that is not allowed, or contradicts another."""


class FileError(Error, OSError):
    """A file could not be read or written."""


class AdapterError(Error, RuntimeError):
    """No adapter was found, none matches the name, or it failed to open."""


class OutOfMemoryError(Error, MemoryError):
    """The image does not fit in memory or in `memory_bytes`, even in the smallest tiles."""


class DeviceError(Error, RuntimeError):
    """The device was lost, hung or computed wrong results. Create a new `Denoiser`."""
