"""A certificate says what its model lacks, what it takes as zero and what nobody measured."""

from typing import Any

import numpy as np
import pytest

from procedures.dwells_and_turns.bench_parameters import SLAB_TILT_RANGE_RAD
from station.results.certificate.model_statement import (
    SLAB_RANGE_DEG,
    diagnosis_said,
    is_simulated,
    residual_said,
    stated,
    taken_as_zero,
)

QUADRATIC = {"effect": "accelerometer.quadratic", "confidence": "ambiguous", "aliases": ["fixture.parallelism"]}
WARNING = "the residual is larger (chi-square 90 at 30): the sigmas are too small; run `station diagnose`"
K2 = "accelerometer.quadratic"


def budget(source: str) -> dict[str, Any]:
    part = {"source": source, "type": "B", "std": 2e-3}
    return {"parameters": [{"name": "accelerometer.scale_factor.x", "value": 100.0, "contributions": [part]}]}


def test_what_a_campaign_cannot_tell_apart_is_said() -> None:
    said = diagnosis_said({"diagnosis": {"verdict": "ambiguous", "findings": [QUADRATIC]}})
    expected = "Not told apart by this campaign: quadratic term of the accelerometers (K2) or cube parallelism."
    assert said == ["Diagnosis of the residual: ambiguous.", expected]
    assert "noise leaves" in diagnosis_said({"diagnosis": {"verdict": "consistent", "findings": []}})[1]
    assert "no known effect" in diagnosis_said({"diagnosis": {"verdict": "unexplained", "findings": []}})[1]
    assert diagnosis_said({}) == ["No diagnosis of the residual is stored with this calibration."]


def test_an_effect_of_a_file_is_said_with_its_term_and_hash() -> None:
    one = {"name": "gyroscope.dead_zone", "term": ["-u * exp(-(u / w)**4)"], "unit": "1", "sha256": "ab" * 32}
    (said, _) = diagnosis_said({"effects": [{**one, "definition": "..."}, {"name": "gyroscope.magnetic"}]})
    assert said.startswith("Also in the model: gyroscope.dead_zone, c (-u * exp(-(u / w)**4)), c in 1, ")
    assert "ab" * 32 in said


def test_what_is_taken_as_zero_is_said_once_and_not_if_carried() -> None:
    document: dict[str, Any] = {"procedure": {}, "accelerometer": {}}
    assert taken_as_zero(document) == [K2, "accelerometer.scale_asymmetry"]
    assert taken_as_zero({**document, "effects": [{"name": K2}]}) == ["accelerometer.scale_asymmetry"]
    steps = {"not_observable": [f"{K2} (with accelerometer.bias)"]}
    assert taken_as_zero({**document, "procedure": steps})[1:] == ["accelerometer.scale_asymmetry"]


@pytest.mark.parametrize("source", ["unexplained", "cube"])
def test_a_warning_to_the_operator_is_not_printed_to_the_customer(source: str) -> None:
    said = residual_said({"uncertainty": budget(source)}, WARNING)
    assert said.startswith("the residual is larger (chi-square 90 at 30)")
    assert "station diagnose" not in said
    assert said.endswith("is part of U") == (source == "unexplained")
    assert residual_said({}, "gyroscope not solved: no turn about x") == "gyroscope not solved: no turn about x"


def test_what_is_stated_has_its_value() -> None:
    lines = dict(stated({"procedure": {"heading_std_deg": 0.05}, "uncertainty": budget("clock")}))
    assert lines["Heading of a position"] == "1\u03c3 0.05\u00b0"
    assert "1\u03c3 2e-05, a stated value" in lines["Time base"]
    assert np.isclose(np.degrees(SLAB_TILT_RANGE_RAD), SLAB_RANGE_DEG, rtol=0.02)


def test_a_simulated_device_is_known_by_its_model() -> None:
    assert is_simulated({"model": "SIM-FOG3"})
    assert not is_simulated({"model": "FOG-3"})
