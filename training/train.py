"""Train one tier of the network for a given time or number of steps.

    python train.py balanced --data VIEWS [VIEWS ...] --out RUN --minutes 90

With --minutes, the one-cycle learning rate follows elapsed training time, so the run ends annealed whatever the
machine's speed or load. With --steps, the same command gives the same network on the same machine. Writes to RUN:
last.pt (for --resume), best.pt (the EMA weights that validated best, for export.py and evaluate.py) and log.csv.
"""

import argparse
import time
from pathlib import Path

import torch

from inference import denoise
from losses import LOSSES
from metrics import figures
from model import TIERS, parameter_count, widths_of
from optimizer import OPTIMIZERS
from run import Run
from views import load_views, part


class Validation:
    """Mean display L1 of denoised over noisy validation renders of 4 to 32 samples, with all inputs.

    Errors are measured against the training targets: the noise of plain references outweighs most networks' errors, and
    where light is sparse it favors a network that drops the light.
    """

    def __init__(self, views):
        self.renders = [(image, v["target"].float()) for v in views for spp, image in v["noisy"] if 4 <= spp <= 32]
        if not self.renders:
            raise SystemExit("no validation renders of 4 to 32 samples: add views of more scenes (at least 20)")
        self.noisy = sum(figures(image[:3].float(), target)["l1"] for image, target in self.renders)

    def __call__(self, model):
        return sum(figures(self._denoise(model, image), target)["l1"] for image, target in self.renders) / self.noisy

    @staticmethod
    def _denoise(model, image):
        with torch.autocast(model.device.type, torch.bfloat16):
            return denoise(model, image)


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("tier", choices=TIERS)
    p.add_argument("--widths", type=widths_of, help="widths to use instead of the tier's")
    p.add_argument("--data", nargs="+", required=True, help="folders of views")
    p.add_argument("--out", type=Path, required=True, help="folder for the run")
    p.add_argument("--cache", help="folder for decoded views")
    p.add_argument("--targets", choices=("references", "prefiltered"), default="references",
                   help="train on the rendered references or on the denoised ones of prefilter.py")
    p.add_argument("--loss", choices=LOSSES, default="l1_ssim", help="see losses.py")
    p.add_argument("--init", type=Path, help="start from the weights of this checkpoint or weights file")
    p.add_argument("--freeze-norm", type=float, nargs="?", const=0.0, default=0.3, metavar="SHARE",
                   help="freeze batch norm statistics after this share of the run; without a number, from the start")
    length = p.add_mutually_exclusive_group()
    length.add_argument("--minutes", type=float, default=90, help="training time; the schedule spans it")
    length.add_argument("--steps", type=int, help="training steps; the schedule spans them")
    p.add_argument("--optimizer", choices=OPTIMIZERS, default="muon", help="see optimizer.py")
    p.add_argument("--lr", type=float, default=2e-3, help="peak learning rate")
    p.add_argument("--weight-decay", type=float, default=1e-2)
    p.add_argument("--batch", type=int, default=8)
    p.add_argument("--crop", type=int, default=128)
    p.add_argument("--effects", type=float, default=1.0, metavar="SHARE",
                   help="odds of unusual light, texture and filters, relative to the default; see augment.py")
    p.add_argument("--validations", type=int, default=20, help="number of validations and checkpoints over the run")
    p.add_argument("--patience", type=int, default=6, help="stop after this many validations without a new best")
    p.add_argument("--device", default="cuda" if torch.cuda.is_available() else "cpu", help="cpu or cuda")
    p.add_argument("--threads", type=int, default=1, help="CPU threads")
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--resume", action="store_true")
    p.add_argument("--tensorboard", action="store_true", help="write TensorBoard events to RUN")
    p.add_argument("--tune", type=int, metavar="TRIALS", help="search parameters with Optuna instead; see tune.py")
    return p.parse_args()


def main():
    o = arguments()
    torch.set_num_threads(o.threads)
    o.out.mkdir(parents=True, exist_ok=True)
    views = load_views(o.data, o.cache, o.targets == "prefiltered")
    training, validation = part(views, "train"), Validation(part(views, "val"))

    def train(options, after_validation=None):
        return fit(options, training, validation, after_validation)

    if o.tune:
        from tune import tune
        tune(o, train)
    else:
        train(o)


def fit(o, training, validation, after_validation=None):
    """Trains until the schedule ends or validation stops improving; returns the best validation score.

    `after_validation(count, score)` is called after each validation and may raise to abort.
    """
    torch.manual_seed(o.seed)
    run = Run(o, training)
    print(f"{o.tier}: {parameter_count(run.model)} parameters, {len(training)} training views", flush=True)
    losses, count = [], int(run.progress() * o.validations)
    while run.progress() < 1 and run.stale < o.patience:
        start = time.monotonic()
        losses.append(run.train_step())
        run.elapsed += time.monotonic() - start
        if run.progress() * o.validations >= count + 1:
            count = int(run.progress() * o.validations)
            score = validation(run.ema.model)
            report(run, sum(losses) / len(losses), score)
            losses = []
            if after_validation:
                after_validation(count, score)
    return run.best


def report(run, mean, score):
    """Saves the run and reports progress on the console, in log.csv and as TensorBoard events."""
    run.save(score)
    rate = run.optimizer.param_groups[0]["lr"]
    print(f"{run.elapsed / 60:6.1f} min  step {run.step:6d}  lr {rate:.1e}  loss {mean:.5f}  "
          f"L1 denoised/noisy {score:.4f}  best {run.best:.4f}", flush=True)
    with open(run.o.out / "log.csv", "a") as f:  # seconds, step, rate, loss, score
        f.write(f"{run.elapsed:.0f},{run.step},{rate:.3e},{mean:.6f},{score:.5f}\n")
    if run.o.tensorboard:
        from torch.utils.tensorboard import SummaryWriter
        with SummaryWriter(run.o.out) as writer:
            writer.add_scalar("loss", mean, run.step)
            writer.add_scalar("val_ratio", score, run.step)


if __name__ == "__main__":
    main()
