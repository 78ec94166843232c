"""Of noise alone a name has a probability of 0.9 in at most one draw of a hundred, whatever looks for it."""

from collections import Counter
from collections.abc import Callable, Iterable

import numpy as np
import pytest

from procedures.anomalies.clock_rate_check import find_clock
from procedures.anomalies.disturbances import find_disturbances
from procedures.anomalies.disturbed_soaks import without_shocks
from procedures.anomalies.wrong_positions import find_wrong_labels, label_findings
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, RestRecord, Site, SoakRecord, TurnRecord
from procedures.counts.sample_records import CountSeries, RateSeries
from procedures.geodesy import earth_rate_n
from procedures.inference.odds import gain, gain_of_squares
from procedures.inference.priors import LIKELY
from procedures.inference.result import Finding
from procedures.positions import nominal_C_lb
from procedures.samples.sample_effects import sample_effects
from procedures.samples.sample_turns import periodic_in_turns
from tests.procedures.diagnosis.planted import planted, with_reference_time

FEW, MANY = 15, 300  # draws: each contributor's, and the proof's
PERIOD = 0.1
UNIT = {"gyroscope": np.ones(3), "accelerometer": np.ones(3)}
Draw = Callable[[np.random.Generator], Iterable[Finding]]


def campaign(**recordings: object) -> Campaign:
    known: dict[str, object] = {
        "dwells": (),
        "turns": (),
        "nominal_scale": {"accelerometer": 1.0, "gyroscope": 1.0},
    }
    return Campaign("m", "s", False, Site(0.8, 9.8, 0.02), **(known | recordings))  # type: ignore[arg-type]


def series(rng: np.random.Generator, n: int, begin: float = 0.0, **extra: FloatArray) -> RateSeries:
    t = begin + PERIOD * np.arange(1, n + 1)
    gyro, accel = rng.normal(size=(2, n, 3))
    return RateSeries(t, gyro, accel, np.full(n, 25.0), PERIOD, extra=extra)


def soak(one: RateSeries, name: str = "soak") -> SoakRecord:
    return SoakRecord(name, 0, None, one)


def with_channels(rng: np.random.Generator) -> Iterable[Finding]:
    n = 4608
    ramp = np.cumsum(0.037 * (1 + 0.1 * rng.normal(size=n))) % 1.0
    one = series(rng, n, aux_ramp=360 * ramp, aux_volts=rng.normal(size=n))
    return sample_effects([campaign(soaks=(soak(one),))], UNIT).findings


def in_several_recordings(rng: np.random.Generator) -> Iterable[Finding]:
    soaks = tuple(soak(series(rng, 512, begin), f"{begin}") for begin in (0.0, 60.0, 131.0, 200.0))
    return sample_effects([campaign(soaks=soaks)], UNIT).findings


def in_soaks(rng: np.random.Generator) -> Iterable[Finding]:
    return without_shocks([campaign(soaks=(soak(series(rng, 2400)),))]).findings


def in_rests(rng: np.random.Generator) -> Iterable[Finding]:
    rests = tuple(RestRecord(f"{i}", None, series(rng, 300)) for i in range(4))
    return [each.finding for each in find_disturbances([campaign(rests=rests)])[0]]


def in_counts(rng: np.random.Generator) -> Iterable[Finding]:
    dwells = list[DwellRecord]()
    for i in range(4):
        total = rng.random(3) + np.cumsum(0.3 + 0.01 * rng.normal(size=(600, 3)), axis=0)
        counts = np.diff(np.floor(total), axis=0, prepend=0.0).astype(np.int64)
        counted = CountSeries(0.02 * np.arange(1, 601), None, counts, np.full(600, 25.0), 0.02)
        dwells.append(DwellRecord(f"{i}", i + 1, counted))
    one = Campaign("m", "s", True, Site(0.8, 9.8, 0.02), tuple(dwells), ())
    return [each.finding for each in find_disturbances([one])[0]]


