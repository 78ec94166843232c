import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.frames import rotation
from procedures.units import RAD_S_PER_DEG_H, STANDARD_GRAVITY
from tests.drivers.simulated.flight import LEVEL_S, PERIOD_S, paper_flight, sensor_errors


def strapdown(C: FloatArray, rate: FloatArray, force: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Attitude and velocity change by plain integration, half of each turn at a time."""
    v = np.zeros(3)
    for w, f in zip(rate, force, strict=True):
        half = rotation(0.5 * w * PERIOD_S)
        v += (C @ half @ f + [0, 0, STANDARD_GRAVITY]) * PERIOD_S
        C = C @ half @ half
    return C, v


def test_the_turn_changes_heading_by_90_deg_and_its_sensors_integrate_to_it() -> None:
    clean = paper_flight(0, 50.0)
    gyro, force = sensor_errors(np.random.default_rng(0), len(clean.t))
    C, change = strapdown(rotation(np.array([0.0, np.radians(3.0), 0.0])), clean.omega_b - gyro, clean.f_b - force)
    assert clean.true_down is not None
    assert C[2] == pytest.approx(clean.true_down[-1], abs=1e-5)
    course = np.radians(1.8) * 45.0  # 5 s each to roll in and out count half
    assert change == pytest.approx(200 * np.array([np.cos(course) - 1, np.sin(course), 0.0]), abs=0.01)
    assert clean.roll is not None
    assert np.degrees(clean.roll.max()) == pytest.approx(32.6, abs=0.1)
    assert (np.abs(clean.roll[clean.t < LEVEL_S]) < 1e-12).all()


def test_the_errors_are_those_of_table_1() -> None:
    first, growth = np.empty((300, 3)), np.empty((300, 3))
    for seed in range(300):
        gyro, _ = sensor_errors(np.random.default_rng(seed), 1000)
        first[seed], growth[seed] = gyro[0], gyro[-1] - gyro[0]
    assert first.std() / RAD_S_PER_DEG_H == pytest.approx(50, rel=4 / np.sqrt(2 * 900))
    assert growth.std() / RAD_S_PER_DEG_H == pytest.approx(10 * np.sqrt(9.99 / 3600), rel=4 / np.sqrt(2 * 900))
