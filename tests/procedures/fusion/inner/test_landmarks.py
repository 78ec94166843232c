"""A landmark is used from when it tells how far it is: not at rest, where the way between keyframes is noise."""

import numpy as np

from procedures.fusion.inner.landmarks import Landmarks
from procedures.fusion.inner.window_state import WindowState

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
