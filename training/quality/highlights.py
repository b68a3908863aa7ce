"""Measures how the repair of outliers (transfer.repair) affects renders and their highlights.

    python -m quality.highlights WEIGHTS FOLDER [FOLDER ...]

For the renders (*_v*.npz) in the folders, by samples per pixel, prints the share of darkened pixels, and the denoised
image's error and highlights with and without the repair. Highlights are the light in the reference's brightest 1 % of
pixels, relative to the reference. Also prints how much of that light the converged references keep.
"""

import math
import sys
from pathlib import Path

from metrics import figures
from quality.networks import Network
from quality.store import ALL, INPUTS
from transfer import autoexposure, luminance, repair
from views import read_view


def main():
    if len(sys.argv) < 3:
        raise SystemExit(__doc__)
    net, rows, kept = Network(sys.argv[1]), {}, []
    for path in sorted(p for folder in sys.argv[2:] for p in Path(folder).glob("*_v*.npz")):
        view = read_view(path)
        reference = view["ref"][:3].float()
        bright = brightest(reference)
        repaired, _ = repair(reference, autoexposure(reference), net.model.outlier)
        kept.append(light(repaired, bright) / light(reference, bright))
        for samples, image in view["noisy"]:
            rows.setdefault(samples, []).append(measure(net, image, reference, bright))
    print("| samples | darkened | L1 | with repair | relMSE | with repair | light | with repair |\n" + "|---" * 8 + "|")
    for samples, measured in sorted(rows.items()):
        means = [sum(column) / len(measured) for column in zip(*measured)]
        print(f"| {samples} | {means[0]:.1e} | " + " | ".join(f"{m:.4f}" for m in means[1:]) + " |")
    print(f"references keep {sum(kept) / len(kept):.4f} of the light, at least {min(kept):.4f}, in {len(kept)} views")


def brightest(reference):
    bright = luminance(reference)
    return bright >= bright.flatten().kthvalue(int(0.99 * bright.numel())).values


def light(image, pixels):
    return float(luminance(image)[pixels].sum())


def measure(net, image, reference, bright):
    color = image[:3].float()
    limit, results = net.model.outlier, []
    darkened = luminance(repair(color, autoexposure(color), limit)[0]) < 0.999 * luminance(color)
    for net.model.outlier in (math.inf, limit):
        result = net(image, INPUTS[ALL])
        found = figures(result, reference)
        results.append((found["l1"], found["relmse"], light(result, bright) / light(reference, bright)))
    return [float(darkened.float().mean()), *(figure for pair in zip(*results) for figure in pair)]


if __name__ == "__main__":
    main()
