import itertools
from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.axes_check import disagreement, unit_by_motion
from procedures.attitude.mean_force import GravityCheck, gravity_check, rest_lengths, windows_of
from procedures.frames import rotation
from tests.drivers.simulated.vehicles import MEMS, VEHICLES, vehicle_log

G = 9.80665


def tumbling(seconds: float = 20.0, size: float = 1.0, seed: int = 5) -> AttitudeLog:
    """A body turned about all axes by hand, with a little shaking."""
    dt, rng = 0.01, np.random.default_rng(seed)
    t = np.arange(0, seconds, dt)
    phase = rng.uniform(0, 2 * np.pi, (2, 3))
    rate = size * (np.sin(0.7 * t[:, None] + phase[0]) + 0.5 * np.sin(1.9 * t[:, None] + phase[1]))
    C: FloatArray = np.eye(3)
    force = np.empty_like(rate)
    for i, turn in enumerate(rotation(rate * dt)):
        C = C @ turn
        force[i] = C.T @ np.array([0.0, 0.0, -G])
    return AttitudeLog(t, rate, force + 0.5 * rng.standard_normal(force.shape))


@pytest.mark.parametrize("signs", list(itertools.product((1.0, -1.0), repeat=3)))
def test_wrong_signs_are_named(signs: tuple[float, float, float]) -> None:
    log = tumbling()
    found = disagreement(replace(log, omega_b=log.omega_b * np.array(signs)))
    if min(signs) > 0:
        assert found is None
    else:
        assert found is not None
        assert found.reading == ",".join("-" * (s < 0) + name for s, name in zip(signs, "pqr", strict=True))
        assert found.units == ("rad/s",)


def test_exchanged_axes_and_degrees_are_named() -> None:
    log = tumbling()
    swapped = disagreement(replace(log, omega_b=log.omega_b[:, [1, 0, 2]]))
    assert swapped is not None
    assert swapped.reading == "q,p,r"
    degrees = disagreement(replace(log, omega_b=np.degrees(log.omega_b)))
    assert degrees is not None
    assert degrees.units == ("deg/s",)


def test_a_left_handed_accelerometer_is_noticed() -> None:
    log = tumbling()
    assert disagreement(replace(log, f_b=log.f_b * np.array([1.0, -1.0, 1.0]))) is not None


def rocking(size_deg: float, seconds: float = 60.0, noise: float = 0.1, seed: int = 3) -> AttitudeLog:
    """Roll and pitch of sines of 0.2 and 0.13 Hz, in phase by neither; exact rates of roll, pitch, roll."""
    t = np.arange(0, seconds, 0.02)
    roll, pitch = (
        np.radians(size_deg) * np.sin(0.4 * np.pi * t),
        np.radians(0.6 * size_deg) * np.sin(0.26 * np.pi * t),
    )
    dr = np.radians(size_deg) * 0.4 * np.pi * np.cos(0.4 * np.pi * t)
    dp = np.radians(0.6 * size_deg) * 0.26 * np.pi * np.cos(0.26 * np.pi * t)
    rate = np.stack([dr, dp * np.cos(roll), -dp * np.sin(roll)], axis=1)
    down = np.stack([-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)], axis=1)
    rng = np.random.default_rng(seed)
    return AttitudeLog(
        t, rate + 1e-4 * rng.standard_normal(rate.shape), -G * down + noise * rng.standard_normal(down.shape)
    )


@pytest.mark.parametrize("size_deg", [3.0, 20.0])
@pytest.mark.parametrize(
    ("factor", "unit"),
    [(180 / np.pi, "deg/s"), (1e3, "mrad/s"), (np.pi / 180, "rad/s converted from deg/s once too often")],
)
def test_a_wrong_unit_is_named_at_small_tilts(size_deg: float, factor: float, unit: str) -> None:
    log = rocking(size_deg)
    assert disagreement(log) is None
    found = disagreement(replace(log, omega_b=log.omega_b * factor))
    assert found is not None
    assert unit in found.units
    assert found.scale_std is None or abs(found.scale * factor - 1) < max(5 * found.scale_std * factor, 0.01)


@pytest.mark.parametrize("bias_deg_s", [5.0])
def test_a_bias_of_the_gyros_is_no_wrong_unit(bias_deg_s: float) -> None:
    log = rocking(8.0)
    biased = log.omega_b + np.radians(bias_deg_s) * np.array([1.0, -1.0, 0.5])
    assert disagreement(replace(log, omega_b=biased)) is None
    found = disagreement(replace(log, omega_b=np.degrees(biased)))
    assert found is not None
    assert found.units == ("deg/s",)


def test_increments_in_columns_of_rates_are_named() -> None:
    log = rocking(20.0)
    found = disagreement(replace(log, omega_b=log.omega_b * 0.02))
    assert found is not None
    assert "increments of angle in rad" in found.units
    assert found.scale == pytest.approx(50.0, rel=0.02)


