import numpy as np
import pytest

from procedures.attitude.attitude_estimate import estimate
from procedures.attitude.attitude_log import AttitudeLog, down_of
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.sensor_noise import at_rest, frozen_stretches, gyro_noise, range_limit


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


HZ, G = 100.0, 9.80665
FREEZE = 1000, 1150  # rows


def rolling(noise: float = 1.0, resolution: float = 0.0, amplitude: float = 0.6) -> AttitudeLog:
    """Return a body that rolls to and fro in place, by closed forms, with its truth."""
    rng, t = np.random.default_rng(4), np.arange(1, 3001) / HZ
    w = 2 * np.pi * 0.25
    roll, rate = amplitude * np.sin(w * t), np.zeros((len(t), 3))
    rate[:, 0] = amplitude * w * np.cos(w * (t - 0.5 / HZ))
    force = -G * down_of(amplitude * np.sin(w * (t - 0.5 / HZ)), np.zeros(len(t)))
    omega_b = rate + noise * 1e-3 * rng.standard_normal(rate.shape)
    f_b = force + noise * 2e-2 * rng.standard_normal(force.shape)
    if resolution:
        omega_b, f_b = resolution * np.round(omega_b / resolution), resolution * np.round(f_b / resolution)
    return AttitudeLog(t, omega_b, f_b, roll=roll, pitch=np.zeros(len(t)))


def frozen(log: AttitudeLog, rows: tuple[int, int] = FREEZE) -> AttitudeLog:
    for values in (log.omega_b, log.f_b):
        values[rows[0] : rows[1]] = values[rows[0] - 1]
    return log


def test_rows_that_repeat_are_found_whatever_the_resolution() -> None:
    assert frozen_stretches(rolling()) == []
    for resolution in (0.0, 5e-4):
        assert frozen_stretches(frozen(rolling(resolution=resolution))) == [slice(1000, 1150)]
    assert frozen_stretches(frozen(rolling(), (2850, 3000))) == [slice(2850, 3000)]
    assert frozen_stretches(frozen(rolling(), (1000, 1005))) == []  # 50 ms


@pytest.mark.parametrize(("noise", "resolution"), [(0.0, 0.0), (0.0, 1e-3), (0.2, 0.02)])
def test_what_repeats_itself_rightly_is_not_frozen(noise: float, resolution: float) -> None:
    log = rolling(noise, resolution)
    still = log.t < 10.0  # a rest, then motion
    log.omega_b[still], log.f_b[still] = 0.0, [0.0, 0.0, -G]
    assert frozen_stretches(log) == []


def test_a_frozen_stretch_widens_sigma_and_the_tilt_returns() -> None:
    log = frozen(rolling())
    track = estimate(log, "none")
    assert any("repeat the same values for 150 rows" in line for line in track.warnings)
    assert track.sigma is not None
    assert log.true_down is not None
    error = np.arccos(np.clip(np.sum(track.down * log.true_down, axis=1), -1, 1))
    assert len(track.down) == len(log.t)
    assert np.all(error[1000:] < 3 * track.sigma[1000:])
    assert np.degrees(error[2200:].max()) < 3.0
