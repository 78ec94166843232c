import numpy as np
import pytest

from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.kalman_state import KalmanSettings
from procedures.attitude.sensor_noise import at_rest, gyro_noise, range_limit


def noisy(rate: float, force: float, seconds: float = 200.0, hz: float = 100.0) -> AttitudeLog:
    """Return white noise of so many rad/sqrt(s) and m/s/sqrt(s), on a turn and on gravity."""
    rng, n = np.random.default_rng(2), round(seconds * hz)
    omega = np.array([0.1, -0.2, 0.3]) + rate * np.sqrt(hz) * rng.standard_normal((n, 3))
    felt = np.array([0.0, 0.0, -9.8]) + force * np.sqrt(hz) * rng.standard_normal((n, 3))
    return AttitudeLog(np.arange(1, n + 1) / hz, omega, felt)


def test_noise_is_of_the_gyros_alone_whatever_the_bias() -> None:
    # the quietest second of 200 samples' variance: some tens of per cent below the mean
    assert 0.7e-4 < gyro_noise(noisy(1e-4, 1e-2)) < 1.1e-4


def test_a_rest_is_as_quiet_as_the_unit_and_never_quieter_than_a_bench() -> None:
    usual = KalmanSettings()
    loud = at_rest(usual, noisy(1e-4, 2e-3))
    assert 0.7e-4 < loud.rest_gyro_noise < 1.1e-4
    assert 1.4e-3 < loud.rest_force_noise < 2.2e-3
    assert loud.rest_bias_walk == pytest.approx(min(loud.rest_gyro_noise, usual.rest_bias_walk))
    quiet = at_rest(usual, noisy(0.0, 0.0))
    assert (quiet.rest_gyro_noise, quiet.rest_force_noise) == (1e-7, 2e-4)
    assert quiet.rest_bias_walk == pytest.approx(min(3e-6, usual.rest_bias_walk))


@pytest.mark.parametrize(
    ("rows", "limit"),
    [
        ([1.0, 5.0, 5.0, 5.0, 1.0], 5.0),
        ([1.0, -5.0, 5.0, -5.0, 1.0], 5.0),
        ([5.0, 5.0, 1.0, 5.0, 5.0], np.inf),
        ([1.0, 3.9, 3.9, 3.9, 1.0], np.inf),  # no unit clips below four
        ([5.0, 5.0, 4.999, 5.0, 1.0], np.inf),
    ],
)
def test_samples_clip_where_their_largest_stands_for_three_rows(rows: list[float], limit: float) -> None:
    samples = np.zeros((5, 3))
    samples[:, 1] = rows
    assert range_limit(samples, 4.0) == limit
