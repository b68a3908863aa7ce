"""Average the networks of one run and its continuations, which denoises unseen scenes better than the last one alone.

    python average.py mine.safetensors first.safetensors=0.35 RUN/last.pt=0.65

Works only if one was trained from the other, or all from the same weights (Izmailov et al., "Averaging Weights Leads to
Wider Optima and Better Generalization", 2018). The shares are normalized to sum to 1.
"""

import argparse
from os.path import commonprefix
from pathlib import Path

from export import DATA, provenance, save_weights
from run import load_checkpoint


def share(text):
    """Parses `FILE=SHARE` to the file and its share."""
    path, _, number = text.rpartition("=")
    try:
        value = float(number)
    except ValueError:
        value = 0.0
    if not path or not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text}: expected FILE=SHARE with a share above 0")
    return Path(path), value


def _form(checkpoint):
    return checkpoint["topology"], tuple(checkpoint["widths"]), {k: v.shape for k, v in checkpoint["ema"].items()}


def _history(histories, shares):
    """The steps that all networks share, then each network's further training."""
    shared = commonprefix(histories)
    further = ["; then ".join(history[len(shared):]) for history in histories]
    parts = [f"{s:.0%} after ({steps})" if steps else f"{s:.0%} of these" for s, steps in zip(shares, further)]
    return [*shared, "the average of " + " and ".join(parts)]


def average(checkpoints, shares):
    """A checkpoint with the weighted means of the others' weights and statistics."""
    first = checkpoints[0]
    for other in checkpoints[1:]:
        if _form(other) != _form(first):
            raise SystemExit("the networks differ in topology, widths or demodulation: only those of one form can be averaged")
    shares = [s / sum(shares) for s in shares]
    names = [k for k, v in first["ema"].items() if v.is_floating_point()]
    ema = {k: sum(s * c["ema"][k].float() for s, c in zip(shares, checkpoints)) for k in names}
    return dict(first, ema=ema, history=_history([c["history"] for c in checkpoints], shares))


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("weights", type=Path, help="the weights file to write")
    p.add_argument("networks", type=share, nargs="+", metavar="FILE=SHARE", help="checkpoints or weights files")
    p.add_argument("--data", default=DATA, help="description of the training data, for the provenance entry")
    p.add_argument("--license", default="MIT OR Apache-2.0", help="license of the weights, for the provenance entry")
    o = p.parse_args()
    c = average([load_checkpoint(path) for path, _ in o.networks], [s for _, s in o.networks])
    save_weights(o.weights, c["ema"], c["topology"], c["widths"], c["tier"], provenance(c, o))
    print(f"{o.weights}: {c['history'][0]}")


if __name__ == "__main__":
    main()
