"""What each further measurement changes of the steps that were made, reckoned by hand; and which one is taken."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.residual_rows import Evidence
from procedures.discovery import next_plan
from procedures.discovery.discover import Discovery, discover
from procedures.discovery.next_plan import OPTIONS, NextMeasurement, next_measurement
from tests.stored.diagnosis_told import some_effects
from tests.stored.test_small_diagnoses import CASES, campaigns_of, turns


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
