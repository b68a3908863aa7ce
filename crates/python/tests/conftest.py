"""What the tests share: a quick denoiser, and images."""

import signal
from pathlib import Path

import numpy as np
import pytest

import wgdenoise

REPOSITORY = Path(__file__).parents[3]
# Quick to run; the quality of its results does not matter here.
WEIGHTS = REPOSITORY / "tests/fixtures/unet_tiny.safetensors"


# A shell that runs the tests in the background has them, and the processes they start, ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def denoiser():
    return wgdenoise.Denoiser("fast")


@pytest.fixture
def noisy():
    return image()


def image(height=40, width=56, channels=3, seed=1):
    """Values from 0 to 1 that 16 bits can hold, so that every float type gives the same image."""
    values = np.random.default_rng(seed).random((height, width, channels))
    return values.astype(np.float16).astype(np.float32)
