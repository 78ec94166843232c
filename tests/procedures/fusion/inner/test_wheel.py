"""A wheel in the window: its slopes, its scale factor, slips that are not followed, an outage that it bridges."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from procedures.frames import rotation
from procedures.fusion.alignment_attempts import align_when_possible
from procedures.fusion.alignment_in_motion import MovingAligner
from procedures.fusion.fusion_records import AlignmentState, ImuSeries, KeyframeWheel, WheelMount, WheelSpeeds
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.fusion.inner.wheel_aid import WheelAid
from procedures.fusion.inner.window_state import COMMON, FRAME, HEADING, WindowState
from procedures.fusion.inner.window_terms import Site, at_end, wheel_residuals
from procedures.fusion.preintegration import grid, preintegrate
from procedures.geodesy import earth_rate_n
from tests.procedures.fusion.drives import GRAVITY, LATITUDE, MEMS, MOUNT, SCALE, SLIPS, Drive
from tests.procedures.fusion.inner.test_window_terms import two_keyframes
from tests.procedures.fusion.motions import NOISE

STEP = 1e-6
ZERO = np.zeros(3)


def test_slopes_are_those_of_differences() -> None:
    rng = np.random.default_rng(1)
    state = two_keyframes(rng)
    wheel = KeyframeWheel(rng.normal(size=3), 0.3, 7.0, 1.0, 1.0)
    wheel = replace(
        wheel, due=0.3 + float(wheel_residuals(state, [1], [wheel])[0][0, 0])
    )  # it tells what it should
    r, J, _ = wheel_residuals(state, [1], [wheel])
    columns = []
    for k in [*range(HEADING, COMMON), *range(COMMON + FRAME, COMMON + 2 * FRAME)]:
        step = np.zeros(state.size)
        step[k] = STEP
        columns.append((wheel_residuals(state.moved(step), [1], [wheel])[0][0] - r[0]) / STEP)
    assert np.allclose(J[0], np.array(columns).T, atol=1e-5)


def test_a_wheel_that_rolls_leaves_no_residual() -> None:
    """A body speeds up and turns for 50 ms; the wheel's speeds are differences of the path of its place."""
    forward, lever, k = np.array([0.6, 0.8, 0.0]), np.array([-1.0, 0.4, -0.5]), 0.02
    rate, a_n, v0 = np.array([0.02, -0.05, 0.5]), np.array([1.5, -0.7, 0.2]), np.array([9.0, 4.0, 0.1])
    C0 = rotation(np.array([0.1, -0.2, 2.0]))

    def place(t: float) -> np.ndarray:
        return v0 * t + a_n * t**2 / 2 + C0 @ rotation(rate * t) @ lever

    t = np.linspace(0.0, 0.1, 101)
    C = C0 @ rotation(np.outer(t, rate))
    f = np.einsum("nji,nj->ni", C, np.tile(a_n + np.array([0, 0, GRAVITY]), (101, 1)))
    part = preintegrate(
        grid(ImuSeries(t, np.tile(rate, (101, 1)), f), np.array([0.0, 0.05])), ZERO, ZERO, ZERO, NOISE
    )
    reported = np.array([0.012, 0.03, 0.047])
    speed = [
        C0 @ rotation(rate * s) @ forward @ (place(s + 1e-4) - place(s - 1e-4)) / 2e-4 / (1 + k) for s in reported
    ]
    C1, v1, pull = C0 @ rotation(rate * 0.05), v0 + a_n * 0.05, np.array([0.0, 0.0, -GRAVITY])
    mount = WheelMount(forward, lever, 0.05, 0.05)
    wheel = at_end(WheelSpeeds(reported, np.array(speed)), mount, 0.0, part, C1.T @ pull)
    assert wheel is not None
    one = np.zeros((1, 3))
    state = WindowState(C1[None], one, v1[None], one, one, np.eye(3), ZERO, 0.0, np.zeros((0, 3)), wheel=k)
    r, _, weight = wheel_residuals(state, [0], [wheel])
    assert abs(r[0, 0]) < 2e-3  # of 9.8 m/s
    assert weight[0, 0] == pytest.approx(3 / 0.05**2)


