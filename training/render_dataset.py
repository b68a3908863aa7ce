"""Renders training data with Blender's Cycles, Mitsuba 3 or LuxCore, from random scenes or your own Blender files.

    pip install bpy==5.0.1 numpy       for cycles; needs Python 3.11
    pip install mitsuba numpy          for mitsuba
    pip install pyluxcore numpy        for luxcore
    python render_dataset.py cycles --out views --scenes 0:200 --jobs 4
    python render_dataset.py mitsuba --out views --scenes 200:400 --jobs 4 --filter-share 0.15
    python render_dataset.py cycles --out views --blend kitchen.blend garden.blend

Each scene renders in its own process, render/job.py. Scenes that are complete in OUT are skipped, so the same command
continues an interrupted run. A scene that fails leaves its error in OUT/failed and is skipped from then on; delete that
file to retry. A number gives the same scene in every renderer: use separate ranges, or one renderer's training scenes
become another's test scenes.
"""

import argparse
import importlib.util
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import namedtuple
from pathlib import Path

from render.job import blend_name, parse_samples, parse_size

PACKAGES = dict(cycles="bpy", mitsuba="mitsuba", luxcore="pyluxcore")
TRAINING = Path(__file__).resolve().parent
RANDOM_DEFAULTS = dict(samples="random:3", reference=512)
BLEND_DEFAULTS = dict(samples="2,5,10,25,50,100,200,500", reference=4000)

Scene = namedtuple("Scene", "name arguments")  # name prefix of its views; its arguments for render.job


def random_scenes(o):
    """The requested scenes. A fixed share of them uses Mitsuba's own Gaussian pixel filter."""
    scenes = []
    for seed in o.scenes:
        gaussian = random.Random(seed).random() < o.filter_share
        filter_name = "gaussian" if gaussian else "narrow"
        scenes.append(Scene(f"{o.renderer}{seed:06d}", (str(seed), "--filter", filter_name)))
    return scenes


def blend_scenes(o):
    scenes = []
    for path in o.blend:
        if not path.is_file():
            raise SystemExit(f"{path}: no such file")
        scenes.append(Scene(blend_name(path), ("0", "--blend", str(path.resolve()))))
    if len({scene.name for scene in scenes}) < len(scenes):
        raise SystemExit("two of the .blend files have the same name, which names their views; rename one")
    return scenes


class Run:
    """The scenes left to render, the running processes and the results so far."""

    def __init__(self, o, scenes, scratch):
        self.o, self.scratch, self.start = o, Path(scratch), time.monotonic()
        absent = [s for s in scenes if not self.view0(s).exists()]
        self.todo = [s for s in absent if not self.marker(s).exists()]
        self.total, self.complete, self.failed = len(scenes), len(scenes) - len(absent), len(absent) - len(self.todo)
        self.at_work, self.finished = {}, 0

    def view0(self, scene):
        return self.o.out / f"{scene.name}_v0.npz"  # render.job writes this view last

    def marker(self, scene):
        return self.o.out / "failed" / f"{scene.name}.txt"

    def log(self, scene):
        return self.scratch / f"{scene.name}.log"

    def launch(self, scene):
        """Starts the scene's process, shielded from Ctrl-C, with its temporary files in the run's folder."""
        o = self.o
        command = [sys.executable, "-m", "render.job", o.renderer, *scene.arguments, "--out", str(o.out.resolve()),
                   "--samples", o.samples, "--reference", str(o.reference), "--threads", str(o.threads),
                   "--views", str(o.views)]
        command += ["--size", "{}x{}".format(*o.size)] if o.size else []
        command += ["--exr"] if o.exr else []
        command += ["--gpu"] if o.gpu else []
        command += ["--progressive"] if o.progressive else []
        with open(self.log(scene), "w") as log:
            process = subprocess.Popen(command, cwd=TRAINING, stdout=subprocess.DEVNULL, stderr=log,
                                       env=os.environ | dict(TMPDIR=str(self.scratch)), start_new_session=True)
        self.at_work[scene] = process

    def work(self):
        """Keeps `jobs` processes busy until all scenes are done; starts no more after the time limit."""
        while self.at_work or self.may_launch():
            while self.may_launch() and len(self.at_work) < self.o.jobs:
                self.launch(self.todo.pop(0))
            time.sleep(0.1)
            for scene in [s for s, process in self.at_work.items() if process.poll() is not None]:
                self.collect(scene, self.at_work.pop(scene).returncode)

    def may_launch(self):
        return self.todo and time.monotonic() - self.start < 60 * self.o.minutes

    def collect(self, scene, code):
        """Counts a scene whose process has ended and reports progress."""
        self.finished += 1
        if code == 0:
            self.complete += 1
            self.report(scene)
        else:
            self.failed += 1
            lines = self.log(scene).read_text(errors="replace").strip().splitlines()
            reason = f"ended by signal {-code}" if code < 0 else lines[-1] if lines else f"exit code {code}"
            self.marker(scene).parent.mkdir(exist_ok=True)
            self.marker(scene).write_text(reason + "\n")
            self.report(scene, f"  FAILED: {reason}")

    def report(self, scene, remark=""):
        each = (time.monotonic() - self.start) / self.finished
        left = each * (len(self.todo) + len(self.at_work))
        print(f"{scene.name}  {self.complete + self.failed}/{self.total} done  {each:.1f} s per scene  "
              f"{left / 60:.0f} min left{remark}", flush=True)

    def abandon(self):
        """Ends the processes and removes their unfinished files."""
        for scene, process in self.at_work.items():
            process.kill()
            process.wait()
            for part in self.o.out.rglob(f"{scene.name}_v*.part"):
                part.unlink()


