import numpy as np
import pytest

from procedures.campaign.campaign import Campaign
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis, ResidualRms
from procedures.diagnosis.validation_campaigns import validate
from tests.benchmarks.diagnosing.designs import certified, unit

LEANING = {"gyroscope.g_sensitivity": {"xx": 0.15, "yz": -0.15}}


def campaigns(effects: dict[str, dict[str, float]], seed: int) -> tuple[Campaign, ...]:
    """Campaigns of one and the same unit, whatever the seed of the day."""
    return certified(unit(3, effects=effects), seed)


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    diagnosis = diagnose(campaigns(LEANING, 3))
    assert "gyroscope.g_sensitivity" in [finding.effect for finding in diagnosis.findings]
    return diagnosis


def dwells(errors: tuple[ResidualRms, ...]) -> ResidualRms:
    return next(each for each in errors if each.quantity == "gyroscope dwells")


def test_the_error_of_another_day_falls_by_an_effect_of_the_unit(found: Diagnosis) -> None:
    errors = dwells(validate(found, campaigns(LEANING, 1003)))
    assert errors.held_out_before is not None
    assert errors.held_out_after is not None
    assert errors.held_out_after < 0.7 * errors.held_out_before
    assert errors.after < 0.7 * errors.before
    assert errors.unit == "deg/h"


def test_it_rises_where_the_effect_is_not_there(found: Diagnosis) -> None:
    errors = dwells(validate(found, campaigns({}, 1003)))
    assert errors.held_out_before is not None
    assert errors.held_out_after is not None
    assert errors.held_out_after > 1.3 * errors.held_out_before


def test_a_seating_of_one_day_is_not_carried_to_another() -> None:
    seated = diagnose(campaigns({"placement.dwell": {"position": 5, "x": 3e-4, "y": 3e-4}}, 4))
    assert "placement.dwell" in [finding.effect for finding in seated.findings]
    for errors in validate(seated, campaigns({}, 1004)):
        assert errors.before == pytest.approx(errors.after, rel=1e-12)
        assert np.isfinite(errors.after)
