"""A bias that is new in each step, as the campaign states it, is in the uncertainty of the bias."""

from dataclasses import replace

import numpy as np

from procedures.calibration.joint_calibration import fit
from procedures.uncertainty.budget import budget
from procedures.units import STANDARD_GRAVITY
from tests.procedures.diagnosis.planted import planted

UNSETTLED = 1e-3 * STANDARD_GRAVITY  # m/s2, far above the noise of a dwell


def test_an_accelerometers_bias_is_known_no_better_than_twelve_draws_tell_and_about_as_one_does() -> None:
    campaign = planted(3)
    stated = replace(campaign, sigma=replace(campaign.sigma, unsettled_accelerometer=UNSETTLED))
    plain, wide = (
        {each.name: each.std for each in budget(fit([one])) if each.unit == "g"} for one in (campaign, stated)
    )
    assert wide.keys() == plain.keys() != set()
    for name, std in wide.items():
        assert 1e-3 / np.sqrt(12) < std < 1.2e-3, name
        assert std > 20 * plain[name]
