"""Errors of a trained net on the held-out test scenes, which neither training nor early stopping saw.

    python evaluate.py RUN/best.pt --data VIEWS [VIEWS ...] --csv errors.csv

Every render of every test view is denoised with colour alone, with albedo, and with albedo and normal. The table
gives means over renders by sample count, noisy -> denoised; `ratio` is denoised L1 over noisy L1 of the group.
"""

import argparse
import csv
from pathlib import Path

import torch

from metrics import figures
from model import UNet
from train import denoise
from views import load_views, part

INPUTS = ("color", "color,albedo", "color,albedo,normal")
GROUPS = (("1-2", 1, 2), ("4-32", 4, 32), ("4", 4, 4), ("8", 8, 8), ("16-32", 16, 32), ("64", 64, 64))
NAMES = ("l1", "psnr", "ssim", "relmse", "smape")


def load_model(path):
    """The EMA network of a checkpoint, in evaluation mode, and the checkpoint itself."""
    checkpoint = torch.load(path)
    model = UNet(checkpoint["widths"])
    model.load_state_dict(checkpoint["ema"])
    return model.eval(), checkpoint


def measure(model, views):
    """One row per render and inputs: view, kind, spp, inputs, then every figure as noisy_* and denoised_*."""
    rows = []
    for v in views:
        ref = v["ref"][:3].float()
        for spp, image in v["noisy"]:
            before = figures(image[:3].float(), ref)
            for inputs in INPUTS:
                after = figures(denoise(model, image, inputs), ref)
                row = dict(view=v["name"], kind=v["kind"], relerr=round(v["relerr"], 3), spp=spp, inputs=inputs)
                for name in NAMES:
                    row |= {f"noisy_{name}": before[name], f"denoised_{name}": after[name]}
                rows.append(row)
    return rows


def table(rows):
    """Markdown table of the group means."""
    lines = ["| samples | renders | inputs | L1 | ratio | PSNR | SSIM | relMSE | SMAPE |", "|---|---|---|---|---|---|---|---|---|"]
    for group, low, high in GROUPS:
        for inputs in INPUTS:
            chosen = [r for r in rows if low <= r["spp"] <= high and r["inputs"] == inputs]
            if chosen:
                lines.append(_line(group, inputs, chosen))
    return "\n".join(lines)


def _line(group, inputs, rows):
    mean = {k: sum(r[k] for r in rows) / len(rows) for k in rows[0] if k.startswith(("noisy_", "denoised_"))}
    digits = dict(l1=4, psnr=2, ssim=3, relmse=3, smape=3)
    cells = {n: f"{mean['noisy_' + n]:.{d}f} → {mean['denoised_' + n]:.{d}f}" for n, d in digits.items()}
    ratio = mean["denoised_l1"] / mean["noisy_l1"]
    others = " | ".join(cells[n] for n in NAMES[1:])
    return f"| {group} | {len(rows)} | {inputs} | {cells['l1']} | {ratio:.3f} | {others} |"


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("checkpoint", type=Path)
    p.add_argument("--data", nargs="+", required=True, help="folders of views")
    p.add_argument("--cache", help="file that keeps the decoded views")
    p.add_argument("--csv", type=Path, help="errors of every render")
    p.add_argument("--part", default="test", choices=("val", "test"))
    p.add_argument("--max-relerr", type=float, default=float("inf"), help="leave out views with a noisier reference")
    p.add_argument("--threads", type=int, default=1)
    o = p.parse_args()
    torch.set_num_threads(o.threads)
    model, checkpoint = load_model(o.checkpoint)
    views = [v for v in part(load_views(o.data, o.cache), o.part) if v["relerr"] <= o.max_relerr]
    with torch.no_grad():
        rows = measure(model, views)
    if o.csv:
        with open(o.csv, "w", newline="") as f:
            writer = csv.DictWriter(f, rows[0])
            writer.writeheader()
            writer.writerows(rows)
    print(f"{checkpoint['tier']}, step {checkpoint['step']}: {len(views)} views of the {o.part} scenes\n\n{table(rows)}")


if __name__ == "__main__":
    main()
