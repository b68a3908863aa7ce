"""Tables of how well a no-reference score ranks pictures, compared with SSIM."""

import itertools
from collections import defaultdict

import numpy as np

from quality.store import markdown

LEAST, PLAIN = 2, 20  # minimum SSIM difference, in points of 100, of pictures that differ at all and plainly


def spearman(a, b):
    """Spearman's rank correlation; equal values share their mean rank."""
    return float(np.corrcoef(_ranks(a), _ranks(b))[0, 1])


def _ranks(values):
    values = np.asarray(values)
    return (values[:, None] > values).sum(1) + ((values[:, None] == values).sum(1) - 1) / 2


def report(rows, regressor, clean):
    """A table with a column for each set, and for the test views with clean references."""
    for features, name in (("features", "score"), ("own", "own_score")):
        scores = regressor(np.stack([r[features] for r in rows]))
        for row, score in zip(rows, scores):
            row[name] = float(score)
    sets = {name: [r for r in rows if r["set"] == name] for name in dict.fromkeys(r["set"] for r in rows)}
    sets["test, clean references"] = [r for r in sets["test"] if r["relerr"] <= clean]
    figures = [figures_of(here) for here in sets.values()]
    return markdown(["", *sets], [[name, *(f[name] for f in figures)] for name in figures[0]])


def figures_of(rows):
    """The table's row names and values for a set."""
    target, score, own = (np.array([r[k] for r in rows]) for k in ("target", "score", "own_score"))
    views = by_view(rows).values()
    within = [spearman([r["target"] for r in v], [r["score"] for r in v]) for v in views]
    return {
        "views": len(views),
        "pictures": len(rows),
        "rank correlation with SSIM": f"{spearman(target, score):.2f}",
        "rank correlation within a view, mean": f"{np.mean(within):.2f}",
        f"renders of a view that SSIM tells apart by {LEAST} points": _share(seen_pairs(rows, LEAST)),
        f"renders of a view that SSIM tells apart by {PLAIN} points": _share(seen_pairs(rows, PLAIN)),
        "denoised better than noisy": _share(cleaned(rows)),
        "SSIM says so": _share(cleaned(rows, "target")),
        "noisy: more samples better": _share(more_samples(rows, ["noisy"])),
        "denoised: more samples better": _share(more_samples(rows, denoisers(rows))),
        "reference better than denoised": _share(references(rows)),
        "root mean square error": f"{np.sqrt(np.mean((target - score) ** 2)):.1f}",
        "mean change at the picture's own exposure": f"{np.mean(abs(own - score)):.1f}",
    }


def _share(outcomes):
    return f"{100 * np.mean(outcomes):.0f} % of {len(outcomes)}" if outcomes else "–"


def by_view(rows):
    views = defaultdict(list)
    for row in rows:
        views[row["view"]].append(row)
    return views


def denoisers(rows):
    return [m for m in dict.fromkeys(r["method"] for r in rows) if m not in ("noisy", "reference")]


def seen_pairs(rows, least):
    """Whether the score orders pairs of a view's renders like SSIM, for pairs that SSIM separates by `least` points."""
    return [(a["score"] < b["score"]) == (a["target"] < b["target"])
            for view in by_view(rows).values()
            for a, b in itertools.combinations([r for r in view if r["method"] != "reference"], 2)
            if abs(a["target"] - b["target"]) >= least]


def cleaned(rows, score="score"):
    """Whether each denoised render scores better than its noisy input."""
    noisy = {(r["view"], r["spp"]): r[score] for r in rows if r["method"] == "noisy"}
    return [r[score] < noisy[r["view"], r["spp"]] for r in rows if r["method"] in denoisers(rows)]


def more_samples(rows, methods):
    """Whether the render with more samples scores better, for pairs of the same view and method."""
    return [(a["score"] < b["score"]) == (a["spp"] > b["spp"])
            for view in by_view(rows).values() for method in methods
            for a, b in itertools.combinations([r for r in view if r["method"] == method], 2)]


def references(rows):
    """Whether the reference scores better than each denoised render."""
    best = {r["view"]: r["score"] for r in rows if r["method"] == "reference"}
    return [best[r["view"]] < r["score"] for r in rows if r["method"] in denoisers(rows)]
