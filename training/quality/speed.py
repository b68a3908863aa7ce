"""Times the program and Open Image Denoise on this machine and writes the file that the page reads.

    python -m quality.speed --program ../target/release/wgdenoise --weights ../weights/*.safetensors

Images are 1024x1024 pixels with color, albedo and normal. The program's `bench` and oidnBenchmark alternate in rounds,
so that drifts in the machine's speed affect both alike; the result is the median over the rounds. The program uses its
default adapter unless `--adapter` names another. Open Image Denoise runs on the CPU, so only a CPU adapter is a fair
comparison.
"""

import argparse
import json
import os
import re
import statistics
from pathlib import Path

from quality.networks import load_all
from quality.oidn import HOME, MACS, QUALITIES
from quality.precision import PRECISIONS, call

SIZE = "1024"
OWN = "wgdenoise bench --weights FILE --precision PRECISION --runs 1 --json"
OTHER = 'oidnBenchmark -d cpu -r "RT.hdr_alb_nrm.*" -s 1024 1024 -q QUALITY'


def bench(program, weights, precision, adapter):
    """The report of `wgdenoise bench`."""
    chosen = ["--adapter", adapter] if adapter else []
    return json.loads(call([program, "bench", "--width", SIZE, "--height", SIZE, "--weights", weights,
                            "--precision", precision, "--runs", "1", "--json", *chosen]))


def oidn_milliseconds(quality):
    benchmark = HOME / "bin" / "oidnBenchmark"
    benchmark.chmod(0o755)
    libraries = os.environ | {"LD_LIBRARY_PATH": str(HOME / "lib")}
    printed = call([benchmark, "-d", "cpu", "-r", "RT.hdr_alb_nrm.*", "-s", SIZE, SIZE, "-q", quality], libraries)
    return float(re.search(r"([\d.]+) msec/image", printed)[1])


def measure(program, networks, adapter, rounds):
    """Rows with method, precision, multiply-adds per pixel and the milliseconds of every round; and the adapter's
    name."""
    rows = [dict(method=n.name, precision=p, macs=n.macs, rounds=[]) for n in networks for p in PRECISIONS]
    others = [dict(method=f"OIDN {q}", precision="", macs=MACS[q], rounds=[]) for q in QUALITIES]
    paths = {n.name: n.path for n in networks}
    for _ in range(rounds):
        for row in rows:
            report = bench(program, paths[row["method"]], row["precision"], adapter)
            row["rounds"].append(round(1000 * report["median_seconds"], 1))
        for row, quality in zip(others, QUALITIES):
            row["rounds"].append(round(oidn_milliseconds(quality), 1))
    for row in rows + others:
        row["ms"] = statistics.median(row["rounds"])
    return rows + others, f"{report['adapter']}, {report['backend']}"


def processor():
    """The CPU model and the number of cores available to this process."""
    about = Path("/proc/cpuinfo")
    model = re.search(r"model name\s*: (.*)", about.read_text()) if about.exists() else None
    return f"{model[1] if model else 'unknown processor'}, {len(os.sched_getaffinity(0))} cores"


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--program", type=Path, default=Path("../target/release/wgdenoise"))
    p.add_argument("--weights", nargs="+", required=True, help="weights files")
    p.add_argument("--adapter", help="adapter for the program, as listed by `wgdenoise devices`")
    p.add_argument("--rounds", type=int, default=3)
    p.add_argument("--out", type=Path, default=Path("../docs/quality/speed.json"))
    o = p.parse_args()
    rows, adapter = measure(o.program, load_all(o.weights), o.adapter, o.rounds)
    o.out.parent.mkdir(parents=True, exist_ok=True)
    about = dict(processor=processor(), adapter=adapter, size=f"{SIZE}x{SIZE}", commands=[OWN, OTHER], rows=rows)
    o.out.write_text(json.dumps(about, indent=1) + "\n")
    for row in rows:
        print(f"{row['method']:14} {row['precision']:4} {row['ms']:8.1f} ms of {row['rounds']}")


if __name__ == "__main__":
    main()
