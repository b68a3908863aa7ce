"""Intel Open Image Denoise 2.5.1 on the CPU, from the package pyoidn, for comparison."""

from pathlib import Path

import numpy as np
import pyoidn
import torch

QUALITIES = dict(fast=pyoidn.OIDN_QUALITY_FAST, balanced=pyoidn.OIDN_QUALITY_BALANCED, high=pyoidn.OIDN_QUALITY_HIGH)
HOME = Path(pyoidn.__file__).parent / "oidn"

# Multiply-adds per pixel with color, albedo and normal, counted from the weight shapes in the library. `fast` runs a
# small U-Net with 320 thousand weights; `balanced` and `high` run one with 920 thousand, the largest for noisy
# features.
MACS = dict(fast=62136, balanced=125406, high=125406)


class Oidn:
    """One quality mode, callable like a Network. `cleanAux` is off because the features are noisy."""

    clean = False

    def __init__(self, quality, threads=1):
        self.name, self.quality = f"OIDN {quality}", QUALITIES[quality]
        self.device = pyoidn.Device(pyoidn.OIDN_DEVICE_TYPE_CPU)
        self.device.set_int("numThreads", threads)
        self.device.commit()

    def __call__(self, image, inputs):
        names = [n for n in ("color", "albedo", "normal") if n in inputs]
        parts = dict(zip(("color", "albedo", "normal"), image.float().split(3)))
        planes = {n: np.ascontiguousarray(parts[n].permute(1, 2, 0).numpy()) for n in names}
        return torch.from_numpy(self._color(planes)).permute(2, 0, 1)

    def _color(self, planes):
        return self._run(planes, hdr=True, cleanAux=self.clean)

    def _run(self, planes, **options):
        """Runs one filter, which denoises the first of the planes [H,W,3]."""
        planes = planes | dict(output=np.zeros_like(next(iter(planes.values()))))
        with pyoidn.Filter(self.device, pyoidn.OIDN_FILTER_TYPE_RT) as f:
            for name, plane in planes.items():
                f.set_image(name, plane, pyoidn.OIDN_FORMAT_FLOAT3)
            for name, value in options.items():
                f.set_bool(name, value)
            f.set_quality(self.quality)
            f.commit()
            f.execute()
        if error := self.device.get_error():
            raise SystemExit(f"Open Image Denoise: {error}")
        return planes["output"]


class PrefilteredOidn(Oidn):
    """A quality mode with prefiltered features, as Intel recommends for final frames."""

    clean = True

    def __init__(self, quality, threads=1):
        super().__init__(quality, threads)
        self.name += ", prefiltered"

    def _color(self, planes):
        features = {n: self._run({n: plane}) for n, plane in planes.items() if n != "color"}
        return super()._color(planes | features)
