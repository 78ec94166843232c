"""A verdict states each of its reasons as it was computed; a number that nobody computed is absent."""

import numpy as np
import pytest

from procedures.inference.result import Finding
from station.results.diagnosis.diagnosis_json import finding_document
from station.results.diagnosis.diagnosis_wording import EXCESS_TEXT, verdict_sentence


def finding(**changed: object) -> Finding:
    known: dict[str, object] = {
        "effect": "gyroscope.jump", "kind": "instrument", "coefficients": ("x",), "value": np.ones(1),
        "std": np.ones(1), "unit": "deg/h", "where": {}, "probability": 0.995, "separate_by": "",
    }  # fmt: skip
    return Finding(**(known | changed))  # type: ignore[arg-type]


def test_what_was_not_computed_is_absent() -> None:
    document = finding_document(finding())
    assert not {"log10_p", "share", "joint_probability", "shares", "error", "same_here"} & set(document)
    assert finding_document(finding(share=0.0))["share"] == 0.0


@pytest.mark.parametrize("code", list(EXCESS_TEXT))
def test_every_reason_is_reported_with_its_value(code: str) -> None:
    reason = {"code": code, "what": "gyroscope, time", "value": 0.123}
    document = {"log10_p": -9.0, "verdict": "unexplained", "findings": [], "reasons": [reason]}
    assert "{" not in verdict_sentence(document)


def test_one_of_two_causes_has_half_of_the_probability() -> None:
    one = finding().or_else("clock.rate")
    assert (one.probability, one.joint, one.aliases) == (0.4975, 0.995, ("clock.rate",))
    assert one.confidence == "possible"
