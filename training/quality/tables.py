"""The tables of the page, as Markdown."""

import numpy as np

from quality.precision import PRECISIONS
from quality.store import ALL, FIGURES, INPUTS, LIGHT, OIDN, column, distinct, markdown, mean, select
from quality.thesis import COUNTS as THESIS_COUNTS

DIGITS = dict(l1=4, psnr=2, ssim=3, relmse=3, smape=3, light=3, highlights=3)


def weights(rows):
    lines = [[r["method"], f"`{r['file']}`", f"`{r['digest']}`", f"{r['parameters'] / 1e6:.2f} M",
              f"{r['macs'] / 1000:.1f}"] for r in rows]
    return markdown(["network", "file", "SHA-256, first 12 digits", "parameters", "kMAC per pixel"], lines)


def sets(views, errors):
    lines = []
    for name in distinct(views, "set"):
        here = select(views, set=name)
        sizes = sorted({f"{v['width']}×{v['height']}" for v in here})
        counts = sorted(distinct(select(errors, set=name), "spp"))
        relerr = np.median(column(here, "relerr"))
        lines.append([name, len(here), ", ".join(sizes), ", ".join(map(str, counts)), len(distinct(here, "kind")),
                      f"{relerr:.3f}"])
    return markdown(["test set", "views", "size", "samples", "kinds of scene", "median error of the references"], lines)


def summary(errors, figure, inputs):
    """The mean of a metric with these inputs, and in parentheses its ratio to OIDN high."""
    methods = distinct(select(errors, inputs=inputs), "method")
    lines = []
    for name in distinct(errors, "set"):
        for spp in sorted(distinct(select(errors, set=name), "spp")):
            here = select(errors, set=name, spp=spp)
            noisy = mean(select(here, method="noisy"), figure)
            lines.append([name, spp, f"{noisy:.{DIGITS[figure]}f}", *_ratios(here, methods, figure, inputs)])
    return markdown(["test set", "samples", "noisy", *methods], lines)


def _ratios(rows, methods, figure, inputs):
    means = {m: mean(select(rows, method=m, inputs=inputs), figure) for m in methods}
    return [f"{v:.{DIGITS[figure]}f} ({v / means[OIDN]:.2f})" for v in means.values()]


def full(errors, name):
    """All metrics of one test set by samples, denoiser and inputs: means, and the 95th percentile of L1."""
    lines = []
    for spp in sorted(distinct(select(errors, set=name), "spp")):
        here = select(errors, set=name, spp=spp)
        for inputs in ("", *INPUTS):
            for method in distinct(select(here, inputs=inputs), "method"):
                lines.append([spp, method, inputs, *_figures(select(here, method=method, inputs=inputs))])
    head = ["samples", "", "inputs", "renders", "L1", "L1, 95th percentile", "PSNR", "SSIM", "relative MSE", "SMAPE",
            *LIGHT]
    return markdown(head, lines)


def _figures(rows):
    l1, *others = (f"{mean(rows, n):.{DIGITS[n]}f}" for n in FIGURES + LIGHT)
    return [len(rows), l1, f"{np.percentile(column(rows, 'l1'), 95):.4f}", *others]


def renders(errors, views, chosen):
    """A table of the chosen renders, given as pairs of ratio and row."""
    kind_of = {(v["set"], v["view"]): v["kind"] for v in views}
    lines = []
    for ratio, r in chosen:
        here = select(errors, set=r["set"], view=r["view"], spp=r["spp"])
        noisy, other = select(here, method="noisy")[0], select(here, method=OIDN, inputs=ALL)[0]
        errors_of = [f"{e['l1']:.4f}" for e in (noisy, r, other)]
        lines.append([r["set"], r["view"], kind_of[r["set"], r["view"]], r["spp"], *errors_of, f"{ratio:.2f}"])
    head = ["test set", "view", "kind of scene", "samples", "noisy", chosen[0][1]["method"], OIDN, "ratio"]
    return markdown(head, lines)


def kinds(errors, views, name, method):
    """Mean L1 of one test set by kind of scene, over all counts with all inputs, worst ratio first."""
    lines = []
    measured = set(distinct(select(errors, set=name), "view"))
    for kind in distinct(select(views, set=name), "kind"):
        of_kind = {v["view"] for v in select(views, set=name, kind=kind)} & measured
        here = [r for r in select(errors, set=name) if r["view"] in of_kind]
        asked = ("noisy", ""), (method, ALL), (OIDN, ALL)
        noisy, mine, other = (mean(select(here, method=m, inputs=i), "l1") for m, i in asked)
        lines.append([kind, len(of_kind), f"{noisy:.4f}", f"{mine:.4f}", f"{other:.4f}", f"{mine / other:.2f}"])
    lines.sort(key=lambda line: -float(line[-1]))
    return markdown(["kind of scene", "views", "noisy", method, OIDN, "ratio"], lines)


def thesis(rows):
    """L1 and SSIM of each network, before and after, by sample count and over all counts."""
    methods = distinct(rows, "method")
    lines = []
    for spp in [c for c in THESIS_COUNTS if select(rows, spp=c)] + [None]:
        here = rows if spp is None else select(rows, spp=spp)
        cells = [c for m in methods for c in _before_after(select(here, method=m))[1]]
        lines.append([spp or "all", *_before_after(select(here, method=methods[0]))[0], *cells])
    head = ["samples", "L1, noisy", "SSIM, noisy", *(f"{f}, {m}" for m in methods for f in ("L1", "SSIM"))]
    return markdown(head, lines)


def _before_after(rows):
    return [[f"{mean(rows, 'l1_' + w):.4f}", f"{mean(rows, 'ssim_' + w):.3f}"] for w in ("before", "after")]


def speed(about):
    lines = [[r["method"], r["precision"] or "its own", f"{r['macs'] / 1000:.1f}", f"{r['ms']:.0f}",
              f"{min(r['rounds']):.0f} to {max(r['rounds']):.0f}"] for r in about["rows"]]
    return markdown(["", "precision", "kMAC per pixel", "ms", "minimum to maximum"], lines)


def precision(rows):
    lines = []
    for method in distinct(rows, "method"):
        single, half = (mean(select(rows, method=method, precision=p), "l1") for p in PRECISIONS)
        lines.append([method, len(distinct(rows, "view")), f"{single:.5f}", f"{half:.5f}",
                      f"{100 * (half / single - 1):+.2f} %"])
    return markdown(["network", "renders", "L1, f32", "L1, f16", "change"], lines)
