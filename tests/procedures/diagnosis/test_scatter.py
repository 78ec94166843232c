"""A looser procedure is found as what it is, as wide as it is, and before the instrument."""

import numpy as np
import pytest

from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis, Finding
from tests.benchmarks.diagnosing.designs import plain, two_speeds, unit

SCATTERS = ("placement.scatter", "procedure.closure", "procedure.heading")


def of_instrument(diagnosis: Diagnosis) -> list[Finding]:
    return [each for each in diagnosis.findings if each.kind == "instrument"]


@pytest.mark.parametrize(("name", "size"), [("placement.scatter", 3e-5), ("procedure.heading", 0.5)])
def test_seats_and_headings_that_scatter_are_named_with_their_size(name: str, size: float) -> None:
    diagnosis = diagnose(plain(unit(3, effects={name: {"value": size}}), 3))
    (scatter,) = (each for each in diagnosis.findings if each.effect in SCATTERS)
    assert (scatter.effect, scatter.confidence, scatter.kind) == (name, "likely", "procedure")
    assert abs(scatter.value[0] - size) < 4 * scatter.std[0]
    assert not of_instrument(diagnosis)


def test_six_turns_that_close_worse_are_a_group_led_by_the_closure_and_widen_the_sigma() -> None:
    truth = unit(3, effects={"procedure.closure": {"value": 0.08}})
    diagnosis = diagnose(plain(truth, 3))
    (closure,) = (each for each in diagnosis.findings if each.effect in SCATTERS)
    assert (closure.effect, closure.confidence) == ("procedure.closure", "ambiguous")
    assert "gyroscope.scale_asymmetry" in closure.aliases
    assert "three times the revolutions" in closure.separate_by
    assert not of_instrument(diagnosis)
    std = [s.gyroscope.scale_factor.std for s in (diagnosis.solution_before, diagnosis.solution)]
    assert np.all(std[1] > 2.0 * std[0])
    assert np.all(np.abs(diagnosis.solution.gyroscope.scale_factor.value - truth.gyro_k) < 4 * std[1])


def test_an_asymmetry_that_two_speeds_show_is_no_closure() -> None:
    truth = unit(4, effects={"gyroscope.scale_asymmetry": {"y": 150.0}})
    (asymmetry,) = of_instrument(diagnose(two_speeds(truth, 4)))
    assert (asymmetry.effect, asymmetry.confidence) == ("gyroscope.scale_asymmetry", "established")
