"""Rows stamped when they were read: solved, said so, and whoever follows the advice of a refusal gets there."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import fit, report, solve
from procedures.uncertainty.budget import budget
from procedures.uncertainty.sources import EXACT
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from tests.station.campaign_writing import write_campaign

PERIOD = 0.02


@pytest.fixture
def bursty(tmp_path: Path) -> Path:
    """Return a campaign whose rows were stamped in bursts of 4 to 12, and its even twin next to it."""
    campaign = simulate_campaign(Truth.example(7), 7, dwell_s=20.0)
    for name in ("even", "bursty"):
        (tmp_path / name).mkdir()
        write_campaign(tmp_path / name, campaign, PERIOD)
    rng = np.random.default_rng(7)
    for file in (tmp_path / "bursty").glob("*.csv"):
        header, *rows = file.read_text().splitlines()
        last = 0
        while last < len(rows):
            first, last = last, min(last + int(rng.integers(4, 13)), len(rows))
            read = float(rows[last - 1].split(",")[0]) + 1e-3 * rng.exponential()
            for i in range(first, last):
                rows[i] = f"{read + 1e-5 * (i - first):.6f},{rows[i].split(',', 1)[1]}"
        file.write_text("\n".join([header, *rows]) + "\n")
    return tmp_path / "bursty"


def solved(folder: Path) -> int:
    return cli.run(["solve", str(folder), "--json", str(folder / "solution.json")])


def restate(folder: Path, period: str) -> None:
    file = folder / "campaign.toml"
    file.write_text(re.sub(r"sample_period_s = .*", f"sample_period_s = {period}", file.read_text()))


def test_bursts_are_no_gaps_and_the_rates_are_those_of_the_even_twin(bursty: Path) -> None:
    found, even = read_campaign(bursty), read_campaign(bursty.parent / "even")
    for a, b in zip(found.campaign.dwells, even.campaign.dwells, strict=True):
        assert a.series.starts.tolist() == [0]
        assert a.series.period == pytest.approx(b.series.period, rel=5e-4)
        assert np.abs(np.diff(a.series.t) - a.series.period).max() < 1e-9
    assert not any("a gap of" in text for text in found.warnings)
    assert solved(bursty) == 0


Stamps = Callable[[FloatArray, np.random.Generator], FloatArray]


def late(t: FloatArray, rng: np.random.Generator) -> FloatArray:
    return np.asarray(np.maximum.accumulate(t + rng.exponential(0.2 * PERIOD, len(t))))


def shaken(t: FloatArray, rng: np.random.Generator) -> FloatArray:
    return np.asarray(t + rng.uniform(-0.3 * PERIOD, 0.3 * PERIOD, len(t)))


def read_slowly(t: FloatArray, rng: np.random.Generator) -> FloatArray:
    due = np.arange(t[0], t[-1] + 0.75, 0.25) + rng.uniform(0, 0.25)
    read = np.maximum.accumulate(due + rng.exponential(0.05, len(due)))
    return np.asarray(read[np.searchsorted(read, t)])


def stamped(folder: Path, stamps: Stamps, rng: np.random.Generator) -> None:
    for file in sorted(folder.glob("*.csv")):
        header, *rows = file.read_text().splitlines()
        t = stamps(np.array([float(row.split(",")[0]) for row in rows]), rng)
        for i in range(1, len(t)):
            t[i] = max(t[i], t[i - 1] + 1e-7)
        new = [f"{at:.7f},{row.split(',', 1)[1]}" for at, row in zip(t, rows, strict=True)]
        file.write_text("\n".join([header, *new]) + "\n")


@pytest.mark.parametrize(
    "stamps", [read_slowly, *(pytest.param(each, marks=pytest.mark.proof) for each in (late, shaken))]
)
def test_the_sigma_of_k_holds_what_the_stamps_leave_open_of_the_period(tmp_path: Path, stamps: Stamps) -> None:
    campaign = simulate_campaign(Truth.example(7), 7, dwell_s=20.0)
    write_campaign(tmp_path, campaign, PERIOD)
    even = solve([read_campaign(tmp_path).campaign]).accelerometer
    rng, off = np.random.default_rng(3), list[float]()
    plain = {file: file.read_text() for file in tmp_path.glob("*.csv")}
    for _ in range(1):
        for file, text in plain.items():
            file.write_text(text)
        stamped(tmp_path, stamps, rng)
        fits = fit([read_campaign(tmp_path).campaign])
        found = report(fits)
        assert found.accelerometer is not None
        assert even is not None
        k, base = found.accelerometer.scale_factor, even.scale_factor
        off.append(float(np.mean((k.value - base.value) / k.std)))
        assert np.all(k.std > 1.2 * base.std)
        assert found.quality.p_value > 1e-3
        budgets = {one.name: one for one in budget(fits, EXACT)}
        assert budgets["accelerometer.scale_factor.x"].std == pytest.approx(k.std[0], rel=0.02)
    assert np.max(np.abs(off)) < 3.5


def test_whoever_states_the_period_that_a_refusal_found_has_a_solution(
    bursty: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    restate(bursty, "0.00276")
    assert solved(bursty) == 3
    reported = capsys.readouterr().err
    advised = re.search(r"found a mean sample period of (\S+) s, .* correct sample_period_s", reported)
    assert advised is not None
    assert float(advised[1]) == pytest.approx(PERIOD, rel=5e-3)
    restate(bursty, advised[1])
    assert solved(bursty) == 0