@pytest.mark.parametrize("factor", [2.0, 0.5])
def test_a_wrong_full_scale_of_the_gyros_is_of_no_unit(factor: float) -> None:
    found = disagreement(replace(rocking(20.0), omega_b=factor * rocking(20.0).omega_b))
    assert found is not None
    assert found.units == ()
    assert found.scale == pytest.approx(1 / factor, rel=0.02)
    assert not found.is_by_lever_arm


@pytest.mark.parametrize(("seconds_pitch", "arm_m"), [(0.0, 8.0), (9.0, 12.0), (9.0, 25.0), (5.0, -4.0)])
def test_a_lever_arm_is_no_wrong_full_scale(seconds_pitch: float, arm_m: float) -> None:
    """A sensor ``arm_m`` above the centre of a roll of 0.2 Hz, alone or with a pitch of another frequency."""
    t = np.arange(0, 120, 0.02)
    roll = np.radians(10) * np.sin(0.4 * np.pi * t)
    pitch = np.radians(8) * np.sin(2 * np.pi / seconds_pitch * t) if seconds_pitch else 0 * t
    dr, dp = np.gradient(roll, t), np.gradient(pitch, t)
    rate = np.stack([dr, dp * np.cos(roll), -dp * np.sin(roll)], axis=1)
    down = np.stack([-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)], axis=1)
    arm = np.array([0.0, 0.0, -arm_m])
    force = -G * down + np.cross(np.gradient(rate, t, axis=0), arm) + np.cross(rate, np.cross(rate, arm))
    log = AttitudeLog(t, rate, force + 0.05 * np.random.default_rng(2).standard_normal(force.shape))
    found = disagreement(log)
    assert found is None or found.is_by_lever_arm


def test_rest_and_pure_yaw_say_nothing() -> None:
    n, rng = 3000, np.random.default_rng(1)
    t = np.arange(n) * 0.01
    force = np.array([0.0, 0.0, -G]) + 0.05 * rng.standard_normal((n, 3))
    rest = 1e-3 * rng.standard_normal((n, 3))
    yaw = rest + np.array([0.0, 0.0, 1.0]) * np.sin(t)[:, None]
    for rate in (rest, np.degrees(rest), yaw, np.degrees(yaw), -yaw):
        assert disagreement(AttitudeLog(t, rate, force)) is None


@pytest.mark.parametrize("share", [0.25, 1.5])
def test_a_swing_is_no_disagreement(share: float) -> None:
    """On a swing of length L a sensor at r feels g (1 - r / L) sin of the tilt: a scale of neither 1 nor a
    unit.
    """
    t = np.arange(0, 60, 0.01)
    angle = np.radians(20) * np.sin(2.5 * t)
    rate = np.stack([np.radians(20) * 2.5 * np.cos(2.5 * t), 0 * t, 0 * t], axis=1)
    lateral = -G * (1 - share) * np.sin(angle)
    force = np.stack([0 * t, lateral, -G * np.cos(angle) - share * rate[:, 0] ** 2], axis=1)
    force += 0.05 * np.random.default_rng(2).standard_normal(force.shape)
    assert disagreement(AttitudeLog(t, rate, force)) is None


@pytest.mark.parametrize("kind", sorted(VEHICLES))
def test_vehicles_agree_and_their_rates_in_deg_s_do_not(kind: str) -> None:
    log = vehicle_log(kind, 1, MEMS, 200.0)
    assert disagreement(log) is None
    found = disagreement(replace(log, omega_b=np.degrees(log.omega_b)))
    assert found is not None
    assert found.units == ("deg/s",)


def test_a_unit_that_nobody_knows_is_found_by_motion_alone() -> None:
    log = rocking(8.0)
    assert unit_by_motion(log) == "rad/s"
    assert unit_by_motion(replace(log, omega_b=np.degrees(log.omega_b))) == "deg/s"
    assert (
        unit_by_motion(replace(log, omega_b=131 * np.degrees(log.omega_b))) is None
    )  # counts of 250 deg/s in 16 bit
    assert (
        unit_by_motion(replace(log, omega_b=0.001 * np.random.default_rng(3).standard_normal(log.omega_b.shape)))
        is None
    )


def test_a_coordinated_turn_is_no_disagreement() -> None:
    """In flight the specific force stays along body z while the rates turn: no reading of them explains that."""
    n = 6000
    bank = np.radians(40) * np.sin(np.arange(n) * 2e-3)
    rate = np.stack([np.gradient(bank, 0.01), 0.3 * np.sin(bank) ** 2, 0.3 * np.sin(bank)], axis=1)
    force = np.stack([np.zeros(n), 0.5 * np.sin(np.arange(n) * 0.05), -G / np.cos(bank)], axis=1)
    force[:600] = [-6.0, 0.0, -8.0]
    assert disagreement(AttitudeLog(np.arange(n) * 0.01, rate, force)) is None


# Specific force from which gravity was removed is detected


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
