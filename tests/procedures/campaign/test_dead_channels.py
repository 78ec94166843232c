"""Dead channels are named and left out wherever they are dead; a healthy one that counts slowly is not."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import SimulatedBench, simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Campaign, RateTable, SequenceRecord, SoakRecord
from procedures.campaign.dead_channels import without_dead
from procedures.campaign.plan_steps import Dwell
from procedures.counts.sample_records import RateSeries, Series
from procedures.diagnosis.diagnose import diagnose
from procedures.effects import EFFECTS

TRUTH = replace(Truth.example(7), sample_period_s=0.05)
FIELDS = {"gyroscope": "gyro", "accelerometer": "accel"}
Kill = Callable[[str, Series], Series]
# few effects are tried: what is tested is how channels are read
NAMES = {
    "slab.tilt", "fixture.parallelism", "procedure.heading", "procedure.closure", "placement.dwell",
    "accelerometer.quadratic", "accelerometer.bias_temperature", "gyroscope.bias_temperature",
    "gyroscope.g_sensitivity",
}  # fmt: skip
FEW = [each for each in EFFECTS if each.name in NAMES]


@cache
def recorded(counts: bool) -> Campaign:
    """A whole campaign with a soak of seven blocks; counts, or rates with noise of many steps of a converter."""
    plain = simulate_campaign(TRUTH, 7, dwell_s=10.0)
    last = max(step.series.t[-1] for step in (*plain.dwells, *plain.turns))
    series = SimulatedBench(TRUTH, 7).perform(Dwell(1, 650.0))
    soak = replace(series, t=series.t - series.t[0] + last + 60.0)
    campaign = replace(plain, soaks=(SoakRecord("soak", 1, None, soak),))
    return campaign if counts else every_step(replace(campaign, counts=False), lambda _, s: as_rates(s))


def as_rates(series: Series) -> RateSeries:
    rng = np.random.default_rng(len(series))
    gyro, accel = (
        np.round((np.asarray(v) / 0.05 + rng.standard_normal(v.shape) * 30) * 4) / 4
        for v in (series.gyro, series.accel)
    )
    return RateSeries(series.t, gyro, accel, series.temperature, series.period, series.starts)


def every_step(campaign: Campaign, change: Kill) -> Campaign:
    def changed(records):  # type: ignore[no-untyped-def]
        return tuple(replace(each, series=change(each.name, each.series)) for each in records)

    return replace(
        campaign, dwells=changed(campaign.dwells), turns=changed(campaign.turns), soaks=changed(campaign.soaks)
    )


def dead(triad: str, axes: str, where: Callable[[str], bool], value: float = 0.0, share: float = 0.0) -> Kill:
    """Return what makes channels constant in some steps, from a share of each on."""

    def change(name: str, series: Series) -> Series:
        if not where(name):
            return series
        samples = np.array(getattr(series, FIELDS[triad]))
        begin = int(share * len(samples))
        for axis in axes:
            samples[begin:, "xyz".index(axis)] = value
        return replace(series, **{FIELDS[triad]: samples})  # type: ignore[arg-type]

    return change


def everywhere(_: str) -> bool:
    return True


def late(name: str) -> bool:
    """Name the steps of the second half: dwells 7 to 12, turns and the soak."""
    return not name.startswith("dwell_0") or name >= "dwell_07"


GYRO, ACCEL = "gyroscope", "accelerometer"
CASES = {
    "one axis": (dead(GYRO, "yz", everywhere), ("gyroscope y", "gyroscope z", "every step"), ACCEL),
    "an accelerometer": (dead(ACCEL, "y", everywhere), ("accelerometer y", "every step"), GYRO),
    "in a soak": (dead(GYRO, "y", lambda n: n == "soak", 0.0, 0.5), ("in soak from",), "both"),
    "later on": (dead(GYRO, "y", late), ("dwell_07", "more"), ACCEL),
    "inside a dwell": (dead(ACCEL, "y", lambda n: n == "dwell_07", 0.0, 0.4), ("dwell_07 from",), "both"),
    "inside its own turn, held": (
        dead(GYRO, "x", lambda n: n == "turn_x_plus", 65000.0, 0.5), ("gyroscope x", "turn_x_plus from 727 s on"),
        "both",
    ),
    "inside both own turns": (
        dead(GYRO, "x", lambda n: n.startswith("turn_x"), 0.0, 0.5),
        ("turn_x_plus from 727 s on, turn_x_minus from",), ACCEL,
    ),
    "own turn": (dead(GYRO, "y", lambda n: n == "turn_y_plus"), ("all of turn_y_plus",), "both"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("case", "counts"), [(each, True) for each in CASES if each != "own turn"] + [("inside a dwell", False)]
)
def test_a_dead_channel_is_named_and_the_rest_is_solved_and_diagnosed(case: str, counts: bool) -> None:
    kill, words, alive = CASES[case]
    campaign = every_step(recorded(counts), kill)
    solution = solve([campaign])
    warned = "\n".join(text for text in solution.warnings if "outputs a constant" in text)
    assert all(word in warned for word in words)
    diagnosed = diagnose([campaign], FEW).solution
    assert [text for text in diagnosed.warnings if "outputs a constant" in text] == warned.split("\n")
    for triad, there in (("accelerometer", alive != "gyroscope"), ("gyroscope", alive != "accelerometer")):
        for each in (solution, diagnosed):
            found = getattr(each, triad)
            assert (found is not None) == there
            assert found is None or np.all(np.isfinite(found.bias.std))


@pytest.mark.parametrize("case", ["inside a dwell", "own turn"])
def test_what_is_left_finds_the_truth(case: str) -> None:
    found = solve([every_step(recorded(True), CASES[case][0])])
    assert found.accelerometer is not None
    assert found.gyroscope is not None
    for triad, k in ((found.accelerometer, TRUTH.accel_k), (found.gyroscope, TRUTH.gyro_k)):
        assert np.max(np.abs(triad.scale_factor.value - k) / triad.scale_factor.std) < 4


def one_recording(campaign: Campaign) -> Campaign:
    """Return a campaign whose dwells and turns are one unsegmented recording."""
    steps = sorted((*campaign.dwells, *campaign.turns), key=lambda step: float(step.series.t[0]))
    first = steps[0].series
    gyro, accel = (
        np.concatenate([np.asarray(getattr(step.series, name)) for step in steps]) for name in FIELDS.values()
    )
    n = len(gyro)
    whole = replace(
        first, t=first.period * np.arange(1.0, n + 1), gyro=gyro, accel=accel, temperature=np.full(n, 23.0),
        extra={},
    )  # fmt: skip
    return replace(campaign, dwells=(), turns=(), soaks=(), sequences=(SequenceRecord("walk", whole),))


@pytest.mark.parametrize("counts", [True, False], ids=["counts", "rates"])
def test_a_channel_that_stops_in_a_sequence_is_named_with_its_time(counts: bool) -> None:
    whole = one_recording(recorded(counts))
    assert without_dead([whole])[1] == ()
    [record] = whole.sequences
    stopped_y = dead(GYRO, "y", everywhere, 0.0, 0.5)(record.name, record.series)
    [kept], [reported] = without_dead([replace(whole, sequences=(replace(record, series=stopped_y),))])
    assert "gyroscope y outputs a constant 0 in walk from" in reported
    assert kept.sequences[0].series.gyro is None
    assert kept.sequences[0].series.accel is not None


def test_a_rate_tables_dead_gyroscope_is_left_out() -> None:
    rate = np.repeat([-20.0, 0.0, 20.0], 30)
    output = np.column_stack((rate * 10 + np.arange(90) % 3, np.zeros(90), np.zeros(90)))
    tables = tuple(RateTable(f"table_{axis}", axis, rate, output, np.full(90, 23.0)) for axis in "xy")
    [kept], reported = without_dead([replace(recorded(False), rate_tables=tables)])
    assert reported == ("gyroscope y outputs a constant 0 in all of table_y: not used",)
    assert np.all(np.isfinite(kept.rate_tables[0].output))
    assert np.all(np.isnan(kept.rate_tables[1].output[:, 1]))


@pytest.mark.parametrize("counts", [True, False], ids=["counts", "rates"])
def test_a_healthy_unit_has_no_dead_channel(counts: bool) -> None:
    assert without_dead([recorded(counts)])[1] == ()


def test_a_channel_of_a_count_in_minutes_is_slow_and_not_dead() -> None:
    slow = replace(TRUTH, gyro_k=TRUTH.gyro_k / 20000, gyro_d_deg_s=np.array([1e-4, 0.0, -2e-3]))
    campaign = simulate_campaign(slow, 1, dwell_s=20.0)
    assert any(not np.any(dwell.series.gyro[:, 1]) for dwell in campaign.dwells)  # no count in all of a dwell
    assert without_dead([campaign])[1] == ()