def positive(text):
    if not re.fullmatch(r"[1-9]\d*", text):
        raise argparse.ArgumentTypeError(f"{text}: expected a whole number of at least 1")
    return int(text)


def number_range(text):
    first, end = text.split(":")
    return range(int(first), int(end))


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("renderer", choices=PACKAGES)
    p.add_argument("--out", type=Path, required=True, help="folder for the views")
    what = p.add_mutually_exclusive_group(required=True)
    what.add_argument("--scenes", type=number_range, metavar="A:B", help="random scenes A to B-1")
    what.add_argument("--blend", type=Path, nargs="+", help="Blender files; every camera is a view (cycles)")
    p.add_argument("--jobs", type=positive, default=1, help="scenes rendered in parallel")
    p.add_argument("--threads", type=positive, default=1, help="threads per scene")
    p.add_argument("--minutes", type=float, default=float("inf"), help="start no more scenes after this time")
    p.add_argument("--size", type=parse_size, help="192 or 480x270; default 192, or the size in the .blend file")
    p.add_argument("--samples", type=parse_samples, help="samples of the noisy images: 4,16,64, or random:3 for three "
                   "counts from 1 to 256 per view; default random:3, or %(samples)s for .blend files" % BLEND_DEFAULTS)
    p.add_argument("--reference", type=positive, help="samples of the reference; %(reference)s" % RANDOM_DEFAULTS
                   + ", or %(reference)s for Blender files" % BLEND_DEFAULTS)
    p.add_argument("--views", type=positive, default=99, help="maximum number of views per scene")
    p.add_argument("--filter-share", type=float, default=0.0, help="share of scenes with a Gaussian filter (mitsuba)")
    p.add_argument("--progressive", action="store_true", help="noisy images of a view share samples, which halves the "
                   "work; for measurements only: training needs independent ones")
    p.add_argument("--gpu", action="store_true", help="render on the GPU (cycles; mitsuba does so anyway)")
    p.add_argument("--exr", action="store_true", help="also save the noisy images as EXR in OUT/exr (cycles)")
    return check(p, p.parse_args())


def check(p, o):
    """Fills in defaults and rejects options that the renderer does not support."""
    for name, value in (BLEND_DEFAULTS if o.blend else RANDOM_DEFAULTS).items():
        setattr(o, name, getattr(o, name) or value)
    if o.renderer != "cycles" and (o.blend or o.exr or o.gpu):
        p.error("--blend, --exr and --gpu only work with cycles")
    if o.progressive and o.exr:
        p.error("--exr does not work with --progressive")
    if o.renderer != "mitsuba" and o.filter_share:
        p.error("--filter-share only works with mitsuba")
    if not importlib.util.find_spec(PACKAGES[o.renderer]):
        p.error(f"{o.renderer} needs the Python package {PACKAGES[o.renderer]}; {sys.executable} does not have it")
    return o


def main():
    o = arguments()
    o.out.mkdir(parents=True, exist_ok=True)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # a terminated run also ends its processes
    scenes = blend_scenes(o) if o.blend else random_scenes(o)
    with tempfile.TemporaryDirectory() as scratch:
        run = Run(o, scenes, scratch)
        print(f"{run.total} scenes: {run.complete} complete, {run.failed} failed before, {len(run.todo)} to render",
              flush=True)
        try:
            run.work()
        except KeyboardInterrupt:
            print("stopped; run the same command to continue")
        finally:
            run.abandon()
    left = run.total - run.complete - run.failed
    print(f"{run.complete} of {run.total} scenes are in {o.out}, {run.failed} failed, {left} remain")
    print(f"to view them: python contact_sheet.py {o.out} sheet.png")
    sys.exit(1 if run.failed else 0)


if __name__ == "__main__":
    main()
