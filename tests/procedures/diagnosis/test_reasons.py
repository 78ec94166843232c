"""A verdict states each of its reasons as it was computed; a number that nobody computed is absent."""

import numpy as np
import pytest

from procedures.anomalies.channel_faults import clipped_channels
from procedures.campaign.campaign import Campaign, RestRecord, Site
from procedures.counts.sample_records import RateSeries
from procedures.inference.result import Finding, probability_of
from station.results.diagnosis.diagnosis_json import finding_document
from station.results.diagnosis.diagnosis_wording import EXCESS_IN_WORDS, verdict_sentence


def finding(**changed: object) -> Finding:
    known: dict[str, object] = {
        "effect": "gyroscope.jump", "kind": "instrument", "coefficients": ("x",), "value": np.ones(1),
        "std": np.ones(1), "unit": "deg/h", "where": {}, "probability": 0.995, "separate_by": "", "log_p": -20.0,
    }  # fmt: skip
    return Finding(**(known | changed))  # type: ignore[arg-type]


def test_what_was_not_computed_is_absent() -> None:
    document = finding_document(finding(log_p=None))
    assert not {"log10_p", "share", "joint_probability", "shares", "error", "same_here"} & set(document)
    assert finding_document(finding(share=0.0))["share"] == 0.0


def test_a_channel_at_the_end_of_its_range_has_no_p() -> None:
    rng = np.random.default_rng(1)
    gyro = np.minimum(rng.normal(size=(4000, 3)), [0.5, 9.0, 9.0])
    t = 0.1 * np.arange(4000)
    series = RateSeries(t, gyro, None, np.full(4000, np.nan), 0.1)
    rests = (RestRecord("log", None, series),)
    (found,) = clipped_channels([Campaign("m", "s", False, Site(0.8, 9.8, 0.01), (), (), rests=rests)])
    assert found.log_p is None


@pytest.mark.parametrize("code", list(EXCESS_IN_WORDS))
def test_every_reason_is_said_with_its_value(code: str) -> None:
    reason = {"code": code, "what": "gyroscope, time", "value": 0.123}
    document = {"log10_p": -9.0, "verdict": "unexplained", "findings": [], "reasons": [reason]}
    assert "{" not in verdict_sentence(document)


@pytest.mark.parametrize(("log_p", "least", "most"), [(-30.0, 0.999, 1.0), (-7.0, 0.97, 0.99), (-0.5, 0.5, 0.5)])
def test_a_p_is_no_more_than_the_probability_that_its_bound_leaves(
    log_p: float, least: float, most: float
) -> None:
    assert least <= probability_of(log_p) <= most
    bound = -np.e * np.exp(log_p) * log_p  # Sellke, Bayarri and Berger 2001, equation 3
    if log_p < -1:
        assert probability_of(log_p) == pytest.approx(1 / (1 + bound))


def test_one_of_two_causes_has_half_of_the_probability() -> None:
    one = finding().or_else("clock.rate")
    assert (one.probability, one.joint, one.aliases) == (0.4975, 0.995, ("clock.rate",))
    assert one.confidence == "possible"
