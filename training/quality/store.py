"""Rows of figures in CSV files, the queries that the page needs, and Markdown tables of them."""

import csv

import numpy as np

FIGURES = ("l1", "psnr", "ssim", "relmse", "smape")
LIGHT = ("light", "highlights")  # shares of the reference's light
COLOR, ALL = "color", "all"
INPUTS = {COLOR: "color", ALL: "color,albedo,normal"}  # name on the page to the inputs of a denoiser
TEXT = "set", "view", "kind", "method", "inputs", "precision", "file", "digest"  # text columns; others are numbers
OIDN = "OIDN high"  # the baseline of all ratios


def save(path, rows, digits=4):
    """Saves rows, rounding figures to `digits`; the default keeps more than are significant."""
    with open(path, "w", newline="") as f:
        writer = csv.DictWriter(f, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows({k: f"{v:.{digits}g}" if isinstance(v, float) else v for k, v in r.items()} for r in rows)


def load(path):
    if not path.exists():
        raise SystemExit(f"{path}: missing; run without --stored to measure")
    with open(path, newline="") as f:
        return [{k: v if k in TEXT else _number(v) for k, v in r.items()} for r in csv.DictReader(f)]


def same_weights(path, networks):
    """Ends the program unless the stored figures belong to these networks."""
    if {r["digest"] for r in load(path)} != {n.digest for n in networks}:
        raise SystemExit(f"{path}: the stored figures belong to other weights; run without --stored")


def _number(text):
    return int(text) if text.isdigit() else float(text)


def select(rows, **wanted):
    return [r for r in rows if all(r[k] == v for k, v in wanted.items())]


def distinct(rows, name):
    """The distinct values of a column, in order of first appearance."""
    return list(dict.fromkeys(r[name] for r in rows))


def column(rows, name):
    return np.array([r[name] for r in rows], float)


def mean(rows, name):
    return float(column(rows, name).mean())


def markdown(head, lines):
    """A Markdown table; `head` and each line are lists of cells."""
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in rows)


def ranked(rows, name, worst=True):
    """Renders with all inputs as pairs: the L1 ratio of denoiser `name` to OIDN high, and the row of `name`.

    Sorted by ratio, largest first if `worst`, else smallest first; each view appears once, at its extreme count.
    """
    others = {_render(r): r["l1"] for r in select(rows, method=OIDN, inputs=ALL)}
    pairs = [(r["l1"] / others[_render(r)], r) for r in select(rows, method=name, inputs=ALL)]
    of_view = {}
    for ratio, row in sorted(pairs, key=lambda p: p[0], reverse=worst):
        of_view.setdefault((row["set"], row["view"]), (ratio, row))
    return list(of_view.values())


def _render(row):
    return row["set"], row["view"], row["spp"]
