"""Tests of run.py that need neither a GPU nor a built peer: `python -m pytest benches/peers`."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import run
import table
from peers import base, reference
from peers.base import Entry, Options, Peer, Sample, Unavailable

OPTIONS = Options(32, 16, burst=1, tiers=("balanced",), weights_cache=Path("unused"), timeout=10)


def entry(peer: str, network: str, macs: float, *ms: float, precision: str = "f32") -> Entry:
    return Entry(peer, network, precision, base.NETWORK, macs, adapter="a", ms=list(ms))


def ours(*ms: float) -> Entry:
    return entry(*table.OURS, 50_000.0, *ms)


def test_a_row_has_the_median_the_rate_and_both_ratios():
    other = entry("other", "base", 100_000.0, 30.0, 10.0, 20.0)
    row = table.rows([ours(40.0), other], 1_000_000, "f32")[1]
    assert row["median_ms"] == 20.0
    assert row["gflops"] == pytest.approx(10_000)  # 2 · 100 k · 1 M operations in 20 ms
    assert row["time_ratio"] == pytest.approx(0.5)
    assert row["time_per_mac_ratio"] == pytest.approx(0.25)


def test_ratios_are_to_our_balanced_network_in_the_precision_asked_for():
    half = entry(*table.OURS, 50_000.0, 20.0, precision="f16")
    assert [r["time_ratio"] for r in table.rows([ours(40.0), half], 1, "f16")] == [2.0, 1.0]


def test_without_our_network_there_are_no_ratios():
    (row,) = table.rows([entry("other", "base", 1.0, 5.0)], 1, "f32")
    assert "time_ratio" not in row and row["median_ms"] == 5.0
    assert "5.00 (5.00 to 5.00)" in table.markdown([row])


def test_a_peer_that_cannot_be_prepared_is_a_row_and_the_others_run():
    def broken(_: Options) -> list[Entry]:
        raise Unavailable("it is not installed")

    def crashing(_: Options) -> list[Entry]:
        return {}["entries"]

    def works(_: Options) -> list[Entry]:
        return [Entry("works", "net", "f32", macs=1.0, measure=lambda: Sample(7.0, "cpu", "1e-06"))]

    entries = run.prepare([Peer("broken", broken), Peer("crashing", crashing), Peer("works", works)], OPTIONS)
    run.measure(entries, 1)
    run.measure(entries, 2)
    first, second, third = table.rows(entries, 1, "f32")
    assert first["reason"] == "it is not installed" and first["ms"] == []
    assert second["reason"].startswith("KeyError")
    assert third["ms"] == [7.0, 7.0] and (third["adapter"], third["check"]) == ("cpu", "1e-06")
    assert "| broken |" in table.markdown([first]) and "not measured: it is not installed" in table.markdown([first])


def test_an_entry_that_fails_in_a_later_round_loses_its_figures():
    samples = iter([Sample(1.0, "cpu")])

    def measure() -> Sample:
        try:
            return next(samples)
        except StopIteration:
            raise Unavailable("the device is lost") from None

    entries = [Entry("flaky", "net", macs=1.0, measure=measure)]
    run.measure(entries, 1)
    run.measure(entries, 2)
    (row,) = table.rows(entries, 1, "f32")
    assert row["ms"] == [] and row["reason"] == "the device is lost" and "median_ms" not in row


def test_the_size_of_our_networks_is_what_wgdenoise_counts():
    assert reference.macs("fast") == 12282.0  # as `wgdenoise bench --json` reports it
    assert [round(reference.macs(t), -2) for t in ("balanced", "high")] == [40700.0, 85800.0]


def test_a_wrong_output_is_not_timed():
    report = {"max_error": 1e-3, "seconds": [0.002, 0.004, 0.003], "adapter": "cpu"}
    assert base.judged(report, "f16") == Sample(3.0, "cpu", "1e-03")
    for error, precision in ((1e-3, "f32"), (float("nan"), "f32"), (float("inf"), "f16")):
        with pytest.raises(Unavailable, match="wrong"):
            base.judged(report | {"max_error": error}, precision)


def test_a_command_that_fails_says_what_it_said():
    with pytest.raises(Unavailable, match="cannot be started"):
        base.call(["no-such-program-anywhere"], 10)
    script = "import sys; print('bye'); sys.exit('panicked at main.rs:\\nerror: no adapter\\nnote: see the manual')"
    with pytest.raises(Unavailable, match="^probe failed: error: no adapter$"):
        base.call([sys.executable, "-c", script], 10, name="probe")
    with pytest.raises(Unavailable, match="longer than"):
        base.call([sys.executable, "-c", "import time; time.sleep(9)"], 0.2)


@pytest.mark.parametrize("text", ["1024", "axb", "100x100", "0x16", "-16x16"])
def test_sizes_that_no_network_takes_are_refused(text, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["run.py", f"--size={text}"])
    with pytest.raises(SystemExit):
        run.arguments()
    assert text in capsys.readouterr().err
