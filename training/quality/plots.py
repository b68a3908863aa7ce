"""The page's plots, as small PNG files."""

from collections import defaultdict

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.ticker import LogLocator, NullLocator

from quality.store import ALL, COLOR, OIDN, distinct, mean, select

COLORS = {"noisy": "0.6", "fast": "tab:orange", "balanced": "tab:red", "high": "tab:purple",
           "OIDN fast": "lightsteelblue", "OIDN balanced": "cornflowerblue", OIDN: "tab:blue"}
COLORS = defaultdict(lambda: "black", COLORS)  # other nets
MARKERS = "osD^v"


def error_by_samples(errors, path):
    """One panel per test set: mean L1 over samples; solid lines for all inputs, dashed for color alone."""
    names = distinct(errors, "set")
    figure, panels = plt.subplots(1, len(names), figsize=(4 * len(names), 3.6), sharey=True, squeeze=False,
                                  layout="constrained")
    for panel, name in zip(panels[0], names):
        here = select(errors, set=name)
        for method in distinct(here, "method"):
            _lines(panel, select(here, method=method), method)
        counts = sorted(distinct(here, "spp"))
        panel.set(title=name, xscale="log", yscale="log", xlabel="samples per pixel")
        _plain(panel.yaxis)
        panel.set_xticks(counts, counts, minor=False)
        panel.xaxis.set_minor_locator(NullLocator())
        panel.grid(alpha=0.3)
    panels[0, 0].set_ylabel("mean display L1")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=7)
    _save(figure, path)


def _lines(panel, rows, method):
    for inputs, style in (("", ":"), (ALL, "-"), (COLOR, "--")):
        chosen = select(rows, inputs=inputs)
        counts = sorted(distinct(chosen, "spp"))
        label = None if inputs == COLOR else method
        if chosen:
            panel.plot(counts, [mean(select(chosen, spp=c), "l1") for c in counts], style, marker=".", lw=1.2,
                       color=COLORS[method], label=label)


def error_by_cost(errors, speed, precision, count, path):
    """Mean L1 of the first test set at `count` samples, against multiply-adds and against milliseconds.

    For half precision, the full-precision error is scaled by the ratio that the program's own runs measured.
    """
    rows = select(errors, set=errors[0]["set"], spp=count, inputs=ALL)
    figure, panels = plt.subplots(1, 2, figsize=(9.6, 3.8), sharey=True, layout="constrained")
    for point in speed["rows"]:
        error = mean(select(rows, method=point["method"]), "l1") * half_ratio(precision, point)
        look = dict(marker="o" if point["precision"] == "f16" else "s", color=COLORS[point["method"]], ls="")
        label = f"{point['method']} {point['precision']}"
        panels[0].plot(point["macs"] / 1000, error, **look)
        panels[1].plot(point["ms"], error, label=label, **look)
    panels[0].set(xlabel="1000 multiply-adds per pixel", ylabel=f"mean display L1 at {count} samples")
    panels[1].set(xlabel=f"milliseconds, {speed['size']} pixels")
    for panel in panels:
        panel.set_xscale("log")
        _plain(panel.xaxis)
        panel.grid(alpha=0.3)
    figure.legend(fontsize=8, loc="outside right center")
    _save(figure, path)


def half_ratio(precision, point):
    """The error at the point's precision, relative to full precision."""
    if not point["precision"]:
        return 1.0
    of = [mean(select(precision, method=point["method"], precision=p), "l1")
          for p in (point["precision"], "f32")]
    return of[0] / of[1]


def every_render(errors, method, path):
    """One point per test render with all inputs: L1 of OIDN high on x, of `method` on y."""
    figure, panel = plt.subplots(figsize=(5.2, 4.8), layout="constrained")
    for name, marker in zip(distinct(errors, "set"), MARKERS * 3):
        here = select(errors, set=name, inputs=ALL)
        mine, other = select(here, method=method), select(here, method=OIDN)
        panel.plot([r["l1"] for r in other], [r["l1"] for r in mine], marker, ms=3, alpha=0.6, label=name)
    low, high = panel.get_xlim()
    panel.plot([low, high], [low, high], "k-", lw=0.8)
    panel.set(xscale="log", yscale="log", xlabel=f"display L1, {OIDN}", ylabel=f"display L1, {method}")
    _plain(panel.xaxis)
    _plain(panel.yaxis)
    panel.grid(alpha=0.3)
    panel.legend(fontsize=7)
    _save(figure, path)


def before_after(rows, inputs, path):
    """One point per row of evaluate.py with these inputs: L1 of the noisy render on x, of the denoised one on y."""
    chosen = select(rows, inputs=inputs)
    figure, panel = plt.subplots(figsize=(5.2, 4.8), layout="constrained")
    for spp in sorted(distinct(chosen, "spp")):
        here = select(chosen, spp=spp)
        panel.plot([r["noisy_l1"] for r in here], [r["denoised_l1"] for r in here], ".", label=f"{spp} samples")
    panel.axline((0.01, 0.01), (0.1, 0.1), color="k", lw=0.8)
    panel.set(xscale="log", yscale="log", xlabel="display L1, noisy", ylabel="display L1, denoised")
    panel.grid(alpha=0.3)
    panel.legend(fontsize=7)
    _save(figure, path)


def _plain(axis):
    """Labels a logarithmic axis with plain numbers at 1, 2, 5, 10, ..."""
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set_minor_locator(NullLocator())


def _save(figure, path):
    figure.savefig(path, dpi=90, metadata=dict(Software=None))
    plt.close(figure)
