"""Errors of a trained network on the test scenes, which neither training nor early stopping saw.

    python evaluate.py RUN/best.pt --data VIEWS [VIEWS ...] --csv errors.csv --images pictures

Denoises every render of every test view with color alone, with albedo, and with albedo and normal. The table gives
means over renders by sample count, noisy -> denoised; `ratio` is the group's denoised L1 over its noisy L1. An image
per render shows, with all inputs, the noisy render, our result, Open Image Denoise's, and the reference.
"""

import argparse
from pathlib import Path

import torch

from inference import denoise
from metrics import figures
from model import network_for
from quality.store import FIGURES, mean, save
from run import load_checkpoint
from views import load_views, part

INPUTS = ("color", "color,albedo", "color,albedo,normal")
GROUPS = ((1, 3), (4, 7), (8, 15), (16, 31), (32, 63), (64, 127), (128, 9999))  # samples per pixel, first and last


def load_model(path):
    """A checkpoint's EMA network in evaluation mode, and the checkpoint itself."""
    checkpoint = load_checkpoint(path)
    model = network_for(checkpoint["topology"], checkpoint["widths"], checkpoint["ema"])
    model.load_state_dict(checkpoint["ema"])
    return model.eval(), checkpoint


def measure(model, views):
    """One row per render and set of inputs: view, kind, spp, inputs, then each metric as noisy_* and denoised_*."""
    rows = []
    for v in views:
        ref = v["ref"][:3].float()
        for spp, image in v["noisy"]:
            before = figures(image[:3].float(), ref)
            for inputs in INPUTS:
                after = figures(denoise(model, image, inputs), ref)
                row = dict(view=v["name"], kind=v["kind"], relerr=round(v["relerr"], 3), spp=spp, inputs=inputs)
                for name in FIGURES:
                    row |= {f"noisy_{name}": before[name], f"denoised_{name}": after[name]}
                rows.append(row)
    return rows


def table(rows):
    """A Markdown table of the group means."""
    lines = ["| samples | renders | inputs | L1 | ratio | PSNR | SSIM | relMSE | SMAPE |", "|---|---|---|---|---|---|---|---|---|"]
    for low, high in GROUPS:
        for inputs in INPUTS:
            chosen = [r for r in rows if low <= r["spp"] <= high and r["inputs"] == inputs]
            if chosen:
                lines.append(_line(f"{low}–{high}", inputs, chosen))
    return "\n".join(lines)


def _line(group, inputs, rows):
    digits = dict(l1=4, psnr=2, ssim=3, relmse=3, smape=3)
    cells = [f"{mean(rows, 'noisy_' + n):.{d}f} → {mean(rows, 'denoised_' + n):.{d}f}" for n, d in digits.items()]
    ratio = mean(rows, "denoised_l1") / mean(rows, "noisy_l1")
    return f"| {group} | {len(rows)} | {inputs} | {cells[0]} | {ratio:.3f} | {' | '.join(cells[1:])} |"


def save_images(model, views, folder):
    """Saves a PNG per render. Only this needs the packages of the comparison."""
    from quality.crops import save_png, strip
    from quality.oidn import Oidn
    oidn = Oidn("high", torch.get_num_threads())
    folder.mkdir(parents=True, exist_ok=True)
    for v in views:
        ref = v["ref"][:3].float()
        for spp, image in v["noisy"]:
            images = [image[:3].float(), denoise(model, image), oidn(image, INPUTS[-1]), ref]
            save_png(folder / f"{v['name']}_{spp}spp.png", strip(images, ref))


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("checkpoint", type=Path)
    p.add_argument("--data", nargs="+", required=True, help="folders of views")
    p.add_argument("--cache", help="folder for decoded views")
    p.add_argument("--csv", type=Path, help="file for the errors of every render")
    p.add_argument("--images", type=Path, help="folder for an image of every render")
    p.add_argument("--plot", type=Path, help="file for a plot of all errors before and after")
    p.add_argument("--part", default="test", choices=("val", "test"))
    p.add_argument("--max-relerr", type=float, default=float("inf"), help="skip views with a noisier reference")
    p.add_argument("--threads", type=int, default=1)
    o = p.parse_args()
    torch.set_num_threads(o.threads)
    model, checkpoint = load_model(o.checkpoint)
    views = [v for v in part(load_views(o.data, o.cache), o.part) if v["relerr"] <= o.max_relerr]
    if not views:
        raise SystemExit(f"no views of {o.part} scenes in these folders: add scenes or use --part val")
    with torch.no_grad():
        rows = measure(model, views)
        if o.images:
            save_images(model, views, o.images)
    if o.csv:
        save(o.csv, rows)
    if o.plot:
        from quality.plots import before_after
        before_after(rows, INPUTS[-1], o.plot)
    print(f"{checkpoint['tier']}: {len(views)} views of {o.part} scenes\n\n{table(rows)}")


if __name__ == "__main__":
    main()
