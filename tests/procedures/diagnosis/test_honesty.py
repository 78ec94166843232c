"""What stays after an effect is in: a cause leaves noise, a likeness leaves structure and is in doubt.

On rate tables, which hold nothing but a nonlinearity, so that what an effect explains is known beforehand.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis
from tests.procedures.diagnosis.test_rate_tables import NONLINEAR, campaign, table

LOST = "gyroscope.counts_lost"
Bend = Callable[[np.ndarray], np.ndarray]


def bent(seed: int, bend: Bend) -> Diagnosis:
    """Diagnose a table whose sensor adds ``bend`` [deg/s] of the rate [deg/s]."""
    plain = table(seed)
    return diagnose([campaign(replace(plain, output=plain.output - 2e4 * bend(plain.reference)[:, None]))])


def periodic(u: np.ndarray) -> np.ndarray:
    found: np.ndarray = 0.05 * np.sin(2 * np.pi * u / 80)
    return found


def worn(u: np.ndarray) -> np.ndarray:
    found: np.ndarray = 0.05 * np.tanh(u / 20)
    return found


def saturated(u: np.ndarray) -> np.ndarray:
    found: np.ndarray = 0.05 * np.clip(u / 20, -1, 1)
    return found


@pytest.mark.parametrize("bend", [periodic, worn])
def test_what_a_bend_of_the_catalogue_only_resembles_is_in_doubt(bend: Bend) -> None:
    """A curve that bends slowly, or a knee from which on more is put out, is no loss of counts."""
    found = bent(1, bend)
    assert found.verdict == "partly"
    assert {each.effect for each in found.findings} <= {*NONLINEAR, LOST}
    assert {each.confidence for each in found.findings} == {"ambiguous"}


def test_a_knee_in_the_scale_factor_is_found_where_it_is() -> None:
    """Of what lies above 20 deg/s 2500 ppm are lost."""
    found = bent(1, saturated)
    (finding,) = found.findings
    assert (finding.effect, finding.confidence) == (LOST, "established")
    share, knee = zip(finding.value, finding.std, strict=True)
    assert abs(share[0] - 2500) < 4 * share[1]
    assert abs(knee[0] - 20) < 4 * knee[1]


def test_what_explains_less_than_half_is_not_named() -> None:
    found = bent(1, lambda u: 0.05 * np.sign(np.sin(2 * np.pi * u / 13)))
    assert found.verdict == "unexplained"
    assert found.findings == ()
    assert found.left


def test_a_cause_that_explains_nearly_all_stands_though_something_small_is_left() -> None:
    found = bent(1, lambda u: 0.3 * (u / 100) ** 3 + 0.012 * np.sin(2 * np.pi * u / 40))
    assert found.verdict == "partly"
    assert {each.effect for each in found.findings} <= NONLINEAR
    assert len(found.findings) == 1
    assert found.findings[0].share == pytest.approx(0.974, abs=0.01)
