import numpy as np
import pytest

from procedures.attitude.attitude_estimate import estimate
from procedures.attitude.attitude_log import AttitudeLog, earth_rate_ned
from procedures.attitude.unaided_motion import heading_at_rest
from procedures.earth.geodesy import EARTH_RATE
from procedures.frames import rotation
from procedures.units import RAD_S_PER_DEG_H

LATITUDE = 0.7
G = 9.80665


def rest(heading: float, bias_deg_h: float, seed: int, seconds: float = 60.0) -> AttitudeLog:
    """A rest 3 deg nose up and 5 deg right down, of gyros with a bias of ``bias_deg_h`` (1 sigma)."""
    n, rng = round(seconds / 0.01), np.random.default_rng(seed)
    C = rotation(np.array([0, 0, heading])) @ rotation(np.array([0, 0.05, 0])) @ rotation(np.array([0.09, 0, 0]))
    rate = C.T @ earth_rate_ned(LATITUDE) + bias_deg_h * RAD_S_PER_DEG_H * rng.standard_normal(3)
    noise = 2e-5 * rng.standard_normal((n, 3))
    return AttitudeLog(np.arange(n) * 0.01, rate + noise, np.tile(C.T @ [0, 0, -G], (n, 1)))


@pytest.mark.parametrize("heading", [0.0, 1.0, 2.5, -2.0])
def test_a_calibrated_unit_at_rest_finds_north_within_its_sigma(heading: float) -> None:
    z = []
    for seed in range(20):
        found = heading_at_rest(rest(heading, 0.5, seed), LATITUDE, 0.5 * RAD_S_PER_DEG_H)
        assert found is not None
        z.append(((found[0] - heading + np.pi) % (2 * np.pi) - np.pi) / found[1])
    assert np.abs(z).max() < 4
    assert np.std(z) == pytest.approx(1, abs=4 / np.sqrt(2 * 20))


def test_gyros_too_poor_or_a_rest_too_short_say_nothing() -> None:
    assert heading_at_rest(rest(1.0, 50.0, 1), LATITUDE, 50 * RAD_S_PER_DEG_H) is None
    assert heading_at_rest(rest(1.0, 0.1, 1, 20.0), LATITUDE, 0.1 * RAD_S_PER_DEG_H) is None
    turning = rest(1.0, 0.1, 1)
    turning.omega_b[1000:] += [0.0, 0.0, 0.1]
    assert heading_at_rest(turning, LATITUDE, 0.1 * RAD_S_PER_DEG_H) is None


def test_the_heading_found_takes_the_horizontal_earth_rate_off() -> None:
    log = rest(1.0, 0.0, 3, 300.0)
    known = estimate(log, "none", latitude=LATITUDE, gyro_bias_std=0.1 * RAD_S_PER_DEG_H)
    assert np.linalg.norm(known.gyro_bias) < 0.05 * EARTH_RATE
    unknown = estimate(log, "none")
    assert np.linalg.norm(unknown.gyro_bias) > 0.3 * EARTH_RATE
