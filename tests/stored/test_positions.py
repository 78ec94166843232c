"""Where a body is that flies an eight: alignment, inner window and outer graph, to the last pose."""

from functools import cache

import numpy as np
import pytest

from procedures.fusion.alignment.alignment_at_rest import align_at_rest
from procedures.fusion.alignment.alignment_attempts import align_when_possible
from procedures.fusion.alignment.alignment_in_motion import MovingAligner
from procedures.fusion.alignment.alignment_result import AlignmentState
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.fusion.odometry import OdometryDrift
from procedures.fusion.outer.pose_graph import PoseGraph, PoseGraphSettings
from tests.procedures.fusion.motions import EARTH, GRAVITY, NOISE, Eight, fog
from tests.procedures.fusion.seen import SITE
from tests.procedures.fusion.whole_runs import whole_run, whole_track
from tests.stored.held import assert_held

ZERO = np.zeros(3)
LEVER = np.array([0.5, 0.2, -0.3])


@cache
def aligned(seconds: float, late: float = 0.0) -> tuple[ImuSeries, GnssFixes, AlignmentState]:
    flight, rng = Eight(seconds), np.random.default_rng(1)
    imu, fixes = flight.imu(rng, EARTH), flight.fixes(rng, LEVER if late else ZERO, late=late)
    aligner = MovingAligner(NOISE, GRAVITY, EARTH, ZERO, *((1.0, 0.2) if late else ()))
    found = align_when_possible(aligner, imu, fixes)
    assert isinstance(found, AlignmentState)
    return imu, fixes, found


@pytest.mark.parametrize("late", [0.0, 0.12])
def test_an_alignment_in_motion(late: float) -> None:
    assert_held("positions", f"alignment, {late} s late", aligned(14.0, late)[2])


def test_an_alignment_at_rest() -> None:
    rng = np.random.default_rng(3)
    imu, _, noise = fog(rng, 60.0, 1e-7 * rng.standard_normal(3))
    assert_held("positions", "at rest", align_at_rest(imu, noise, GRAVITY, EARTH))


@pytest.mark.parametrize("layers", [1, 2])
def test_a_window_of_inertial_terms(layers: int) -> None:
    imu, fixes, start = aligned(14.0)
    fixes = fixes.part((fixes.t < 11.0) | (fixes.t > 12.0))
    window = InertialWindow(WindowSettings(SITE, ZERO, layers), imu, fixes, start)
    if layers == 1:
        poses = whole_track(window)
        assert_held("positions", "window", [poses[::5], window.smoothed()[::10], window.covariance_n])
        return
    graph = PoseGraph()
    assert_held("positions", "two layers", [whole_run(graph, window, fixes)[::5], graph.smoothed()])


def test_lever_arm_and_lateness_found() -> None:
    imu, fixes, start = aligned(14.0, 0.12)
    settings = WindowSettings(SITE, start.lever, lever_std=1.0, offset_std=0.2)
    window = InertialWindow(settings, imu, fixes.shifted(start.time_offset), start)
    assert_held("positions", "antenna found", whole_track(window)[::10])


def test_a_graph_over_an_odometry_that_drifts() -> None:
    flight, rng = Eight(16.0), np.random.default_rng(5)
    odometry, fixes = flight.odometry(rng, OdometryDrift(0.02, 0.03, 0.01)), flight.fixes(rng, LEVER)
    fixes.p_n[40] += [30.0, -20.0, 5.0]
    graph = PoseGraph(PoseGraphSettings(4.0, LEVER, 0.5, 0.0, 0.1))
    poses = whole_run(graph, odometry, fixes)
    assert_held("positions", "graph", [poses[::5], graph.smoothed(), graph.begun_at])
