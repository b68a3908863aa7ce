"""Turns milliseconds into rows, and rows into a Markdown table."""

import statistics

from peers.base import Entry

OURS = "wgdenoise", "balanced"
HEAD = ("peer", "network", "precision", "kMAC per pixel", "adapter", "timed", "median ms (min to max)", "GFLOP/s",
        "time, ours = 1", "time per MAC, ours = 1", "difference from PyTorch")


def rows(entries: list[Entry], pixels: int, precision: str) -> list[dict]:
    """One row per entry, in order; ratios are relative to our balanced network in `precision`."""
    measured = [e for e in entries if (e.peer, e.network, e.precision) == (*OURS, precision) and not e.reason]
    ours = measured[0] if measured else None
    return [_row(entry, pixels, ours) for entry in entries]


def _row(entry: Entry, pixels: int, ours: Entry | None) -> dict:
    row = {key: getattr(entry, key) for key in
           ("peer", "network", "precision", "macs", "adapter", "timed", "check", "ms", "reason")}
    if entry.reason or not entry.ms:
        return row | {"ms": [], "reason": entry.reason or "no round was run"}
    row["median_ms"] = statistics.median(entry.ms)
    if entry.macs:
        row["gflops"] = gflops(entry.macs, pixels, row["median_ms"])
    return row | _ratios(entry, ours)


def gflops(macs: float, pixels: int, ms: float) -> float:
    """Effective rate: the network's operations, two per multiply-accumulate, over the whole time."""
    return 2 * macs * pixels / (ms / 1000) / 1e9


def _ratios(entry: Entry, ours: Entry | None) -> dict:
    if ours is None:
        return {}
    time = statistics.median(entry.ms) / statistics.median(ours.ms)
    return {"time_ratio": time} | ({"time_per_mac_ratio": time * ours.macs / entry.macs} if entry.macs else {})


def markdown(table: list[dict]) -> str:
    lines = [list(HEAD), ["---"] * len(HEAD), *map(_cells, table)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _cells(row: dict) -> list[str]:
    macs = f"{row['macs'] / 1000:.1f}" if row["macs"] else ""
    about = [row["peer"], row["network"], row["precision"], macs, row["adapter"], row["timed"]]
    if row["reason"]:
        figures = [f"not measured: {row['reason']}", "", "", ""]
    else:
        figures = [_spread(row), *(_number(row.get(key)) for key in ("gflops", "time_ratio", "time_per_mac_ratio"))]
    return [cell.replace("|", "\\|").replace("\n", " ") for cell in (*about, *figures, row["check"])]


def _spread(row: dict) -> str:
    least, most = min(row["ms"]), max(row["ms"])
    return f"{_number(row['median_ms'])} ({_number(least)} to {_number(most)})"


def _number(value: float | None) -> str:
    """Formats three significant digits, or all integer digits above a thousand."""
    if value is None:
        return ""
    digits = 0 if value >= 100 else 1 if value >= 10 else 2
    return f"{value:.{digits}f}"
