"""A verdict states each of its reasons as it was computed; a number that nobody computed is absent."""

import numpy as np
import pytest

from procedures.campaign.campaign import Campaign, RestRecord, Site
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.clipped_channels import clipped_channels
from procedures.diagnosis.result import Because, Finding
from station.results.diagnosis.diagnosis_json import finding_document
from station.results.diagnosis.diagnosis_wording import (
    REASONS_SAID,
    confidence_said,
    reason_said,
)


def finding(**changed: object) -> Finding:
    known: dict[str, object] = {
        "effect": "gyroscope.jump", "kind": "instrument", "coefficients": ("x",), "value": np.ones(1),
        "std": np.ones(1), "unit": "deg/h", "where": {}, "confidence": "established", "aliases": (),
        "separate_by": "", "log_p": -20.0, "gain": 1.0,
    }  # fmt: skip
    return Finding(**(known | changed))  # type: ignore[arg-type]


def test_what_was_not_computed_is_absent() -> None:
    document = finding_document(finding(log_p=None))
    assert not {"log10_p", "share", "sign_flip_p", "reasons", "same_here"} & set(document)
    assert finding_document(finding(share=0.0))["share"] == 0.0


def test_a_channel_at_the_end_of_its_range_has_no_p() -> None:
    rng = np.random.default_rng(1)
    gyro = np.minimum(rng.normal(size=(4000, 3)), [0.5, 9.0, 9.0])
    t = 0.1 * np.arange(4000)
    series = RateSeries(t, gyro, None, np.full(4000, np.nan), 0.1)
    rests = (RestRecord("log", None, series),)
    (found,) = clipped_channels([Campaign("m", "s", False, Site(0.8, 9.8, 0.01), (), (), rests=rests)])
    assert found.log_p is None


@pytest.mark.parametrize("code", list(REASONS_SAID))
def test_every_reason_is_said_with_its_value(code: str) -> None:
    said = reason_said({"code": code, "what": "gyroscope, time", "value": 0.123})
    assert "{" not in said
    assert said in confidence_said(finding_document(finding().doubted(Because(code), "gyroscope, time", 0.123)))
