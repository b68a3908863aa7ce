"""Train one tier of the network within a given time.

    python train.py balanced --data VIEWS [VIEWS ...] --out RUN --minutes 90

The one-cycle learning rate follows elapsed training time, not steps, so the run ends well annealed on a machine
of any speed or load. RUN receives last.pt (to --resume), best.pt (EMA weights best on the validation scenes),
which export.py and evaluate.py read, and log.csv.
"""

import argparse
import copy
import math
import time
from pathlib import Path

import torch

from augment import Crops
from metrics import figures, loss
from model import TIERS, UNet, parameter_count
from transfer import autoexposure, inverse, network_input
from views import load_views, part


class Ema:
    """Exponential moving average of weights and batch norm statistics; its span grows with the steps up to `decay`."""

    def __init__(self, model, decay):
        self.model, self.decay = copy.deepcopy(model).eval().requires_grad_(False), decay

    @torch.no_grad()
    def update(self, model, step):
        decay = min(self.decay, (1 + step) / (10 + step))
        for mine, other in zip(self.model.state_dict().values(), model.state_dict().values()):
            if mine.is_floating_point():
                mine.lerp_(other, 1 - decay)


def one_cycle(progress, warmup=0.05, floor=0.002):
    """Factor of the peak learning rate at `progress` 0..1: linear warm-up, then cosine to the floor."""
    if progress < warmup:
        return max(progress / warmup, 0.02)
    return floor + (1 - floor) * 0.5 * (1 + math.cos(math.pi * (progress - warmup) / (1 - warmup)))


@torch.no_grad()
def denoise(model, image, inputs="color,albedo,normal"):
    """Linear colour [3,H,W] of a whole render [9,H,W] through the same steps as the product."""
    color, albedo, normal = image.float().split(3)
    scale = autoexposure(color)
    x = network_input(color, albedo if "albedo" in inputs else None, normal if "normal" in inputs else None, scale)
    m = 2**model.levels
    h, w = x.shape[1:]
    x = torch.nn.functional.pad(x[None], (0, -w % m, 0, -h % m), mode="replicate")
    return inverse(model(x.contiguous(memory_format=torch.channels_last))[0, :, :h, :w]) / scale


def validate(model, views):
    """Mean display L1 of denoised over mean display L1 of noisy, renders of 4 to 32 samples with all inputs."""
    noisy = denoised = 0.0
    for v in views:
        ref = v["ref"][:3].float()
        for spp, image in v["noisy"]:
            if 4 <= spp <= 32:
                noisy += figures(image[:3].float(), ref)["l1"]
                with torch.autocast("cpu", torch.bfloat16):
                    denoised += figures(denoise(model, image), ref)["l1"]
    return denoised / noisy


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("tier", choices=TIERS)
    p.add_argument("--data", nargs="+", required=True, help="folders of views")
    p.add_argument("--out", type=Path, required=True, help="folder of the run")
    p.add_argument("--cache", help="file that keeps the decoded views")
    p.add_argument("--minutes", type=float, default=90, help="training time the schedule is fitted to")
    p.add_argument("--lr", type=float, default=2e-3, help="peak learning rate")
    p.add_argument("--weight-decay", type=float, default=1e-2)
    p.add_argument("--batch", type=int, default=16)
    p.add_argument("--crop", type=int, default=128)
    p.add_argument("--validate", type=float, default=5, help="minutes between validations and checkpoints")
    p.add_argument("--patience", type=int, default=12, help="stop after so many validations without a new best")
    p.add_argument("--threads", type=int, default=1)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--resume", action="store_true")
    p.add_argument("--tensorboard", action="store_true")
    return p.parse_args()


