"""One training run: network, optimizer, learning rate, moving average, and checkpoints to resume from."""

import copy
import math
import pickle

import torch

from augment import Crops
from losses import LOSSES
from model import TIERS, KernelPyramid, with_demodulation
from optimizer import OPTIMIZERS
from quality.networks import Network
from transfer import transfer


def load_checkpoint(path):
    """Loads `last.pt`, `best.pt`, the output of widen.py, or the same entries of a weights file."""
    if path.suffix == ".safetensors":
        return Network(path).checkpoint()
    try:
        return torch.load(path, map_location="cpu")
    except (OSError, RuntimeError, pickle.UnpicklingError) as e:
        raise SystemExit(f"{path}: not a checkpoint of train.py or widen.py: {e}") from None


def save_checkpoint(path, state):
    """Saves under the final name only once the file is complete."""
    unfinished = path.with_suffix(".part")
    torch.save(state, unfinished)
    unfinished.replace(path)


class Ema:
    """Exponential moving average of weights and batch norm statistics; its span grows with the steps up to `decay`."""

    def __init__(self, model, decay):
        self.model, self.decay = copy.deepcopy(model).eval().requires_grad_(False), decay

    @torch.no_grad()
    def update(self, model, step):
        decay = min(self.decay, (1 + step) / (10 + step))
        pairs = zip(self.model.state_dict().values(), model.state_dict().values())
        mine, others = zip(*(pair for pair in pairs if pair[0].is_floating_point()))
        torch._foreach_lerp_(mine, others, 1 - decay)


def one_cycle(progress, warmup=0.05, floor=0.002):
    """Factor on the peak learning rate at `progress` 0..1: linear warm-up, then cosine down to the floor."""
    if progress < warmup:
        return max(progress / warmup, 0.02)
    return floor + (1 - floor) * 0.5 * (1 + math.cos(math.pi * (progress - warmup) / (1 - warmup)))


class Run:
    """A training run with train.py's options on the training views. `last.pt` resumes it; `best.pt` holds the averaged
    weights that validated best."""

    def __init__(self, o, views):
        self.o, self.last, self.device = o, o.out / "last.pt", torch.device(o.device)
        self.model = KernelPyramid(o.widths or TIERS[o.tier], demodulates=True)
        self.parents = self._start_from(o.init) if o.init else []
        self.model.to(self.device, memory_format=torch.channels_last)
        self.optimizer = OPTIMIZERS[o.optimizer](self.model, o.lr, o.weight_decay)
        self.ema, self.crops = Ema(self.model, 0.998), Crops(views, o.crop, o.seed, o.effects)
        self.step, self.elapsed, self.best, self.stale = 0, 0.0, math.inf, 0
        if o.resume:
            self._restore()

    def _start_from(self, path):
        """Loads the weights of a checkpoint; returns its history."""
        checkpoint = load_checkpoint(path)
        if checkpoint["topology"] != self.model.topology:
            raise SystemExit(f"{path} has topology {checkpoint['topology']}: this trains {self.model.topology} only")
        if tuple(checkpoint["widths"]) != self.model.widths:
            raise SystemExit(f"{path} has widths {checkpoint['widths']}, this run has {self.model.widths}: "
                             "use the same tier, or widen the checkpoint with widen.py")
        self.model.load_state_dict(with_demodulation(checkpoint["ema"]))
        return checkpoint["history"]

    def _restore(self):
        state = load_checkpoint(self.last)
        self.model.load_state_dict(state["model"])
        self.ema.model.load_state_dict(state["ema"])
        self.optimizer.load_state_dict(state["optimizer"])
        self.crops.random.generator.set_state(state["random"])
        self.parents = state["history"][:-1]
        self.step, self.elapsed, self.best, self.stale = state["progress"]

    def history(self):
        """The training history of the weights, one line per run."""
        o = self.o
        return [*self.parents, f"{self.step} steps of {o.batch} crops of {o.crop} pixels from {len(self.crops.views)} "
                f"views, targets {o.targets}, loss {o.loss}, {o.optimizer}, peak rate {o.lr:g}, weight decay "
                f"{o.weight_decay:g}, seed {o.seed}, norm frozen after {o.freeze_norm:.0%}, effects {o.effects:.0%}, "
                f"{self.elapsed / 60:.0f} min"]

    def save(self, score):
        self.stale = 0 if score < self.best else self.stale + 1
        self.best = min(self.best, score)
        ema = self.ema.model.state_dict()
        about = dict(tier=self.o.tier, topology=self.model.topology, widths=self.model.widths, history=self.history(),
                     ema=ema)
        if self.stale == 0:
            save_checkpoint(self.o.out / "best.pt", about)
        state = dict(model=self.model.state_dict(), optimizer=self.optimizer.state_dict(),
                     random=self.crops.random.generator.get_state(),
                     progress=(self.step, self.elapsed, self.best, self.stale))
        save_checkpoint(self.last, about | state)

    def progress(self):
        """The completed share of the run; 1 or more means done."""
        return self.step / self.o.steps if self.o.steps else self.elapsed / (60 * self.o.minutes)

    def _schedule(self):
        """Sets the learning rate. From a given share of the run on, freezes the batch norm statistics: by then their
        noise dominates the loss, and the shipped network has fixed statistics."""
        for group in self.optimizer.param_groups:
            group["lr"] = self.o.lr * one_cycle(min(1.0, self.progress()))
        if self.progress() >= self.o.freeze_norm:
            for norm in (m for m in self.model.modules() if isinstance(m, torch.nn.BatchNorm2d)):
                norm.eval()  # scale and offset keep learning

    def train_step(self):
        """Trains on one batch; returns the loss."""
        self._schedule()
        x, light, target = (t.to(self.device) for t in self.crops.batch(self.o.batch))
        with torch.autocast(self.device.type, torch.bfloat16):
            output = self.model(x.contiguous(memory_format=torch.channels_last), light)
        value = LOSSES[self.o.loss](transfer(output), target)
        self.optimizer.zero_grad()
        value.backward()
        if torch.nn.utils.clip_grad_norm_(self.model.parameters(), 1.0).isfinite():
            self.optimizer.step()
        self.step += 1
        self.ema.update(self.model, self.step)
        return value.item()
