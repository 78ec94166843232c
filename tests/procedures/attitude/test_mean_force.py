"""Gravity in the mean force: there in every motion, not there where it was removed."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.mean_force import GravityCheck, gravity_check, rest_lengths, windows_of
from procedures.frames import rotation
from tests.drivers.simulated.vehicles import MEMS, VEHICLES, vehicle_log
from tests.procedures.attitude.test_axes_check import tumbling

G = 9.80665


def check(log: AttitudeLog) -> GravityCheck:
    return gravity_check(log, windows_of(log))


def shaken(size: float, hz: float, gravity: float, seconds: float = 40.0, seed: int = 1) -> AttitudeLog:
    """A body tumbled and shaken to and fro: accelerations of ``size`` [m/s2], level frame, of about ``hz``."""
    log = tumbling(seconds, 1.0, seed)
    t, rng = log.t, np.random.default_rng(seed)
    phase = rng.uniform(0, 2 * np.pi, 3)
    acceleration = size * np.sin(2 * np.pi * hz * np.array([1.0, 1.3, 0.8]) * t[:, None] + phase)
    C: FloatArray = np.eye(3)
    force = np.empty_like(acceleration)
    for i, turn in enumerate(rotation(log.omega_b * 0.01)):
        C = C @ turn
        force[i] = C.T @ (acceleration[i] - np.array([0.0, 0.0, gravity]))
    return AttitudeLog(t, log.omega_b, force + 0.05 * rng.standard_normal(force.shape))


@pytest.mark.parametrize("size", [0.0, 1.0, 30.0])
@pytest.mark.parametrize("hz", [2.0])
def test_gravity_is_missed_in_weak_and_strong_motion_alone_where_it_was_removed(size: float, hz: float) -> None:
    assert check(shaken(size, hz, 0.0)).is_absent
    seen = check(shaken(size, hz, G))
    assert not seen.is_absent
    assert seen.level == pytest.approx(G, abs=1.0)


@pytest.mark.parametrize("kind", sorted(VEHICLES))
def test_a_vehicle_has_gravity_and_without_it_has_none(kind: str) -> None:
    log = vehicle_log(kind, 2, MEMS, 120.0)
    assert not check(log).is_absent
    assert check(replace(log, f_b=log.f_b - log.f_b.mean(axis=0))).is_absent


def test_a_tilt_error_of_the_removed_gravity_leaves_it_absent() -> None:
    """An AHRS that is 6 deg off leaves 1 m/s2 of gravity, all along."""
    log = shaken(1.0, 2.0, G * np.sin(np.radians(6)))
    assert check(log).is_absent


def test_free_fall_for_a_moment_and_a_gyro_bias_are_no_missing_gravity() -> None:
    log = tumbling(30.0, 0.3)
    force = log.f_b.copy()
    force[1000:1080] = 0.0
    assert not check(replace(log, f_b=force)).is_absent
    assert not check(replace(log, omega_b=log.omega_b + np.radians([20.0, -15.0, 10.0]))).is_absent


def test_a_rest_has_the_length_of_gravity() -> None:
    n = 1000
    t = np.arange(n) * 0.01
    force = np.tile([0.0, 3.0, -np.sqrt(G**2 - 9)], (n, 1))
    rate = np.zeros((n, 3))
    rate[500:] = [0.0, 0.2, 0.0]  # it turns: no rest, whatever the force does
    assert rest_lengths(AttitudeLog(t, rate, force)) == pytest.approx([G] * 5)
