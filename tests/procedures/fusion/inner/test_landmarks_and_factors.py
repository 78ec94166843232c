"""A landmark is used from when it tells how far it is: not at rest, where the way between keyframes is noise."""

import numpy as np
import pytest

from procedures.fusion.inner.landmarks import Landmarks
from procedures.fusion.inner.window_state import COMMON, FRAME, ChainFactor, Factor, WindowState
from tests.refusals import refused

FRAMES, SCALE = 6, np.array([400.0, 400.0])
RNG = np.random.default_rng(1)
POINTS = np.column_stack((RNG.uniform(-2, 2, (30, 2)), RNG.uniform(4, 10, 30)))


def state_of(way: np.ndarray) -> WindowState:
    """Return keyframes at places (k, 3) that look along z with the camera at the IMU's place."""
    none, still = np.zeros((len(way), 3)), np.tile(np.eye(3), (len(way), 1, 1))
    return WindowState(still, way, none, none, none, np.eye(3), np.zeros(3), 0.0, np.zeros((0, 3)))


def marks_of(way: np.ndarray, noise: float = 0.5, outlier: float = 0.0) -> Landmarks:
    """Return the points as seen from a way (k, 3), ``noise`` [px]; one sight of each off by ``outlier`` [px]."""
    marks, rng = Landmarks(), np.random.default_rng(2)
    which = rng.integers(len(way), size=len(POINTS))
    for k, p in enumerate(way):
        y = POINTS - p
        z = y[:, :2] / y[:, 2:] + rng.normal(0, noise, (len(y), 2)) / SCALE
        marks.add_frame(np.arange(len(y)), z + (which == k)[:, None] * outlier / SCALE)
    return marks


REST = np.zeros((FRAMES, 3))
NOISE = np.linspace([0.0, 0.0, 0.0], [0.04, -0.03, 0.0], FRAMES)  # m, what GNSS velocities make of a rest
DRIVE = np.linspace([0.0, 0.0, 0.0], [0.4, 0.0, 0.1], FRAMES)


def test_at_rest_no_landmark_is_used_however_the_way_is_guessed() -> None:
    marks = marks_of(REST)
    marks.settle(state_of(NOISE), SCALE)
    assert not marks.ready.any()
    marks.settle(state_of(NOISE))  # unasked all are, and many look far away
    assert marks.ready.all()
    assert np.mean(marks.sights.at[:, 2] < 0.03) > 0.25
    assert (1 / POINTS[:, 2]).min() > 0.09


def test_in_motion_all_are_used_and_stand_where_they_are() -> None:
    marks = marks_of(DRIVE)
    marks.settle(state_of(DRIVE), SCALE)
    assert marks.ready.all()
    assert np.abs(marks.sights.at[:, 2] * POINTS[:, 2] - 1).max() < 0.2


# Factors of the normal equations against the dense inverse


def chained(keyframes: int, seed: int) -> np.ndarray:
    """Return normal equations (n, n) of keyframes tied to the next and to what is common; units differ by 1e6."""
    rng, n = np.random.default_rng(seed), COMMON + FRAME * keyframes
    A = np.diag(rng.uniform(1, 2, n))
    for k in range(max(keyframes - 1, 1)):
        at = np.r_[:COMMON, COMMON + FRAME * k : min(COMMON + FRAME * (k + 2), n)]
        J = rng.normal(size=(20, len(at)))
        A[np.ix_(at, at)] += J.T @ J
    unit = 10 ** rng.uniform(-3, 3, n)
    return A * unit * unit[:, None]


@pytest.mark.parametrize("kind", [Factor, ChainFactor])
@pytest.mark.parametrize("keyframes", [1, 2, 3, 20])
def test_it_solves_and_has_the_inverse_s_blocks(kind: type[Factor], keyframes: int) -> None:
    A = chained(keyframes, keyframes)
    factor, inverse, rng = kind(A), np.linalg.inv(A), np.random.default_rng(1)
    size = np.sqrt(np.diag(inverse))
    for right in (rng.normal(size=len(A)), rng.normal(size=(len(A), 3))):
        scaled = (right.T / size).T
        expected = inverse @ scaled
        assert np.abs((factor.solve(scaled) - expected).T / size).max() < 1e-9 * np.abs(expected.T / size).max()
    for at in (slice(0, 3), slice(COMMON - 2, COMMON + 4), slice(len(A) - FRAME, len(A))):
        each = np.outer(size[at], size[at])
        assert np.allclose(factor.covariance(at) / each, inverse[at, at] / each, atol=1e-9)
    assert factor.size == len(A)


@pytest.mark.parametrize("unknown", [COMMON + FRAME - 1, COMMON + 3 * FRAME - 1])
@pytest.mark.parametrize("kind", [Factor, ChainFactor])
def test_what_nothing_is_known_of_is_named(kind: type[Factor], unknown: int) -> None:
    A = chained(4, 5)
    A[unknown], A[:, unknown] = A[unknown - 1], A[:, unknown - 1]
    A[unknown, unknown] = A[unknown, unknown - 1] * (1 - 1e-9)  # their difference is open
    with refused(np.linalg.LinAlgError, None, f"unknown {unknown + 1} "):
        kind(A)
