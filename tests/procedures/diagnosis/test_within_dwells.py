"""What stays unexplained is in the uncertainty, also where only the dwells' insides show it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis
from procedures.uncertainty import sources
from procedures.uncertainty.budget import ParameterBudget, budget
from procedures.uncertainty.given_values import GivenValues, Unexplained
from tests.benchmarks.diagnosing.designs import certified, unit
from tests.procedures.diagnosis.planted import wandering


@cache
def diagnosed(size: float) -> Diagnosis:
    truth = replace(unit(3), slab_tilt_rad=np.zeros(2), faces_rad=np.zeros((6, 2)))
    (campaign,) = certified(truth, 3)
    return diagnose([wandering(campaign, 3, size)])


def bias_x(found: Diagnosis, unexplained: dict[str, Unexplained] | None) -> ParameterBudget:
    wanted = "accelerometer.bias.x"
    return next(one for one in budget(found.after, GivenValues(unexplained=unexplained)) if one.name == wanted)


def test_a_ramp_that_no_effect_explains_widens_the_uncertainty_though_the_means_fit() -> None:
    found = diagnosed(0.02)
    assert found.verdict == "unexplained"
    assert found.unexplained is not None
    assert found.unexplained["accelerometer"].within > 1
    plain, widened = bias_x(found, None), bias_x(found, dict(found.unexplained))
    assert sources.UNEXPLAINED not in {part.source for part in plain.contributions}
    (part,) = [part for part in widened.contributions if part.source == sources.UNEXPLAINED]
    counting = next(part for part in plain.contributions if part.source == sources.COUNTING)
    assert part.std > 0.5 * np.sqrt(found.unexplained["accelerometer"].within) * counting.std
    assert widened.std**2 == pytest.approx(plain.std**2 + part.std**2)


def test_without_it_nothing_is_left_and_nothing_is_added() -> None:
    found = diagnosed(0.0)
    assert found.verdict != "unexplained"
    assert found.unexplained is None
