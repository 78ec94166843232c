"""A planned campaign's noise in the units that its keys say."""

import numpy as np
import pytest

from procedures.planning.unit_noise import UnitNoise
from station.results.planning.plan_json import noise_table


def test_noise_is_by_axis_in_deg_per_root_hour_and_the_wander_in_deg_per_hour() -> None:
    noise = UnitNoise(np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 3.0]), np.ones(3), np.ones(3), 2e-6)
    found = noise_table(noise)
    assert found["accelerometer_g_sqrt_s"] == {"x": 1.0, "y": 2.0, "z": 3.0}
    assert found["gyroscope_deg_sqrt_h"]["y"] == pytest.approx(120.0)  # deg/sqrt(s), 60 sqrt(s) in a sqrt(h)
    assert found["wander_deg_h"] == pytest.approx(7.2e-3)
