"""Alignment of a live run, tried until it succeeds; and the outer graph, renewed every half hour.

A camera helps the alignment where there is one. The graph is renewed so that neither memory nor time grows with a
run without end.
"""

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.alignment_attempts import (
    FIRST_ATTEMPT_S,
    MIN_ATTEMPT_SPACING_S,
    MOTION_WINDOW_S,
    attempt,
    between,
)
from procedures.fusion.alignment_in_motion import MovingAligner
from procedures.fusion.fusion_records import AlignmentState, GnssFixes, ImuSeries, Waiting
from procedures.fusion.gnss_velocity import LeverArm
from procedures.fusion.inner.inertial_window import InertialWindow
from procedures.fusion.inner.visual_inertial_window import VisionSettings
from procedures.fusion.inner.window_terms import Site
from procedures.fusion.odometry import OdometryPose
from procedures.fusion.pose_graph import GlobalPose, PoseGraph, PoseGraphSettings
from procedures.fusion.vision.visual_alignment import align_at
from station.locate.live_camera import LiveCamera

LONGEST_REST = 60.0  # s of a rest that the window goes through again: its data are what the heading is known by
MAX_BUFFER_S = 300.0  # s of samples
ATTEMPT_SPACING = 0.05  # of the time so far, between two attempts
LEAD_S = 1.0  # s of samples before the first keyframe


@dataclass(frozen=True, slots=True, eq=False)
class LiveStart:
    """An alignment, and the samples from which the window begins."""

    aligned: AlignmentState
    imu: ImuSeries


class LiveAlignment:
    """Tries by the camera, where there is one, and by the IMU alone at growing intervals where that cannot yet.

    ``why`` says what is missing.
    """

    def __init__(self, aligner: MovingAligner, camera: LiveCamera | None) -> None:
        self.aligner, self._camera = aligner, camera
        self._start: float | None = None
        self._next = 0.0
        self._seen_until, self._seen = -np.inf, Waiting("")
        self.why = self._why_inertial = "waiting for fixes"

    def attempt(self, imu: ImuSeries, fixes: GnssFixes) -> LiveStart | None:
        """Return a beginning if it is time for an attempt and that succeeds."""
        seen = None if self._camera is None else self._by_camera(self._camera, imu, fixes)
        if isinstance(seen, LiveStart):
            return seen
        begun = self._by_imu(imu, fixes)
        self.why = self._why_inertial if seen is None else f"{seen.why}; without the camera: {self._why_inertial}"
        return begun

    def _by_imu(self, imu: ImuSeries, fixes: GnssFixes) -> LiveStart | None:
        now = min(float(imu.t[-1]), float(fixes.t[-1]))
        if self._start is None:
            self._start = max(float(imu.t[0]), float(fixes.t[0]))
            self._next = self._start + FIRST_ATTEMPT_S
        if now < self._next:
            return None
        self._next = now + max(MIN_ATTEMPT_SPACING_S, ATTEMPT_SPACING * (now - self._start))
        found = attempt(self.aligner, imu, fixes, self._start, now)
        if isinstance(found, Waiting):
            self._why_inertial = found.why
            return None
        first = max(found.t0, now - max(LONGEST_REST, MOTION_WINDOW_S))
        return LiveStart(replace(found, t0=first), between(imu, first - LEAD_S, now))

    def _by_camera(self, camera: LiveCamera, imu: ImuSeries, fixes: GnssFixes) -> LiveStart | Waiting:
        tracks, a = camera.tracks(), self.aligner
        if not len(tracks.t):
            return Waiting(f"camera: {camera.why}")
        if tracks.t[-1] == self._seen_until:
            return self._seen  # nothing new: another attempt would take time and find the same
        self._seen_until = float(tracks.t[-1])
        now = min(self._seen_until, float(imu.t[-1]), float(fixes.t[-1]))
        antenna = LeverArm(a.lever, a.lever_std or 0.0)
        settings = VisionSettings(Site(a.gravity, a.earth_n, a.noise), camera.camera, antenna)
        found = align_at(settings, imu, tracks, fixes, now)
        if isinstance(found, Waiting):
            self._seen = found
            return found
        return LiveStart(found.aligned, between(imu, found.aligned.t0 - LEAD_S, float(tracks.t[-1])))


def joined_series(parts: list[ImuSeries]) -> ImuSeries:
    """Return consecutive samples as one series."""
    return ImuSeries(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in ("t", "omega_b", "f_b"))
    )


MAX_POSES = 36_000  # poses: half an hour
RUN_IN = 1_200  # poses that a new graph goes along before it takes over: a minute, six of its windows


class NoGraph:
    """One layer: the window holds the fixes' positions itself, as where a receiver reports nothing else."""

    lever_std = 0.0

    def __init__(self, window: InertialWindow) -> None:
        self._window = window

    def add(self, fixes: GnssFixes) -> None:
        """Leave them: the window has them."""

    def take(self, pose: OdometryPose) -> GlobalPose | None:
        """Return the window's newest pose."""
        return GlobalPose(pose.t, pose.p_o, pose.C_ob, self._window.covariance_n)

    @property
    def lever_arm(self) -> FloatArray:
        """The lever arm (3,) [m] as the window knows it."""
        arm: FloatArray = self._window.constants[:3]
        return arm


class LiveGraph:
    """Like `PoseGraph`, but fixes are added as they come."""

    def __init__(self, settings: PoseGraphSettings, renewed: int = MAX_POSES, run_in: int = RUN_IN) -> None:
        self._settings, self._renewed, self._run_in = settings, renewed, run_in
        self._graph = PoseGraph(settings)
        self._heir: PoseGraph | None = None
        self._poses = 0

    def add(self, fixes: GnssFixes) -> None:
        """Take fixes that come after all so far."""
        for graph in (self._graph, self._heir) if self._heir is not None else (self._graph,):
            known = graph.association.fixes
            graph.association.fixes = fixes if known is None else known.followed_by(fixes)

    def take(self, pose: OdometryPose) -> GlobalPose | None:
        """Return a pose in n; None before the moment of alignment."""
        self._poses += 1
        found = self._graph.take(pose)
        if self._heir is not None and self._heir.association.fixes is not None:
            self._heir.take(pose)
        self._renew()
        return found

    @property
    def lever_arm(self) -> FloatArray:
        """The lever arm (3,) [m] as it is known now."""
        return self._graph.constants[0]

    @property
    def lever_std(self) -> float:
        """1 sigma [m] of its least known component, 0 where it was given."""
        return self._graph.lever_std

    def _renew(self) -> None:
        """Have an heir begin, or take over once it has run in."""
        if self._heir is None:
            if self._poses >= self._renewed:
                self._heir = PoseGraph(self._settings)
        elif self._poses >= self._renewed + self._run_in and self._heir.begun_at is not None:
            self._graph, self._heir, self._poses = self._heir, None, self._run_in


Graph: TypeAlias = LiveGraph | NoGraph  # what makes a window's poses those in n
