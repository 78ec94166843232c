"""The unit of time by all evidence: cases from public logs, each with what its reader must know."""

import numpy as np
import pytest

from procedures.counts.time_decision import (
    LIE_ODDS,
    TimeEvidence,
    decide,
    evidence_rows,
    usual_step,
)
from procedures.counts.time_unit import BY_NAME, clock_seconds, is_clock, minute_jumps, unit_called

N = np.arange(3000.0)


@pytest.mark.parametrize(
    ("stamps", "unit"),
    [
        (0.01 * N, "s"),
        (np.round(357200.0 + 0.1 * N, 1), "s"),  # GPS seconds of the week
        (0.0025 * N + 12.0, "s"),
        (1.7e9 + 0.01 * N, "unix-s"),
        (1767225600000 + 2000 * N, "unix-ms"),  # every 2 s
        (1.7e15 + 1e4 * N, "unix-us"),
        (1403636579758555392 + 5e6 * N, "unix-ns"),  # EuRoC, 200 Hz
        (132500000000000000 + 1e5 * N, "filetime"),
        (637500000000000000 + 1e5 * N, "dotnet"),
        (45292.5 + N / 86400 / 100, "excel"),
        (739468.25 + N / 86400 / 50, "matlab"),
        (2459000.5 + N / 86400 / 10, "julian"),
        (2403 * N, "us"),  # 416 Hz, LSM6DSO
        (20.0 * N * 1e6, "ns"),  # 50 Hz
    ],
)
def test_what_is_clear_is_decided(stamps: np.ndarray, unit: str) -> None:
    found = decide(TimeEvidence(stamps))
    assert found.winner is not None
    assert found.winner.unit.name == unit


@pytest.mark.parametrize(
    ("stamps", "units"),
    [
        (N, {"s", "ms"}),  # 1 Hz or 1 kHz
        (5000 + N, {"s", "ms"}),
        (1000 * N, {"ms", "us"}),
        (1e6 * N, {"us", "ns"}),
        (10 * N, {"s", "ms", "tick:1e-4"}),
        (100 * N, {"ms", "tick:1e-4"}),
        (np.round(N / 6, 6), {"s", "min"}),  # 6 Hz, or 0.1 Hz in minutes
        (N / 60, {"s", "min"}),  # 60 Hz, or 1 Hz
        (N / 3600, {"min", "h"}),
    ],
)
def test_what_two_rates_explain_is_asked(stamps: np.ndarray, units: set[str]) -> None:
    found = decide(TimeEvidence(stamps))
    assert found.winner is None
    assert units <= {each.unit.name for each in found.readings}


@pytest.mark.parametrize(
    ("stated", "stamps"),
    [("ms", 10 * N), ("s", N), ("ms", N), ("us", 1000 * N), ("us", 256551281491968 + 505629 * N), ("h", N / 3600),
     ("tick:1e-4", 100 * N), ("min", N / 60), ("ms", 0.125 * N), ("days", N / 86400)],
)  # fmt: skip
def test_a_header_that_states_the_unit_decides(stated: str, stamps: np.ndarray) -> None:
    found = decide(TimeEvidence(stamps, {BY_NAME[stated]: LIE_ODDS}))
    assert found.winner is not None
    assert found.winner.unit.seconds == BY_NAME[stated].seconds


@pytest.mark.parametrize(
    ("stated", "stamps"),
    [("ms", 0.001 * N), ("ms", 1.7e9 + 0.01 * N), ("s", 1.7e18 + 1e7 * N), ("us", 0.01 * N), ("s", 1e4 * N)],
)
def test_a_header_that_contradicts_the_stamps_is_asked_about(stated: str, stamps: np.ndarray) -> None:
    """As of https://github.com/swift-nav/piksi_tools/issues/629: tow(msec) in seconds."""
    assert decide(TimeEvidence(stamps, {BY_NAME[stated]: LIE_ODDS})).winner is None


@pytest.mark.parametrize("step", [100.0, 25.0, 10.0])
def test_ticks_of_sample_time_fine(step: float) -> None:
    """Xsens MTi counts 0.1 ms, Xsens DOT 1 us under the same name."""
    named = {BY_NAME["tick:1e-4"]: LIE_ODDS, BY_NAME["us"]: LIE_ODDS / 3}
    found = decide(TimeEvidence(8732500 + step * N, named))
    assert found.winner is not None
    assert found.winner.unit.name == "tick:1e-4"
    asked = decide(TimeEvidence(np.round(1e6 / 60 * N), named))
    assert asked.winner is None
    assert asked.readings[0].unit.name == "us"