class Run:
    """Model, optimiser, EMA and the progress that a checkpoint has to bring back."""

    def __init__(self, o):
        self.o, self.last = o, o.out / "last.pt"
        self.model = UNet(TIERS[o.tier]).to(memory_format=torch.channels_last)
        torch.nn.init.constant_(self.model.out_conv.bias, -1.4)  # mid-grey is about 0.2 in the network domain
        decays = [p for p in self.model.parameters() if p.ndim > 1]
        others = [p for p in self.model.parameters() if p.ndim == 1]
        groups = [dict(params=decays, weight_decay=o.weight_decay), dict(params=others, weight_decay=0.0)]
        self.optimizer = torch.optim.AdamW(groups, lr=o.lr, fused=True)
        self.ema = Ema(self.model, 0.998)
        self.step, self.elapsed, self.best, self.stale = 0, 0.0, math.inf, 0
        if o.resume:
            if not self.last.exists():
                raise SystemExit(f"{self.last}: no checkpoint to resume; leave out --resume to start a new run")
            self._restore(torch.load(self.last))

    def _restore(self, state):
        self.model.load_state_dict(state["model"])
        self.ema.model.load_state_dict(state["ema"])
        self.optimizer.load_state_dict(state["optimizer"])
        self.step, self.elapsed, self.best, self.stale = state["progress"]

    def save(self, score):
        self.stale = 0 if score < self.best else self.stale + 1
        self.best = min(self.best, score)
        about = dict(tier=self.o.tier, widths=self.model.widths, score=score, step=self.step)
        if self.stale == 0:
            torch.save(dict(about, ema=self.ema.model.state_dict()), self.o.out / "best.pt")
        progress = self.step, self.elapsed, self.best, self.stale
        torch.save(dict(about, model=self.model.state_dict(), ema=self.ema.model.state_dict(),
                        optimizer=self.optimizer.state_dict(), progress=progress), self.last)

    def train_step(self, crops):
        for group in self.optimizer.param_groups:
            group["lr"] = self.o.lr * one_cycle(min(1.0, self.elapsed / (60 * self.o.minutes)))
        x, target = crops.batch(self.o.batch)
        with torch.autocast("cpu", torch.bfloat16):
            output = self.model(x.contiguous(memory_format=torch.channels_last))
        value = loss(output, target)
        self.optimizer.zero_grad()
        value.backward()
        torch.nn.utils.clip_grad_norm_(self.model.parameters(), 1.0)
        self.optimizer.step()
        self.step += 1
        self.ema.update(self.model, self.step)
        return value.item()


def main():
    o = arguments()
    torch.set_num_threads(o.threads)
    torch.manual_seed(o.seed)
    o.out.mkdir(parents=True, exist_ok=True)
    views = load_views(o.data, o.cache)
    held_out = part(views, "val")
    if not any(4 <= spp <= 32 for v in held_out for spp, _ in v["noisy"]):
        raise SystemExit("no validation render of 4 to 32 samples: give views of more scenes (20 at least)")
    run = Run(o)
    crops = Crops(part(views, "train"), o.crop, o.seed + run.step)
    writer = None
    if o.tensorboard:
        from torch.utils.tensorboard import SummaryWriter
        writer = SummaryWriter(o.out)
    print(f"{o.tier}: {parameter_count(run.model)} parameters, {len(crops.views)} training views", flush=True)
    losses, due = [], run.elapsed + 60 * min(o.validate, o.minutes)
    while run.elapsed < 60 * o.minutes and run.stale < o.patience:
        start = time.monotonic()
        losses.append(run.train_step(crops))
        run.elapsed += time.monotonic() - start
        if run.elapsed >= min(due, 60 * o.minutes):
            due = run.elapsed + 60 * o.validate
            mean, losses = sum(losses) / len(losses), []
            report(run, mean, validate(run.ema.model, held_out), writer)


def report(run, mean, score, writer):
    run.save(score)
    rate = run.optimizer.param_groups[0]["lr"]
    print(f"{run.elapsed / 60:6.1f} min  step {run.step:6d}  lr {rate:.1e}  loss {mean:.5f}  "
          f"L1 denoised/noisy {score:.4f}  best {run.best:.4f}", flush=True)
    with open(run.o.out / "log.csv", "a") as f:
        f.write(f"{run.elapsed:.0f},{run.step},{rate:.3e},{mean:.6f},{score:.5f}\n")
    if writer:
        writer.add_scalar("loss", mean, run.step)
        writer.add_scalar("val_ratio", score, run.step)


if __name__ == "__main__":
    main()
