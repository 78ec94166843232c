"""What acts sample by sample, in a soak of rates whose samples are known to the last digit."""

import numpy as np
from scipy.signal import lfilter

from procedures.campaign.campaign import Campaign, Site, SoakRecord
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.sample_effects import sample_effects
from procedures.diagnosis.single_channels import single_channels
from tests.stored.held import assert_held

N, PERIOD = 12_000, 0.01


def soak() -> Campaign:
    """Gyroscope z periodic in a ramp that wraps, x in an angle that does not; an accelerometer that lags."""
    rng, t = np.random.default_rng(1), PERIOD * np.arange(1, N + 1)
    turns = (3.7 * t + 1e-3 * np.cumsum(rng.normal(size=N))) % 1.0
    angle = np.cumsum(0.3 + 0.05 * rng.normal(size=N))
    current = lfilter([1], [1, -0.9], rng.normal(size=N))
    shaking = np.abs(np.sin(2 * np.pi * t / 17)) * rng.normal(size=N)
    gyro, accel = rng.normal(size=(N, 3)), rng.normal(size=(N, 3))
    gyro[:, 2] += 0.2 * np.cos(2 * np.pi * turns) + 0.1 * np.sin(4 * np.pi * turns)
    gyro[:, 0] += 0.25 * np.cos(np.radians(6 * angle)) + 0.02 * (t - 60) ** 2 / 60
    gyro[:, 1] += 0.3 * np.sin(2 * np.pi * 7.3 * t)
    accel[3:, 1] += 0.06 * current[:-3]
    accel[:, 2] += 3.0 * shaking
    accel[:, 0] += 0.3 * (3.0 * shaking) ** 2
    extra = {"aux_ramp": 360 * turns, "aux_motor": angle, "aux_current": current}
    series = RateSeries(t, gyro, accel, 25 + 0.02 * t, PERIOD, extra=extra)
    return Campaign("m", "s", False, Site(0.8, 9.8, 0.02), (), (), soaks=(SoakRecord("soak", 0, None, series),))


def test_what_acts_sample_by_sample() -> None:
    found = sample_effects([soak()], {"gyroscope": np.ones(3), "accelerometer": np.ones(3)})
    assert_held("diagnosis", "samples", found)
    assert_held("diagnosis", "single channels", single_channels([soak()], ()))