@pytest.mark.parametrize("scale", [0.0025, 1e-3, 1e-4, 2e-5])
def test_a_scale_in_the_header_decides(scale: float) -> None:
    found = decide(TimeEvidence(np.round(N * max(1.0, 2.5e-3 / scale)), scale_s=scale))
    assert found.winner is not None
    assert found.winner.unit.seconds == pytest.approx(scale)
    assert found.winner.rate_hz == pytest.approx(400.0, rel=1e-3)


def test_a_specified_rate_decides() -> None:
    found = decide(TimeEvidence(N, rate_hz=1000.0))
    assert found.winner is not None
    assert found.winner.unit.name == "ms"


def test_a_clock_of_digits_runs_over_its_minutes_and_hours() -> None:
    seconds = 13 * 3600 + 59 * 60 + 55 + 0.01 * np.arange(2000)
    stamps = np.array([float(f"{s // 3600:02.0f}{s % 3600 // 60:02.0f}{s % 60:06.3f}") for s in seconds])
    assert is_clock(stamps)
    assert minute_jumps(stamps) == 1
    assert clock_seconds(stamps) == pytest.approx(seconds)
    found = decide(TimeEvidence(stamps))
    assert found.winner is not None
    assert found.winner.unit.name == "hhmmss"
    assert found.winner.duration_s == pytest.approx(19.99)


def test_a_clock_goes_on_over_its_midnights() -> None:
    seconds = np.mod(22 * 3600.0 + np.arange(0.0, 100_000.0, 2.0), 86400.0)  # 27.8 h
    stamps = seconds // 3600 * 10000 + seconds % 3600 // 60 * 100 + seconds % 60
    readings = {each.unit.name: each for each in decide(TimeEvidence(stamps)).readings}
    assert readings["hhmmss"].duration_s == pytest.approx(99_998.0)


def test_a_clock_with_a_date() -> None:
    stamps = np.array([20240228235959.0, 20240229000000.0, 20240301000000.0, 19991231235959.5])
    expected = ["2024-02-28T23:59:59", "2024-02-29T00:00:00", "2024-03-01T00:00:00", "1999-12-31T23:59:59.5"]
    assert clock_seconds(stamps) == pytest.approx(
        [np.datetime64(each).astype("datetime64[ms]").astype(float) / 1e3 for each in expected]
    )


@pytest.mark.parametrize(("digits", "rows"), [(6, 200_000), (7, 20_000)])
def test_stamps_of_few_digits_keep_their_rate(digits: int, rows: int) -> None:
    t = np.array([float(f"{each:.{digits}g}") for each in 12345.0 + np.arange(rows) / 1000])
    step, uncertainty = usual_step(t[: evidence_rows(t)])
    assert step == pytest.approx(1e-3, rel=max(3 * uncertainty, 0.02))
    found = decide(TimeEvidence(t))
    assert found.winner is not None
    assert found.winner.unit.name == "s"


def test_stamps_that_never_rise_have_no_reading() -> None:
    assert decide(TimeEvidence(np.full(100, 1.73234e9))).readings == ()


@pytest.mark.parametrize(("rate", "tick"), [(120.0, 1e-3), (700.0, 1e-3), (8000.0, 1e-4), (3333.0, 1e-4)])
def test_rounded_stamps_keep_their_mean_rate(rate: float, tick: float) -> None:
    step, _ = usual_step(np.round(N / rate / tick))
    assert step * tick == pytest.approx(1 / rate, rel=1e-3)


def test_dropouts_and_falls_do_not_move_the_step() -> None:
    t = np.delete(0.01 * N, np.arange(50, 3000, 97))
    assert usual_step(t)[0] == pytest.approx(0.01, rel=2e-3)
    assert usual_step(np.mod(0.01 * N, 6.5536))[0] == pytest.approx(0.01, rel=2e-3)


@pytest.mark.parametrize("name", ["tick:0", "tick:-1", "tick:", "tick:1e99", "tick:1.2.3", "furlong", ""])
def test_what_is_no_unit_of_time(name: str) -> None:
    assert unit_called(name) is None
