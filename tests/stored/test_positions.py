"""Positions of a body that flies an eight: alignment, inertial window, camera, outer graph, to the last pose."""

from functools import cache

import numpy as np
import pytest

from procedures.fusion.alignment_attempts import align_at_rest, align_when_possible
from procedures.fusion.alignment_in_motion import MovingAligner
from procedures.fusion.fusion_records import AlignmentState, GnssFixes, ImuSeries
from procedures.fusion.gnss_velocity import LeverArm
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.fusion.inner.visual_inertial_window import VisionSettings, VisualInertialWindow
from procedures.fusion.odometry import OdometryDrift
from procedures.fusion.pose_graph import PoseGraph, PoseGraphSettings
from procedures.fusion.vision.visual_alignment import VisualStart, align_by_camera
from tests.drivers.simulated.camera_tracks import View
from tests.procedures.fusion.motions import CAMERA, EARTH, GRAVITY, NOISE, SITE, Eight, fog, tracks_of
from tests.stored.conftest import StoredResult

ZERO = np.zeros(3)
LEVER = np.array([0.5, 0.2, -0.3])


@cache
def aligned(late: float = 0.0) -> tuple[ImuSeries, GnssFixes, AlignmentState]:
    """Return 14 s of an eight with fixes that are late by ``late`` [s], aligned in motion."""
    flight, rng = Eight(14.0), np.random.default_rng(1)
    imu, fixes = flight.imu(rng, EARTH), flight.fixes(rng, LEVER if late else ZERO, late=late)
    aligner = MovingAligner(NOISE, GRAVITY, EARTH, ZERO, *((1.0, 0.2) if late else ()))
    found = align_when_possible(aligner, imu, fixes)
    assert isinstance(found, AlignmentState)
    return imu, fixes, found


def test_alignment_at_rest(stored_result: StoredResult) -> None:
    rng = np.random.default_rng(3)
    imu, _, noise = fog(rng, 60.0, 1e-7 * rng.standard_normal(3))
    stored_result.check(align_at_rest(imu, noise, GRAVITY, EARTH))


@pytest.mark.parametrize("layers", [1, 2])
def test_a_window_of_inertial_terms(stored_result: StoredResult, layers: int) -> None:
    imu, fixes, start = aligned()
    fixes = fixes.part((fixes.t < 11.0) | (fixes.t > 12.0))
    window = InertialWindow(WindowSettings(SITE, ZERO, layers), imu, fixes, start)
    if layers == 1:
        poses = list(window.poses())
        smoothed = window.smoothed()[::10]
        stored_result.check({
            "start": start, "poses": poses[::5], "smoothed": smoothed, "covariance": window.covariance_n
        })  # fmt: skip
    else:
        graph = PoseGraph()
        stored_result.check({"poses": list(graph.run(window, fixes))[::5], "smoothed": graph.smoothed()})


def test_lever_arm_and_latency_are_found(stored_result: StoredResult) -> None:
    imu, fixes, start = aligned(0.12)
    settings = WindowSettings(SITE, start.lever, lever_std=1.0, offset_std=0.2)
    window = InertialWindow(settings, imu, fixes.shifted(start.time_offset), start)
    *_, last = window.poses()
    stored_result.check({"start": start, "position": last.p_o, "orientation": last.C_ob})


def test_a_graph_over_an_odometry_that_drifts(stored_result: StoredResult) -> None:
    flight, rng = Eight(16.0), np.random.default_rng(5)
    odometry, fixes = flight.odometry(rng, OdometryDrift(0.02, 0.03, 0.01)), flight.fixes(rng, LEVER)
    fixes.p_n[40] += [30.0, -20.0, 5.0]
    graph = PoseGraph(PoseGraphSettings(4.0, LEVER, 0.5, 0.0, 0.1))
    poses = list(graph.run(odometry, fixes))
    stored_result.check({"poses": poses[::5], "smoothed": graph.smoothed(), "begun at": graph.begun_at})


def test_a_window_with_a_camera(stored_result: StoredResult) -> None:
    flight = Eight(8.0)
    imu, fixes = flight.imu(np.random.default_rng(1), EARTH), flight.fixes(np.random.default_rng(2))
    tracks = tracks_of(flight, 3, view=View(features=80, longest=6.0))
    settings = VisionSettings(SITE, CAMERA, LeverArm(ZERO))
    start = align_by_camera(settings, imu, tracks, fixes)
    assert isinstance(start, VisualStart)
    poses = list(VisualInertialWindow(settings, imu, tracks, fixes, start.aligned).poses())
    stored_result.check({"start": start, "poses": poses[::5]})
