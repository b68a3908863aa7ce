# SPDX-License-Identifier: MIT OR Apache-2.0
"""Runs the denoiser on a thread of its own. Blender's data belong to the main thread; nothing here touches them."""

import logging
import threading
from dataclasses import dataclass

import wgdenoise

_LOG = logging.getLogger("wgdenoise")


@dataclass
class Call:
    """The arguments of a `wgdenoise.denoise_exr` call."""

    sources: list
    target: str
    options: dict


class Canceled(Exception):
    """Ends a run at its next step."""


class Job(threading.Thread):
    """Makes calls one after the other.

    `run` makes them in the calling thread, `start` in a new one. Errors do not leave the thread but go to `error`.

    Args:
        calls: a list of `Call`.
        deliver: called with this job once its calls have succeeded; the owner does so in the main thread.
        folder: a `tempfile.TemporaryDirectory`, removed when the job ends.
    """

    def __init__(self, calls, deliver=None, folder=None):
        super().__init__(name="wgdenoise", daemon=True)
        self.calls, self.deliver, self.folder = calls, deliver, folder
        self.fraction = 0.0
        self.error = ""
        self.canceled = False
        self.messages = []
        self.done = False  # set by the owner, after the delivery

    @property
    def device(self):
        """The run's description of its device: name, interface, kind. Empty until it is open."""
        lines = [message for message in self.messages if message.startswith("on ")]
        return lines[-1].removeprefix("on ").split(", kernels")[0] if lines else ""

    @property
    def color_alone(self):
        """Whether an image had neither albedo nor normals."""
        return any(message.startswith("color from") for message in self.messages) and not any(
            message.startswith(("albedo from", "normal from")) for message in self.messages
        )

    def cancel(self):
        """Stops the run at its next step, after the current tile."""
        self.canceled = True

    def run(self):
        listener = _Listener(self.messages)
        level = _LOG.level
        _LOG.addHandler(listener)
        _LOG.setLevel(logging.INFO)
        try:
            for index, call in enumerate(self.calls):
                self._make(call, index)
        except Canceled:
            pass
        except Exception as error:  # nobody could catch it outside the thread
            self.error = listener.first_error or str(error)
        finally:
            _LOG.setLevel(level)
            _LOG.removeHandler(listener)

    def _make(self, call, index):
        def step(done, total):
            self.fraction = (index + done / total) / len(self.calls)
            if self.canceled:
                raise Canceled

        wgdenoise.denoise_exr(call.sources, call.target, progress=step, verbose=True, **call.options)


class _Listener(logging.Handler):
    """Collects the denoiser's messages. If several images fail, the first error message counts."""

    def __init__(self, messages):
        super().__init__()
        self.messages, self.first_error = messages, ""

    def emit(self, record):
        self.messages.append(record.getMessage())
        if record.levelno >= logging.ERROR:
            self.first_error = self.first_error or record.getMessage()
