"""What each further measurement changes of the steps that were made, reckoned by hand; and which one is taken."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.residual_rows import Evidence
from procedures.discovery import next_plan
from procedures.discovery.discover import Discovery, discover
from procedures.discovery.next_plan import OPTIONS, NextMeasurement, next_measurement
from tests.stored.small_campaigns import CASES, campaigns_of, some_effects, turns


@pytest.fixture(scope="module")
def found() -> Discovery:
    """Twelve dwells of a unit whose bias wanders, and a turn of each axis each way, twice."""
    case = CASES["wandering"]
    case = replace(case, bench={"turns": turns(30.0, 30.0)})
    return discover(diagnose(campaigns_of(case), some_effects(*case.tried)))


@pytest.fixture(scope="module")
def evidence(found: Discovery) -> Evidence:
    return found.evidence


def numbers(evidence: Evidence, kind: str) -> list[int]:
    return [i for i, step in enumerate(evidence.excitation.steps) if step.kind == kind]


@pytest.mark.parametrize("speed", [12.0, 80.0])
def test_a_turn_at_another_speed(evidence: Evidence, speed: float) -> None:
    seen, option = evidence.excitation, OPTIONS[f"turns_at_{speed:g}"]
    new, times = option.changed(seen), np.broadcast_to(option.times(seen), len(seen.steps))
    column, sigma = option.factors(evidence)
    rows = np.zeros(len(column), bool)
    rows[evidence.rows("turn")] = True
    for i in range(len(seen.steps)):
        nodes, own = seen.step == i, rows & (evidence.step == i)
        is_turn = i in numbers(evidence, "turn")
        slower = float(np.median(np.linalg.norm(seen.omega[nodes], axis=1))) / speed if is_turn else 1.0
        assert times[i] == pytest.approx(slower)
        assert np.allclose(new.omega[nodes] * slower, seen.omega[nodes])
        assert np.allclose(new.gyro_output[nodes] * slower, seen.gyro_output[nodes])
        assert np.allclose(new.rest_s[nodes], seen.rest_s[nodes] * slower)
        assert own.any() == is_turn
        assert np.allclose(column[own], slower)
    assert np.all(column[~rows] == 1)
    assert np.all(sigma == 1)


def test_rests_four_times_as_long(evidence: Evidence) -> None:
    """A mean's sigma falls with the root of the time, a slope's and a curvature's with one and two powers more."""
    option = OPTIONS["longer_rests"]
    assert np.array_equal(option.changed(evidence.excitation).rest_s, 4 * evidence.excitation.rest_s)
    assert option.times(evidence.excitation) == 4
    column, sigma = option.factors(evidence)
    for kind, of_column, of_sigma in (("mean", 1, 1 / 2), ("slope", 1 / 4, 1 / 8), ("curvature", 1 / 16, 1 / 32)):
        rows = evidence.rows(kind)
        assert len(column[rows])
        assert np.allclose(column[rows], of_column)
        assert np.allclose(sigma[rows], of_sigma)


def test_heated_by_fifteen_kelvin_from_begin_to_end(evidence: Evidence) -> None:
    seen = evidence.excitation
    new = OPTIONS["heated"].changed(seen)
    more, first, last = new.temperature - seen.temperature, seen.t.argmin(), seen.t.argmax()
    assert (more[first], more[last]) == (0, pytest.approx(15))
    slope = 15 / np.ptp(seen.t)  # K/s
    assert np.allclose(more, slope * (seen.t - seen.t.min()))
    assert np.allclose(new.temperature_rate - seen.temperature_rate, 60 * slope)  # K/min


def test_another_order_gives_each_dwell_the_time_of_another_in_a_warmer_room(evidence: Evidence) -> None:
    """Of twelve dwells in order, the i-th slot goes to dwell 5 i + 2, modulo twelve."""
    seen = evidence.excitation
    new = OPTIONS["another_order"].changed(seen)
    dwells = sorted(numbers(evidence, "dwell"), key=lambda i: float(seen.t[seen.step == i].min()))
    begins = [float(seen.t[seen.step == i].min()) for i in dwells]
    after = [float(new.t[seen.step == i].min()) for i in dwells]
    of = [(5 * i + 2) % 12 for i in range(12)]
    assert [after[dwell] for dwell in of] == pytest.approx(begins)
    assert np.allclose(new.temperature, seen.temperature + 5, atol=1e-6)  # the room's own hardly moves
    others = ~np.isin(seen.step, dwells)
    assert np.array_equal(new.t[others], seen.t[others])
    assert np.isnan(new.change[seen.step == dwells[of[0]]]).all()
    f = [seen.f[seen.step == i][0] for i in dwells]
    for before, dwell in pairwise(of):
        assert np.allclose(new.change[seen.step == dwells[dwell]], f[dwell] - f[before])


def alone(found: Discovery, monkeypatch: pytest.MonkeyPatch, name: str) -> NextMeasurement | None:
    with monkeypatch.context() as patched:
        patched.setattr(next_plan, "OPTIONS", {name: OPTIONS[name]})
        return next_measurement(found, found.proposals[0])


def test_the_cheapest_that_parts_most_is_taken_and_its_minutes_are_those_of_its_steps(
    found: Discovery, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Twelve dwells, 45 s of moving before each; of two turns about an axis one way one is made again."""
    taken = next_measurement(found, found.proposals[0])
    each = {name: one for name in OPTIONS if (one := alone(found, monkeypatch, name))}
    assert taken is not None
    assert taken in each.values()
    assert all((one.parted, -one.minutes) <= (taken.parted, -taken.minutes) for one in each.values())
    assert taken.parted == sum(chi2 >= 16 for chi2 in taken.expected)
    assert len(taken.expected) == len(found.proposals[0].readings)
    seen = found.evidence.excitation
    lasts = {i: float(np.ptp(seen.t[seen.step == i])) for i in range(len(seen.steps))}
    dwells = sum(lasts[i] for i in numbers(found.evidence, "dwell"))
    assert each["another_order"].minutes == pytest.approx((12 * 45 + dwells) / 60)
    of_six = sum(lasts[numbers(found.evidence, "turn")[i]] for i in (0, 1, 4, 5, 8, 9))  # + - + - of each axis
    assert each["heated"].minutes == pytest.approx((18 * 45 + dwells + of_six) / 60)


def test_no_reading_asks_for_no_measurement(found: Discovery) -> None:
    assert next_measurement(found, replace(found.proposals[0], readings=())) is None
