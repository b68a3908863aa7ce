"""Measure wgdenoise and other denoisers side by side on this machine; write a Markdown table and JSON.

    python benches/peers/run.py --size 1024x1024 --runs 5 --out results

Each of the `--runs` rounds measures every entry once, one after the other, each in its own process with a warm-up. A
peer that cannot be built, does not run or gives a wrong image becomes a row with the reason. README.md lists what each
peer needs.
"""

import argparse
import json
import sys
from pathlib import Path

import peers
import table
from peers import machine
from peers.base import CACHE, Entry, Options, Peer, Unavailable


def arguments() -> argparse.Namespace:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--size", type=_size, default=(1024, 1024), metavar="WxH", help="multiples of 16 [1024x1024]")
    p.add_argument("--runs", type=_positive, default=5, help="rounds; their median counts [5]")
    p.add_argument("--burst", type=_positive, default=1,
                   help="timed frames per round; use more on GPUs, where a frame takes milliseconds [1]")
    p.add_argument("--out", type=Path, default=CACHE / "results", help="folder for peers.md and peers.json")
    p.add_argument("--only", nargs="+", choices=[peer.name for peer in peers.ALL], metavar="NAME",
                   help="any of " + ", ".join(peer.name for peer in peers.ALL))
    p.add_argument("--tiers", nargs="+", default=["balanced"], choices=("fast", "balanced", "high"),
                   help="our networks to run in the frameworks [balanced]")
    p.add_argument("--against", choices=("f32", "f16"), default="f32",
                   help="precision of our balanced network for the ratios [f32]")
    p.add_argument("--timeout", type=float, default=3600, help="seconds allowed per command [3600]")
    for program in ("wgdenoise", "oidn-webgpu-native", "burn"):
        p.add_argument(f"--{program}", type=_path, metavar="PATH", help="use this program instead of building it")
    p.add_argument("--weights-cache", type=_path, default=CACHE / "weights",
                   help="folder for downloaded weights, exported networks and expected outputs")
    return p.parse_args()


def _size(text: str) -> tuple[int, int]:
    try:
        width, height = map(int, text.split("x"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text}: expected WIDTHxHEIGHT, such as 1024x1024") from None
    if min(width, height) < 16 or width % 16 or height % 16:
        raise argparse.ArgumentTypeError(f"{text}: both sides must be multiples of 16 and at least 16")
    return width, height


def _positive(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text}: expected a whole number of at least 1")
    return int(text)


def _path(text: str) -> Path:
    return Path(text).resolve()


def options_of(o: argparse.Namespace) -> Options:
    return Options(*o.size, burst=o.burst, tiers=tuple(o.tiers), weights_cache=o.weights_cache, timeout=o.timeout,
                   wgdenoise=o.wgdenoise, oidn_webgpu_native=o.oidn_webgpu_native, burn=o.burn)


def prepare(chosen: list[Peer], options: Options) -> list[Entry]:
    """Builds and prepares all peers and returns their entries; a failed peer becomes one entry with the reason."""
    entries = []
    for peer in chosen:
        say(f"preparing {peer.name}")
        try:
            entries += peer.entries(options)
        except Exception as e:  # noqa: BLE001 - a peer must not stop the others
            entries.append(Entry(peer.name, reason=reason_of(e)))
            say(f"{peer.name}: {reason_of(e)}")
    return entries


def measure(entries: list[Entry], number: int) -> None:
    """Measures each entry once, so that drifts of the machine's clock affect all alike."""
    for entry in (e for e in entries if not e.reason):
        try:
            entry.take(entry.measure())
            result = f"{entry.ms[-1]:.1f} ms"
        except Exception as e:  # noqa: BLE001 - as above
            result = entry.reason = reason_of(e)
        say(f"round {number}: {entry.peer}, {entry.network}, {entry.precision}: {result}")


def reason_of(error: Exception) -> str:
    """Formats the reason as one sentence."""
    return str(error) if isinstance(error, Unavailable) else f"{type(error).__name__}: {error}"


def write(o: argparse.Namespace, rounds: int, entries: list[Entry]) -> str:
    """Writes both files and returns the Markdown."""
    width, height = o.size
    rows, here = table.rows(entries, width * height, o.against), machine.about()
    text = (f"{width}×{height} pixels, {rounds} rounds of {o.burst} timed frames each, {here['processor']}, "
            f"{here['cores']} cores, {here['date']}, commit {here['commit']}.\n\n{table.markdown(rows)}")
    asked = {"width": width, "height": height, "rounds": rounds, "burst": o.burst, "against": o.against}
    o.out.mkdir(parents=True, exist_ok=True)
    (o.out / "peers.md").write_text(text)
    (o.out / "peers.json").write_text(json.dumps({"about": here | asked, "rows": rows}, indent=1) + "\n")
    return text


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def main() -> None:
    o = arguments()
    chosen = [peer for peer in peers.ALL if o.only is None or peer.name in o.only]
    entries = prepare(chosen, options_of(o))
    for number in range(1, o.runs + 1):
        measure(entries, number)
        text = write(o, number, entries)  # after each round, so that a stopped run keeps its results
    print(text)


if __name__ == "__main__":
    main()
