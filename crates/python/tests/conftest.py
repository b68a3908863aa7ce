"""Shared by the tests: a fast denoiser, and images."""

import signal
from pathlib import Path

import numpy as np
import pytest

import wgdenoise

REPOSITORY = Path(__file__).parents[3]
# Fast; the quality of its results does not matter here.
WEIGHTS = REPOSITORY / "tests/fixtures/unet_tiny.safetensors"


# A shell that runs the tests in the background makes them, and their child processes, ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def denoiser():
    return wgdenoise.Denoiser("fast")


@pytest.fixture
def noisy():
    return image()


def image(height=40, width=56, channels=3, seed=1):
    """Random values in [0, 1] that are exact in 16 bits, so that every float type gives the same image."""
    values = np.random.default_rng(seed).random((height, width, channels))
    return values.astype(np.float16).astype(np.float32)
