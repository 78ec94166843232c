"""What a calibration's sigmas come to in the filter, worked out by hand from one whose axes differ."""

from typing import Any

import numpy as np
import pytest

from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.kalman.kalman_settings import AIDED_SETTINGS, UNAIDED_SETTINGS
from station.calibrated.filter_settings import filter_settings, force_bias_std, gyro_bias_std

EARTH = 7.292115e-5  # rad/s
DEG_H = np.pi / 180 / 3600
STILL = AttitudeLog(np.arange(1, 401) / 100, np.zeros((400, 3)), np.tile([0.0, 0.0, -9.8], (400, 1)))


def calibration(**accelerometer: list[float]) -> dict[str, Any]:
    off = [[None, 2e-5, 1e-5], [3e-5, None, 1e-5], [1e-5, 1e-5, None]]
    zero = {"bias": [0.0] * 3, "scale_factor": [0.0] * 3} | accelerometer
    return {
        "gyroscope": {
            "scale_factor": {"value": [-2e4, 1e4, 1e4], "std": [4.0, 1.0, 1.0]},  # 200 ppm at most
            "misalignment": {"std": off}, "bias": {"std": [0.1, 3.0, 0.2]},
        },
        "accelerometer": {
            "scale_factor": {"value": [1000.0, -1000.0, 500.0], "std": zero["scale_factor"]},
            "misalignment": {"std": [[None, 0, 0], [0, None, 0], [0, 0, None]]}, "bias": {"std": zero["bias"]},
        },
    }  # fmt: skip


def test_a_gyros_bias_is_known_to_its_sigma_and_a_degree_an_hour_of_turning_it_on() -> None:
    assert gyro_bias_std(calibration()) == pytest.approx(np.hypot(3.0, 1.0) * DEG_H)


def test_an_accelerometers_error_across_gravity_is_of_bias_scale_factor_and_misalignment() -> None:
    g = 9.80665
    assert force_bias_std(calibration(bias=[1e-4, 2e-4, 2e-4])) == pytest.approx(g * 1e-4 * np.sqrt(3))
    # 0.2 and 0.4 per mille at 45 degrees: half of it
    assert force_bias_std(calibration(scale_factor=[0.2, 0.2, 0.2])) == pytest.approx(g * 0.5e-4 * np.sqrt(8))
    turned = calibration()
    turned["accelerometer"]["misalignment"]["std"] = turned["gyroscope"]["misalignment"]["std"]
    assert force_bias_std(turned) == pytest.approx(g * 1e-5 * np.sqrt(17 / 6))


def test_without_a_calibration_a_gyros_bias_has_the_earths_rate_with_it() -> None:
    found = filter_settings(None, "airspeed", STILL, 9.79, np.radians(30.0), knows_heading=True)
    assert found.gyro_bias_std == pytest.approx(np.hypot(AIDED_SETTINGS.gyro_bias_std, EARTH), rel=1e-12)
    assert (found.gravity, found.nominal_s, found.gyro_noise) == pytest.approx((9.79, 0.01, 1e-7))
    # north, and down: half of the rate at 30 degrees
    assert (found.earth_north, found.earth_down) == pytest.approx((EARTH * np.sqrt(3) / 2, -EARTH / 2))
    assert found.force_bias_std == AIDED_SETTINGS.force_bias_std
    assert filter_settings(None, "none", STILL, 9.79, None, False).force_noise == UNAIDED_SETTINGS.force_noise
    assert filter_settings(None, "none", STILL, 9.79, None, False).earth_north == 0.0


@pytest.mark.parametrize(
    ("latitude", "knows_heading", "unseen"), [(0.5, True, 0.0), (0.5, False, EARTH), (None, True, EARTH)]
)
def test_the_earths_rate_is_unseen_without_a_place_and_a_heading(
    latitude: float | None, knows_heading: bool, unseen: float
) -> None:
    found = filter_settings(calibration(), "gnss", STILL, 9.8, latitude, knows_heading)
    assert found.unseen_rate == pytest.approx(unseen)
    assert found.gyro_bias_std == pytest.approx(np.hypot(np.sqrt(10) * DEG_H, unseen))


def test_a_calibrated_unit_is_believed_by_its_sigmas() -> None:
    found = filter_settings(calibration(bias=[1e-4] * 3), "gnss", STILL, 9.8, 0.5, True, quantum=2.0)
    assert found.gyro_scale_std == found.gyro_noise_per_rate == pytest.approx(2e-4 + 3e-5)
    assert found.force_bias_std == pytest.approx(9.80665e-4)
    assert (found.gyro_bias_walk, found.rest_bias_walk, found.force_bias_walk) == (1e-6, 1e-6, 1e-6)
    assert found.rest_force_noise == 2e-4  # nothing moves: a bench is never quite quiet
    # 2 m/s2 of a sample of 10 ms: evenly within 0.02 m/s
    assert found.rest_velocity_noise == pytest.approx(0.02 / np.sqrt(12))
    assert filter_settings(calibration(), "gnss", STILL, 9.8, 0.5, True).rest_velocity_noise == 1e-3
    assert filter_settings(calibration(), "gnss", STILL, 9.8, 0.5, True).force_bias_std == 1e-5
