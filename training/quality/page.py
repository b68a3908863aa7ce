"""Fills template.md, which holds all the page's text, with figures, plots and images."""

import json
from pathlib import Path
from string import Template

from quality import crops, plots, tables
from quality.store import ALL, COLOR, distinct, load, mean, ranked, select

SHOWN = "balanced"  # the tier shown in the images and in the tables of the worst and best renders
PLOT_COUNT = 8  # samples per pixel in the plot of error against cost
LISTED, LOSSES, WINS = 3, 2, 1  # renders of each test set in the tables and in the images of losses and wins


def write(docs, folders, networks, oidn, command):
    """Writes docs/quality.md and its images from the figures in docs/quality. `oidn` is the high quality mode."""
    store = docs / "quality"
    names = "errors", "views", "weights", "thesis", "precision"
    errors, views, weights, thesis, precision = (load(store / f"{n}.csv") for n in names)
    speed = speed_of(docs)
    if missing := set(distinct(errors, "set")) - folders.keys():
        raise SystemExit(f"--test: no folder for {min(missing)}, which has stored figures")
    network = next(n for n in networks if n.name == SHOWN)
    captions = _pictures(store, errors, folders, network, oidn)
    _plots(store, errors, speed, precision)
    filled = _tables(errors, views, weights) | captions | _speed_parts(speed, precision) | _thesis_parts(thesis)
    template = Template(Path(__file__).with_name("template.md").read_text())
    (docs / "quality.md").write_text(template.substitute(filled, command=command, shown=SHOWN))


def speed_of(docs):
    """The results of quality.speed, read from speed.json."""
    path = docs / "quality" / "speed.json"
    if not path.exists():
        raise SystemExit(f"{path}: no times measured yet; run `python -m quality.speed`")
    return json.loads(path.read_text())


def extremes(errors, count, worst):
    """The renders of every test set with the largest or smallest ratios."""
    order = ranked(errors, SHOWN, worst)
    return [p for name in distinct(errors, "set") for p in [p for p in order if p[1]["set"] == name][:count]]


def _pictures(store, errors, folders, network, oidn):
    """Saves the images of our worst and best renders; returns their captions."""
    chosen = dict(losses=extremes(errors, LOSSES, True), wins=extremes(errors, WINS, False))
    for name, renders in chosen.items():
        crops.save_crops(renders, folders, network, oidn, store / f"{name}.png")
    return {f"{name}_caption": "; ".join(f"{r['set']} {r['view']}, {r['spp']} sample{'s' * (r['spp'] != 1)}" for _, r in renders)
            for name, renders in chosen.items()}


def _plots(store, errors, speed, precision):
    plots.error_by_samples(errors, store / "samples.png")
    plots.error_by_cost(errors, speed, precision, PLOT_COUNT, store / "cost.png")
    plots.every_render(errors, SHOWN, store / "renders.png")


def _tables(errors, views, weights):
    full = [f"### {name}\n\n{tables.full(errors, name)}" for name in distinct(errors, "set")]
    first = errors[0]["set"]
    extreme = {n: tables.renders(errors, views, extremes(errors, LISTED, n == "worst")) for n in ("worst", "best")}
    summaries = dict(summary=("l1", ALL), summary_relmse=("relmse", ALL), summary_color=("l1", COLOR))
    return extreme | {name: tables.summary(errors, *of) for name, of in summaries.items()} | dict(
        weights=tables.weights(weights), sets=tables.sets(views, errors), full="\n\n".join(full),
        kinds=tables.kinds(errors, views, first, SHOWN), first=first)


def _speed_parts(about, precision):
    return dict(speed=tables.speed(about), precision=tables.precision(precision), processor=about["processor"],
                adapter=about["adapter"], size=about["size"], plot_count=PLOT_COUNT,
                speed_commands="\n".join(about["commands"]))


def _thesis_parts(rows):
    mine = select(rows, method=SHOWN)
    means = {n: mean(mine, n) for n in ("l1_before", "l1_after", "ssim_before", "ssim_after")}
    return dict(thesis=tables.thesis(rows), patches=len({(r["view"], r["patch"]) for r in rows}),
                **{n: f"{v:.{4 if n.startswith('l1') else 3}f}" for n, v in means.items()})