def in_turns(rng: np.random.Generator) -> Iterable[Finding]:
    turns = list[TurnRecord]()
    for axis, face_up in enumerate((1, 5, 9)):
        for direction, sign in (("+", 1.0), ("-", -1.0)):
            n = 700
            rate = sign * np.clip(np.minimum(np.arange(n), n - np.arange(n)) / 50, 0, 1)
            rate *= 1080 / (np.abs(rate).sum() * PERIOD)
            gyro = 0.02 * rng.normal(size=(n, 3))
            gyro[:, axis] += rate
            motor = (5 * np.cumsum(rate) * PERIOD + 77) % 360
            t = PERIOD * np.arange(1, n + 1)
            one = RateSeries(t, gyro, None, np.full(n, 25.0), PERIOD, extra={"aux_motor": motor})
            turns.append(TurnRecord(f"{axis}{direction}", "xyz"[axis], direction, 3, face_up, one))
    return periodic_in_turns([campaign(turns=tuple(turns))], UNIT)[0]


def of_labels(rng: np.random.Generator) -> Iterable[Finding]:
    earth = np.degrees(earth_rate_n(0.8))
    bias, dwells = rng.normal(0, 1e-3, 3), list[DwellRecord]()
    for position in range(1, 13):
        C_bl = nominal_C_lb(position).T
        t = 600.0 * position + PERIOD * np.arange(1, 21)
        own = bias + rng.normal(0, 1e-4, 3)  # deg/s: a third of a degree an hour from dwell to dwell
        gyro = C_bl @ earth + own + 1e-4 * rng.normal(size=(20, 3))
        accel = C_bl[:, 2] + 1e-3 * rng.normal(size=(20, 3))
        one = RateSeries(t, gyro, accel, np.full(20, 25.0), PERIOD)
        dwells.append(DwellRecord(f"{position}", position, one))
    one_campaign = campaign(dwells=tuple(dwells))
    return label_findings([one_campaign], find_wrong_labels([one_campaign]))[0]


BASE = planted(1, dwell_s=10.0)


def of_the_clock(rng: np.random.Generator) -> Iterable[Finding]:
    return find_clock([with_reference_time(BASE, 0.0, int(rng.integers(2**31)))])[0]


@pytest.mark.parametrize("dof", [np.inf, 20.0])
def test_noise_is_a_hundred_times_likelier_with_columns_in_one_draw_of_a_hundred_at_most(dof: float) -> None:
    """The likelihood ratio of noise has the mean 1, so it is above R with a probability of at most 1 / R."""
    rng = np.random.default_rng(1)
    W = rng.normal(size=(40, 3)) * [1.0, 3.0, 0.1]
    scale = np.sqrt(dof / rng.chisquare(dof, 3000)) if np.isfinite(dof) else np.ones(3000)
    ratio = np.exp([gain(W.T @ W, W.T @ y, dof) for y in scale[:, None] * rng.normal(size=(3000, 40))])
    assert np.mean(ratio > 10) <= 0.1
    assert np.mean(ratio > 100) <= 0.01


def test_the_gain_of_alike_columns_is_that_of_their_squares() -> None:
    squares = np.array([0.0, 4.0, 200.0])
    for k in (1, 2, 7):
        each = [gain(np.eye(k), np.full(k, np.sqrt(x / k)), 30.0) for x in squares.tolist()]
        assert gain_of_squares(squares, k, 30.0) == pytest.approx(each)


@pytest.mark.parametrize(
    "draw",
    [with_channels, in_several_recordings, in_soaks, in_rests, in_counts, in_turns, of_labels, of_the_clock],
)
@pytest.mark.parametrize("draws", [FEW, pytest.param(MANY, marks=pytest.mark.proof)])
def test_noise_has_names_in_one_draw_of_a_hundred_at_most(draw: Draw, draws: int) -> None:
    rng = np.random.default_rng(20261130)
    found = Counter(
        name for _ in range(draws) for name in {each.effect for each in draw(rng) if each.probability >= LIKELY}
    )
    assert all(times <= draws // 100 for times in found.values()), found
