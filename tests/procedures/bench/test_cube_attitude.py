"""A cube that is carried is followed; positions are written a second time in `tests.procedures.independent`."""

from itertools import pairwise

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.bench.cube_attitude import (
    CubeAttitude,
    heading_to_position,
    propagated,
    tilt_corrected,
)
from procedures.frames import rotation, vertical_rotation
from procedures.geodesy import EARTH_RATE
from procedures.gyrocompass import CertainDwell, earth_heading
from procedures.positions import face_normal, face_of
from procedures.units import RAD_S_PER_DEG_H
from tests.procedures.independent import body_from_level

K = 2e6  # count/rad
CHINA = np.radians(31.17)
STD = np.full(3, K * 0.05 * RAD_S_PER_DEG_H)
POSITIONS = range(1, 13)


def in_position(position: int, off: float = 0.0) -> FloatArray:
    """Return ``C_lb`` of a cube ``off`` [rad] counter-clockwise of a position."""
    C_lb: FloatArray = vertical_rotation(off) @ body_from_level(position).T
    return C_lb


def way(start: FloatArray, end: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return the rotation vectors (n, 3), cube axes, of a hand that takes a cube from one attitude to another."""
    stops = [start, *(rotation(rng.normal(0, 0.8, 3)) @ start for _ in range(2)), end]
    steps = []
    for a, b in pairwise(stops):
        total = a.T @ b
        angle = np.arccos(np.clip((np.trace(total) - 1) / 2, -1, 1))
        axis = np.array([total[2, 1] - total[1, 2], total[0, 2] - total[2, 0], total[1, 0] - total[0, 1]])
        if np.linalg.norm(axis) < 1e-9:  # half a turn
            axis = np.linalg.svd(total - np.eye(3))[2][-1]
        steps += [axis / np.linalg.norm(axis) * angle / 40] * 40
    return np.array(steps)


@pytest.mark.parametrize("end", POSITIONS)
@pytest.mark.parametrize("start", [1, 4, 11])
def test_a_cube_carried_any_way_stands_where_it_was_put(start: int, end: int) -> None:
    rng = np.random.default_rng(start * 100 + end)
    there = propagated(CubeAttitude(in_position(start), 0.0), way(in_position(start), in_position(end), rng))
    assert np.allclose(there.C_lb, in_position(end), atol=1e-6)
    assert abs(heading_to_position(there, end)) < 1e-6


def test_the_sigma_of_the_heading_is_that_of_its_errors() -> None:
    """Gyros off square by 0.5 deg, scale off by 3 %: 300 ways of a hand, levelled by gravity at the end."""
    errors = []
    for seed in range(300):
        rng = np.random.default_rng(seed)
        start, end = rng.integers(1, 13, 2)
        heading_fix_std, k_std = np.radians(2.0), 0.03
        begun = in_position(start, rng.normal(0, heading_fix_std))
        gyros = (np.eye(3) + rng.normal(0, 0.005, (3, 3))) * (1 + rng.normal(0, k_std))
        seen = way(begun, in_position(end), rng) @ gyros.T
        now = tilt_corrected(
            propagated(CubeAttitude(in_position(start), heading_fix_std), seen), face_normal(face_of(end)), 1.0
        )
        errors.append(heading_to_position(now, end) / now.heading_std(k_std))
    assert 0.4 < np.std(errors) < 1.25  # the path's share is the most that misaligned gyros may add
    assert np.max(np.abs(errors)) < 4.5


@pytest.mark.parametrize("off", np.radians([-176.0, -90.0, -4.0, 0.0, 30.0, 90.0, 176.0]))
@pytest.mark.parametrize("position", POSITIONS)
def test_how_far_to_turn_is_counted_counter_clockwise_seen_from_above(position: int, off: float) -> None:
    assert heading_to_position(CubeAttitude(in_position(position, -off), 0.0), position) == pytest.approx(
        off, abs=1e-9
    )


@pytest.mark.parametrize("position", POSITIONS)
def test_gravity_levels_and_leaves_the_heading_alone(position: int) -> None:
    rng = np.random.default_rng(position)
    tilted = rotation(np.array([*rng.normal(0, 0.2, 2), 0.0])) @ in_position(position)
    level = tilt_corrected(CubeAttitude(tilted, 0.01), face_normal(face_of(position)), 1.0)
    assert np.allclose(level.up, face_normal(face_of(position)))
    assert abs(heading_to_position(level, position)) < 0.05  # of tilts up to 0.4 rad: they do not commute
    assert level.heading_std(0.0) == 0.01


def rate_at(C_lb: FloatArray, bias: FloatArray, gyros: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return what gyros (3, 3) count per second in an attitude."""
    u = C_lb.T @ np.array([0, np.cos(CHINA), np.sin(CHINA)]) * EARTH_RATE
    counted: FloatArray = K * (gyros @ u + bias) + rng.normal(0, STD)
    return counted


def known(position: int, bias: FloatArray, gyros: FloatArray, rng: np.random.Generator) -> CertainDwell:
    set_down = in_position(position, rng.normal(0, np.radians(0.5)))
    return CertainDwell(position, rate_at(set_down, bias, gyros, rng), STD)


@pytest.mark.parametrize("count", [0, 1, 4])
def test_the_earth_determines_any_heading_within_its_own_sigma(count: int) -> None:
    errors = []
    for seed in range(300):
        rng = np.random.default_rng(seed)
        bias = rng.normal(0, RAD_S_PER_DEG_H, 3)
        gyros = np.diag(1 + rng.normal(0, 0.03, 3)) @ (np.eye(3) + rng.normal(0, 0.01, (3, 3)))
        before = [known(int(p), bias, gyros, rng) for p in rng.permutation(12)[:count] + 1]
        position, off = int(rng.integers(1, 13)), rng.uniform(-np.pi, np.pi)
        rate = rate_at(in_position(position, off), bias, gyros, rng)
        found, std = earth_heading(rate, STD, in_position(position), CHINA, np.eye(3), K, before)
        if np.isfinite(std):
            errors.append(float(np.angle(np.exp(1j * (found - off)))) / std)
    assert len(errors) > 290
    assert 0.5 < np.std(errors) < 1.25
    assert np.max(np.abs(errors)) < 4.5


def test_a_rate_that_is_not_the_earths_determines_nothing() -> None:
    C_lb = in_position(3)
    for rate in (np.zeros(3), np.full(3, K * 60 * RAD_S_PER_DEG_H), np.array([K, 0, 0])):
        assert np.isinf(earth_heading(rate, STD, C_lb, CHINA, np.eye(3), K)[1])
    pole = C_lb.T @ np.array([0, 0, EARTH_RATE * K])
    assert np.degrees(earth_heading(pole, STD, C_lb, np.radians(89.9), np.eye(3), K)[1]) > 45
