import itertools
from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.axes_check import disagreement
from procedures.frames import rotation

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
        assert not found.in_degrees


def test_exchanged_axes_and_degrees_are_named() -> None:
    log = tumbling()
    swapped = disagreement(replace(log, omega_b=log.omega_b[:, [1, 0, 2]]))
    assert swapped is not None
    assert swapped.reading == "q,p,r"
    degrees = disagreement(replace(log, omega_b=np.degrees(log.omega_b)))
    assert degrees is not None
    assert degrees.in_degrees


def test_a_left_handed_accelerometer_is_noticed() -> None:
    log = tumbling()
    assert disagreement(replace(log, f_b=log.f_b * np.array([1.0, -1.0, 1.0]))) is not None


def test_less_than_20_deg_of_rotation_says_nothing() -> None:
    log = tumbling(size=0.02)
    assert disagreement(replace(log, omega_b=-log.omega_b)) is None


def test_a_coordinated_turn_is_no_disagreement() -> None:
    """In flight the specific force stays along body z while the rates turn: no reading of them explains that."""
    n = 6000
    bank = np.radians(40) * np.sin(np.arange(n) * 2e-3)
    rate = np.stack([np.gradient(bank, 0.01), 0.3 * np.sin(bank) ** 2, 0.3 * np.sin(bank)], axis=1)
    force = np.stack([np.zeros(n), 0.5 * np.sin(np.arange(n) * 0.05), -G / np.cos(bank)], axis=1)
    force[:600] = [-6.0, 0.0, -8.0]
    assert disagreement(AttitudeLog(np.arange(n) * 0.01, rate, force)) is None


def test_three_windows_are_enough_and_two_are_none() -> None:
    log = tumbling(3.0, size=2.0)
    backwards = replace(log, omega_b=-log.omega_b)
    found = disagreement(backwards)
    assert found is not None
    assert found.reading == "-p,-q,-r"
    short = AttitudeLog(log.t[:299], -log.omega_b[:299], log.f_b[:299])
    assert disagreement(short) is None
