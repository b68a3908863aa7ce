"""Compare wgdenoise with Open Image Denoise 2.5.1 on the CPU, both with the latter's weights, for all its networks.

    python benches/peers/agreement.py --weights FOLDER --wgdenoise target/release/wgdenoise

wgdenoise loads each TZA file in the folder; Open Image Denoise runs the same network from its library, in the mode that
the file's name denotes. The pictures, all with odd sides, are the sample render, random values, and for HDR networks a
lamp in the dark. If the folder has the files for `--prefilter`, that is compared too, last. Prints a table. Exits with
1 if a difference exceeds the limits of Open Image Denoise's own regression test: a mean of |a-b|/(|a|+|b|+0.01) of
0.003, and no value that is off by more than both 0.02 and 5 %.

wgdenoise runs with `--no-skip`, as it would otherwise leave noise-free blocks unchanged. The pictures contain no broken
or outlying pixels, which it would repair.
"""

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
import pyoidn

ROOT = Path(__file__).resolve().parents[2]
QUALITIES = dict(small=pyoidn.OIDN_QUALITY_FAST, base=pyoidn.OIDN_QUALITY_BALANCED, large=pyoidn.OIDN_QUALITY_HIGH)
LAYERS = dict(color="RGB", albedo="RGB", normal="XYZ")
NAME = re.compile(r"(rt|rtlightmap)_(hdr|ldr|dir|alb|nrm)(_c?alb)?(_c?nrm)?(?:_(small|large))?")
LAMP = "lamp"
PREFILTERS = "rt_alb", "rt_nrm"
MEAN, ABSOLUTE, RELATIVE = 0.003, 0.02, 0.05


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--weights", type=Path, required=True, help="folder of TZA files")
    p.add_argument("--wgdenoise", type=Path, default=ROOT / "target/release/wgdenoise")
    p.add_argument("--render", type=Path, default=ROOT / "samples/still_life_8spp.exr", help="EXR file from Blender")
    p.add_argument("--only", default="", help="compare only files whose names contain this")
    p.add_argument("--kernels", nargs="+", default=["auto"], help="kernel sets, as in wgdenoise")
    p.add_argument("--crop", type=int, nargs=2, default=(293, 217), metavar=("W", "H"), help="crop of the render")
    return p.parse_args()


class Network:
    """A network, as described by its file name."""

    def __init__(self, path):
        found = NAME.fullmatch(path.stem)
        if not found:
            raise SystemExit(f"{path.name}: not a name of Open Image Denoise's weights")
        self.path, self.name = path, path.stem
        (filter_, self.kind, albedo, normal, size) = found.groups()
        self.filter = pyoidn.OIDN_FILTER_TYPE_RT if filter_ == "rt" else pyoidn.OIDN_FILTER_TYPE_RT_LIGHTMAP
        self.size, self.clean = size or "base", albedo == "_calb"
        self.main = {"alb": "albedo", "nrm": "normal"}.get(self.kind, "color")
        self.layers = [self.main, *(["albedo"] if albedo else []), *(["normal"] if normal else [])]

    def images(self, picture):
        """The layers of a picture, in the network's input range."""
        images = {name: picture[name] for name in self.layers}
        if self.kind == "dir":
            images["color"] = picture["normal"]
        if self.kind == "ldr":
            images["color"] = np.clip(images["color"], 0, 1)
        return images

    def oidn(self, images):
        """Open Image Denoise's result."""
        device = pyoidn.Device(pyoidn.OIDN_DEVICE_TYPE_CPU)
        device.commit()
        output = np.zeros_like(images[self.main])
        with pyoidn.Filter(device, self.filter) as f:
            for name, image in {**images, "output": output}.items():
                f.set_image(name, image, pyoidn.OIDN_FORMAT_FLOAT3)
            flags = dict(hdr=self.kind == "hdr", cleanAux=self.clean)
            flags = flags if self.filter == pyoidn.OIDN_FILTER_TYPE_RT else dict(directional=self.kind == "dir")
            for flag, value in flags.items():
                f.set_bool(flag, value)
            f.set_quality(QUALITIES[self.size])
            f.commit()
            f.execute()
        if error := device.get_error():
            raise SystemExit(f"Open Image Denoise: {error}")
        return output

    def wgdenoise(self, images, program, *options):
        """wgdenoise's result."""
        with tempfile.TemporaryDirectory() as folder:
            noisy, clean = Path(folder) / "noisy.exr", Path(folder) / "clean.exr"
            write(noisy, {"color" if name == self.main else name: image for name, image in images.items()})
            command = [program, noisy, clean, "--weights", *self.weights(), "--no-skip", "--quiet", *options]
            done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
            if done.returncode:
                raise SystemExit(f"{self.name}: {done.stderr.strip()}")
            return read(clean)["color"]

    def weights(self):
        return [self.path]


