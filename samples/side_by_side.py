"""Put EXR images side by side in one PNG, as in the README.

    pip install numpy OpenEXR pillow
    python samples/side_by_side.py OUT.png NOISY.exr DENOISED.exr REFERENCE.exr

All are exposed so that the last one's log-average luminance is middle gray, then clipped and sRGB encoded.
"""

import sys

import numpy as np
import OpenEXR
from PIL import Image

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


def color(path):
    """The combined layer of a Blender file, or plain R, G and B, as float32 [height, width, 3]."""
    with OpenEXR.File(path, separate_channels=True) as file:
        channels = {name: channel for part in file.parts for name, channel in part.channels.items()}
        layer = "ViewLayer.Combined." if "ViewLayer.Combined.R" in channels else ""
        return np.stack([np.array(channels[layer + c].pixels, np.float32) for c in "RGB"], -1)


def display(image, exposure):
    """Linear color to 8-bit sRGB."""
    x = np.clip(image * exposure, 0, 1)
    encoded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return np.rint(encoded * 255).astype(np.uint8)


def main(out, *paths):
    images = [color(path) for path in paths]
    luminance = images[-1] @ LUMINANCE
    exposure = 0.18 / np.exp(np.log(luminance[luminance > 1e-8]).mean())
    picture = Image.fromarray(np.concatenate([display(image, exposure) for image in images], 1))
    # Three quarters, so that the package with this picture stays below 10 MiB.
    width, height = (side * 3 // 4 for side in picture.size)
    picture.resize((width, height), Image.LANCZOS).save(out, optimize=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
