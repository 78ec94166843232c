"""A cube of one skew, whose agreement and drift are worked out on paper."""

from datetime import UTC, datetime, timedelta

import numpy as np

from procedures.campaign.campaign import MeasuredCube
from procedures.campaign.measured_cube import CubeMeasurement
from station.results.fixtures.measured_cube import CubeStudy, KnownCube, StoredMeasurement
from station.results.fixtures.measured_cube_text import study_text

FIRST = datetime(2025, 1, 1, tzinfo=UTC)
TWO_MONTHS = timedelta(days=365.25 / 6)


def skewed(urad: float, std: float, **more: float) -> CubeMeasurement:
    square = np.array([[(std * 1e-6) ** 2]])
    return CubeMeasurement(MeasuredCube(("skew.x.y",), np.array([urad * 1e-6]), square), square, (), **more)


def lines(urad: float, sources: str = "b", certificate: MeasuredCube | None = None) -> list[str]:
    """Return the text of a skew of so many urad, two months after one of 4 urad, both with 2 urad."""
    before = StoredMeasurement(FIRST, skewed(4.0, 2.0), frozenset("a"))
    study = CubeStudy(
        "CUBE-7", skewed(urad, 2.0, chi2=5.0, dof=3, p_value=0.17), FIRST + TWO_MONTHS,
        {"SIM 1": dict.fromkeys(sources, "") | {name: name for name in sources}}, ("a fan ran",),
        KnownCube(certificate, (before,)),
    )  # fmt: skip
    return [" ".join(line.split()) for line in study_text(study).splitlines()]


def test_values_are_in_urad_and_arcsec_and_what_was_not_seen_is_named() -> None:
    text = lines(10.0)
    assert text[0] == "cube CUBE-7, 2025-03-02, by SIM 1 (1); +- is the standard uncertainty u"
    assert "skew.x.y 10.0 +- 2.0 2.06 +- 0.41" in text  # 1 urad is 0.20626 arcsec
    assert "parallelism.x.y not determined" in text
    assert "consistency of the units and the K2 range: chi-square 5 at 3 degrees of freedom, p 0.17" in text
    assert "warning: a fan ran" in text


def test_a_cube_that_moved_is_said_to_have() -> None:
    assert lines(20.0)[-1] == "the cube has changed: skew.x.y (p 1.5e-08, Holm)"  # 16 urad: chi-square 32


def test_a_certificate_is_compared_by_the_sigma_of_both() -> None:
    known = MeasuredCube(("skew.x.y",), np.array([7e-6]), np.array([[1e-12]]))
    text = lines(10.0, certificate=known)
    # 3 urad of sqrt(4 + 1): chi-square 9 / 5
    assert "against the certificate of its faces: chi-square 1.8 of 1 values, p 0.18" in text
    assert "skew.x.y 3.0 +- 2.2 +1.3" in text


def test_measurements_that_share_a_campaign_are_not_compared() -> None:
    text = lines(10.0, sources="ab")
    said = "1 of 1 campaigns are the same: not independent, not used for the drift"
    assert text[-1] == f"against the measurement of 2025-01-01: {said}"