class Prefiltered(Network):
    """The network for clean albedo and normal, with the two networks that prefilter them."""

    def __init__(self, folder):
        super().__init__(folder / "rt_hdr_calb_cnrm.tza")
        self.first = [Network(folder / f"{name}.tza") for name in PREFILTERS]
        self.name = "prefiltered"

    def oidn(self, images):
        clean = {n.main: n.oidn({n.main: images[n.main]}) for n in self.first}
        return super().oidn({**images, **clean})

    def weights(self):
        return [self.path.parent, "--prefilter"]


def networks(folder, only):
    """The networks whose names contain `only`; prefiltering comes last."""
    found = [Network(path) for path in sorted(folder.glob("*.tza"))]
    if {"rt_hdr_calb_cnrm", *PREFILTERS} <= {network.name for network in found}:
        found.append(Prefiltered(folder))
    return [network for network in found if only in network.name]


def write(path, images):
    channels = {}
    for layer, image in images.items():
        prefix = "" if layer == "color" else f"{layer}."
        channels |= {prefix + axis: np.ascontiguousarray(image[..., i]) for i, axis in enumerate(LAYERS[layer])}
    OpenEXR.File(dict(compression=OpenEXR.ZIP_COMPRESSION, type=OpenEXR.scanlineimage), channels).write(str(path))


def read(path):
    """The layers of a file; from a Blender render, the noisy ones."""
    with OpenEXR.File(str(path), separate_channels=True) as f:
        planes = {name: c.pixels for part in f.parts for name, c in part.channels.items()}
    names = dict(color=("Combined", ""), albedo=("Denoising Albedo", "albedo"), normal=("Denoising Normal", "normal"))
    found = {}
    for layer, prefixes in names.items():
        for prefix in prefixes:
            channels = [next((n for n in planes if re.fullmatch(rf"(.*\.)?{prefix}\.?{axis}", n)), None)
                        for axis in LAYERS[layer]]
            if None not in channels:
                found.setdefault(layer, np.stack([planes[n] for n in channels], -1).astype(np.float32))
    return found


def pictures(o):
    """The pictures by name: the middle of the render, random values over a wide range, and a lamp of 10000 in a room of
    0.001."""
    width, height = o.crop
    render = read(o.render)
    rows, columns = render["color"].shape[:2]
    y, x = max(rows - height, 0) // 2, max(columns - width, 0) // 2
    yield "render", {n: np.ascontiguousarray(i[y:y + height, x:x + width]) for n, i in render.items()}
    random = np.random.default_rng(1)
    size = 101, 131, 3
    yield "random", dict(color=np.exp2(random.uniform(-6, 3, size)).astype(np.float32),
                         albedo=random.uniform(0, 1, size).astype(np.float32),
                         normal=random.uniform(-1, 1, size).astype(np.float32))
    dark = np.exp2(random.uniform(-11, -9, size))
    dark[20:50, 30:70] = 10000  # exceeds 65504 once exposed
    yield LAMP, dict(color=dark.astype(np.float32), albedo=np.full(size, 0.5, np.float32),
                     normal=np.full(size, 0.5, np.float32))


def differences(found, expected):
    """Mean relative difference, largest absolute difference, and number of values beyond the limits."""
    off = np.abs(found - expected)
    mean = np.mean(off / (np.abs(found) + np.abs(expected) + 0.01))
    wrong = np.sum((off > ABSOLUTE) & (off > RELATIVE * np.abs(expected)))
    return float(mean), float(off.max()), int(wrong)


def main():
    o = arguments()
    chosen = networks(o.weights, o.only)
    if not chosen:
        raise SystemExit(f"{o.weights}: no TZA files of that name; docs/weights.md says where to get them")
    print("| network | picture | kernels | precision | mean relative difference | largest difference | values off | |")
    print("| --- | --- | --- | --- | ---: | ---: | ---: | --- |")
    failed = False
    for network in chosen:
        for name, picture in pictures(o):
            if name == LAMP and network.kind != "hdr":
                continue
            images = network.images(picture)
            expected = network.oidn(images)
            for kernels in o.kernels:
                for precision in ("f32", "f16"):
                    found = network.wgdenoise(images, o.wgdenoise, "--precision", precision, "--kernels", kernels)
                    mean, largest, wrong = differences(found, expected)
                    fine = np.isfinite(found).all() and mean <= MEAN and not wrong
                    failed |= not fine
                    print(f"| {network.name} | {name} | {kernels} | {precision} | {mean:.1e} | {largest:.1e} | "
                          f"{wrong} | {'' if fine else 'too far'} |", flush=True)
    sys.exit(int(failed))


if __name__ == "__main__":
    main()
