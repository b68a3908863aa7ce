"""Measure the shipped weights and Open Image Denoise on test renders and write docs/quality.md.

    python -m quality --test Cycles=DIR --test LuxCore=DIR --test "Mitsuba, Gaussian filter"=DIR \\
        --weights ../weights/*.safetensors

Measures every view (*_v*.npz) in the folders, which must hold renders that training never saw. The first test set also
runs the thesis's protocol, and half precision through the program. The figures are stored in docs/quality; --stored
rebuilds the page and images from them. Run `python -m quality.speed` first: it measures the times.
"""

import argparse
import sys
from pathlib import Path

import torch

from quality import measure, page, precision, store, thesis
from quality.networks import load_all
from quality.oidn import QUALITIES, Oidn, PrefilteredOidn
from quality.store import ALL, INPUTS


def arguments():
    p = argparse.ArgumentParser(prog="python -m quality", description=__doc__,
                                formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--test", action="append", required=True, metavar="NAME=DIR", help="test set; the first is the main")
    p.add_argument("--weights", nargs="+", required=True, help="weights files")
    p.add_argument("--program", type=Path, default=Path("../target/release/wgdenoise"))
    p.add_argument("--program-views", type=int, default=8, help="number of renders for half precision")
    p.add_argument("--docs", type=Path, default=Path("../docs"))
    p.add_argument("--stored", action="store_true", help="rewrite the page from the stored figures")
    p.add_argument("--threads", type=int, default=1)
    return p.parse_args()


def folders_of(tests):
    folders = {}
    for test in tests:
        name, _, folder = test.partition("=")
        if not (name and folder):
            raise SystemExit(f"--test {test}: expected NAME=DIR")
        folders[name] = Path(folder)
    return folders


def measure_all(o, folders, networks, oidn, out):
    """Measures and stores all figures except the times."""
    out.mkdir(parents=True, exist_ok=True)
    first = next(iter(folders.values()))
    store.save(out / "weights.csv", [n.row() for n in networks])
    store.save(out / "precision.csv", precision.measure(o.program, first, networks, o.program_views), digits=6)
    store.save(out / "thesis.csv", thesis.measure(first, networks))
    store.save(out / "views.csv", [row for test in folders.items() for row in measure.describe(*test)])
    denoisers = dict.fromkeys([*networks, *oidn], INPUTS) | {PrefilteredOidn("high", o.threads): {ALL: INPUTS[ALL]}}
    store.save(out / "errors.csv", [row for test in folders.items() for row in measure.measure(*test, denoisers)])


def main():
    o = arguments()
    torch.set_num_threads(o.threads)
    folders = folders_of(o.test)
    networks = load_all(o.weights)
    if page.SHOWN not in [n.name for n in networks]:
        raise SystemExit(f"--weights: the page needs the weights of `{page.SHOWN}`")
    oidn = [Oidn(q, o.threads) for q in QUALITIES]
    page.speed_of(o.docs)  # fails now, not after the measurements, if the times are missing
    if o.stored:
        store.same_weights(o.docs / "quality" / "weights.csv", networks)
    else:
        measure_all(o, folders, networks, oidn, o.docs / "quality")
    tests = " ".join(f'--test "{name}=DIR"' for name in folders)
    page.write(o.docs, folders, networks, oidn[-1], f"python -m quality {tests} --weights ../weights/*.safetensors")
    print(f"{o.docs / 'quality.md'} written", file=sys.stderr)


if __name__ == "__main__":
    main()