@cache
def drive() -> Drive:
    """A stop, 33 s without GNSS, setting off in it with a wheel that spins."""
    return Drive(104.0, outage=(66.0, 99.0))


@cache
def run(slips: bool, wheel: bool, seed: int = 1) -> tuple[InertialWindow, np.ndarray]:
    """Return a window that went along the drive, and the error of each pose: t [s], then three axes [m]."""
    car = drive() if slips else Drive(104.0, outage=(66.0, 99.0), slips=())
    rng, earth_n = np.random.default_rng(seed), earth_rate_n(LATITUDE)
    imu, fixes, reported = car.imu(rng), car.fixes(rng), car.wheel(rng)
    aligned = align_when_possible(MovingAligner(MEMS, GRAVITY, earth_n, ZERO), imu, fixes)
    assert isinstance(aligned, AlignmentState)
    aid = WheelAid(MOUNT, reported, MEMS) if wheel else None
    settings = WindowSettings(Site(GRAVITY, earth_n, MEMS), ZERO, 1, frames=10, spacing=0.1)
    window = InertialWindow(settings, imu, fixes, aligned, aid)
    poses = np.array([[pose.t, *pose.p_o] for pose in window.poses()])
    poses[:, 1:] -= car.at(poses[:, 0])[0]
    return window, poses


def worst(errors: np.ndarray) -> float:
    """Return the largest error in the outage [m]."""
    silent = (errors[:, 0] > 66.0) & (errors[:, 0] < 99.0)
    return float(np.linalg.norm(errors[silent, 1:], axis=1).max())


@pytest.mark.proof
def test_the_scale_factor_is_found_within_its_sigma() -> None:
    window, _ = run(True, True)
    assert window.wheel_std < 1e-3
    assert abs(1 + window.state.wheel - SCALE) < 3.5 * window.wheel_std


@pytest.mark.proof
def test_slips_are_seen_and_not_followed() -> None:
    """Slips make hardly a difference to the same drive without; each is found, and little else."""
    window, slipped = run(True, True)
    assert worst(slipped) < 1.5 * worst(run(False, True)[1]) + 0.1
    assert window.wheel is not None
    found = window.wheel.slips
    for begin, end, _ in SLIPS[:3]:
        assert any(a < end and b > begin for a, b in found), (begin, found)
    assert sum(b - a for a, b in found) < 2 * sum(end - begin for begin, end, _ in SLIPS[:3])


@pytest.mark.proof
def test_an_outage_is_bridged_and_standing_still_is_seen() -> None:
    window, errors = run(True, True)
    assert worst(errors) < 0.6 * worst(run(True, False)[1])
    assert worst(errors) < 0.7
    assert window.wheel is not None
    true_rest = (
        float(np.count_nonzero(np.abs(np.gradient(drive().at(np.arange(0, 103.9, 0.1))[0][:, 0], 0.1)) < 1e-3))
        / 10
    )
    assert 0.75 * true_rest < window.wheel.rest_s < 1.05 * true_rest


@pytest.mark.proof
def test_a_wheel_that_stops_reporting_says_zero_while_driving_and_is_not_believed() -> None:
    """A broken sensor: nought from 30 s on, while the car drives, GNSS there."""
    rng, earth_n = np.random.default_rng(2), earth_rate_n(LATITUDE)
    car = Drive(40.0, outage=None, slips=())
    imu, fixes, reported = car.imu(rng), car.fixes(rng), car.wheel(rng)
    broken = WheelSpeeds(reported.t, np.where(reported.t > 30.0, 0.0, reported.speed))
    aligned = align_when_possible(MovingAligner(MEMS, GRAVITY, earth_n, ZERO), imu, fixes)
    assert isinstance(aligned, AlignmentState)
    window = InertialWindow(
        WindowSettings(Site(GRAVITY, earth_n, MEMS), ZERO, 1, frames=10, spacing=0.1), imu, fixes, aligned,
        WheelAid(MOUNT, broken, MEMS),
    )  # fmt: skip
    late = [pose for pose in window.poses() if pose.t > 30.0]
    e = [np.linalg.norm(pose.p_o - car.at(np.array([pose.t]))[0][0]) for pose in late]
    assert max(e) < 1.0
    assert window.wheel is not None
    assert window.wheel.slips_now
