"""Fit the regressor of BRISQUE to our renders, write it for crates/metrics, and print how well it ranks test renders.

    python -m quality.brisque --views DIR --test NAME=DIR [NAME=DIR ...] --weights ../weights/*.safetensors

DIR holds rendered views (*_v*.npz): those of --views are split by scene, see views.py; those of --test are used for
testing only. A view's pictures are its reference, its noisy renders, and these denoised with each weights file, all at
the reference's display exposure. A picture's target score is 100 (1 - SSIM) against its reference: 0 for the reference,
and up to 100. SSIM also drops if the *reference* is noisy, which the picture does not show, so the fit uses only views
whose reference has an estimated relative error of at most 0.06. Training pictures fit the regressor, validation
pictures select it. --stored FILE keeps the measurements, or reads them if it exists.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import torch
from safetensors.numpy import save_file

from metrics import display, exposure_of, figures
from quality import harm
from quality.measure import paths_of
from quality.networks import load_all
from quality.ranking import report
from quality.rbf import fit, rust
from quality.scene_statistics import features
from quality.store import ALL, INPUTS
from views import SPLIT, part, read_view

CLEAN = 0.06  # maximum estimated relative error of references used for the fit
REFERENCE, NOISY = "reference", "noisy"


def arguments():
    p = argparse.ArgumentParser(prog="python -m quality.brisque", description=__doc__,
                                formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--views", type=Path, required=True)
    p.add_argument("--test", nargs="*", default=[], metavar="NAME=DIR")
    p.add_argument("--weights", nargs="+", required=True, help="weights files")
    p.add_argument("--stored", type=Path, help="measurements, .npy")
    p.add_argument("--crate", type=Path, default=Path("../crates/metrics"))
    p.add_argument("--threads", type=int, default=1)
    return p.parse_args()


def part_of(scene):
    return next(name for name in SPLIT if part([dict(scene=scene)], name))


@torch.no_grad()
def measure(name, folder, networks):
    """Rows for all pictures in a folder. `name` is a test set's; None splits the views by scene."""
    for path in paths_of(folder):
        view = read_view(path)
        of_set = name or part_of(view["scene"])
        if of_set not in ("train", "val") or view["relerr"] <= CLEAN:
            print(f"{of_set}: {path.stem}", file=sys.stderr, flush=True)
            about = dict(set=of_set, view=view["name"], relerr=view["relerr"])
            yield from (about | row for row in _pictures(view, networks))


def _pictures(view, networks):
    """The figures of a view's pictures. `own` holds the features at the picture's own exposure."""
    ref = view["ref"][:3].float()
    scale = exposure_of(ref)
    for method, spp, color in [(REFERENCE, 0, ref), *_renders(view, networks)]:
        shown, own = display(color * scale), display(color * exposure_of(color))
        yield dict(method=method, spp=spp, target=100 * (1 - max(figures(color, ref)["ssim"], 0)),
                   features=features(shown.numpy()), own=features(own.numpy()))


def _renders(view, networks):
    for spp, image in view["noisy"]:
        yield NOISY, spp, image[:3].float()
        yield from ((n.name, spp, n(image, INPUTS[ALL])) for n in networks)


def measured(o):
    """All rows, from the stored file if it exists."""
    if o.stored and o.stored.exists():
        return list(np.load(o.stored, allow_pickle=True))
    networks = load_all(o.weights)
    tests = [(name, folder) for name, _, folder in (t.partition("=") for t in o.test)]
    rows = [row for name, folder in [(None, o.views), *tests] for row in measure(name, folder, networks)]
    if o.stored:
        np.save(o.stored, np.array(rows, dtype=object))
    return rows


def columns(rows, of_set):
    """Features and target scores of the pictures in a set."""
    rows = [r for r in rows if r["set"] == of_set]
    return np.stack([r["features"] for r in rows]), np.array([r["target"] for r in rows])


def pictures():
    """Linear pictures [3,H,W] for the fixture: noise, and edges with even areas and missing pixels on odd sides."""
    g = torch.Generator().manual_seed(1)
    noise = torch.randn(3, 24, 20, generator=g).exp()
    edges = torch.full((3, 31, 33), 0.2)
    edges[:, 10:, 5:20], edges[1, :, 25:] = 0.7, 1.5
    edges += 0.02 * torch.randn(3, 31, 33, generator=g) * (torch.arange(31)[:, None] > 15)
    edges[0, 3, 4], edges[2, 20, 7] = torch.nan, torch.inf
    smooth = torch.linspace(0, 1, 40).outer(torch.linspace(0.5, 2, 18)).sin().expand(3, 40, 18)
    return dict(noise=noise, edges=edges, smooth=smooth.contiguous())


def fixture(regressor, exposure=0.75):
    """Pictures, their features and scores at this exposure, in float64."""
    tensors = dict(exposure=np.array([exposure]))
    for name, color in pictures().items():
        shown = display(torch.where(color.isfinite(), color, 0).double() * exposure)
        found = features(shown.numpy())
        tensors |= {name: color.numpy(), f"{name}.features": found, f"{name}.score": regressor(found[None])}
    return tensors


def main():
    o = arguments()
    torch.set_num_threads(o.threads)
    rows = measured(o)
    regressor, error = fit(*columns(rows, "train"), *columns(rows, "val"))
    (o.crate / "src/brisque/table.rs").write_text(rust(regressor))
    save_file(fixture(regressor), o.crate / "tests/brisque.safetensors")
    print(f"{len(regressor.centers)} centers, gamma {regressor.gamma}; validation error {error:.1f}\n")
    print(report(rows, regressor, CLEAN), end="\n\n")
    clean = {r["view"] for r in rows if r["set"] == "test" and r["relerr"] <= CLEAN}
    print(harm.report(o.views, clean, regressor))


if __name__ == "__main__":
    main()
