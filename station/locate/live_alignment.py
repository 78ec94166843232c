"""What comes before a live location: an alignment, tried again and again, by a camera too where there is one."""

from dataclasses import dataclass, replace

import numpy as np

from procedures.fusion.alignment.alignment_attempts import (
    FIRST_ATTEMPT_S,
    MIN_ATTEMPT_SPACING_S,
    MOTION_WINDOW_S,
    attempt,
    between,
)
from procedures.fusion.alignment.alignment_in_motion import MovingAligner
from procedures.fusion.alignment.alignment_result import AlignmentState, Waiting
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.imu.gnss_velocity import LeverArm
from procedures.fusion.inner.inertial_terms import Site
from procedures.fusion.inner.visual_inertial_window import VisionSettings
from procedures.fusion.visual_alignment.visual_alignment_attempts import VisualAligner
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
        found = VisualAligner(settings).align(imu, tracks, fixes, now)
        if isinstance(found, Waiting):
            self._seen = found
            return found
        return LiveStart(found.aligned, between(imu, found.aligned.t0 - LEAD_S, float(tracks.t[-1])))


def joined_series(parts: list[ImuSeries]) -> ImuSeries:
    """Return consecutive samples as one series."""
    return ImuSeries(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in ("t", "omega_b", "f_b"))
    )
