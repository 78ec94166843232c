"""When camera, IMU and GNSS know which way they stand and how large the world is: tried until they do.

Tracks give the camera's way up to scale (`visual_structure`), `visual_start` the rest. It waits for displacement
and observability, not for a time; what is missing is said by the last attempt.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.alignment.alignment_attempts import attempt_times
from procedures.fusion.alignment.alignment_result import Waiting
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.inner.landmarks import Landmarks
from procedures.fusion.inner.visual_inertial_window import VisionSettings
from procedures.fusion.vision.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.vision.rolling_shutter import derotated
from procedures.fusion.vision.two_view import MIN_POINTS
from procedures.fusion.visual_alignment.visual_start import VisualInertialFit, VisualStart
from procedures.fusion.visual_alignment.visual_structure import structure

FIRST_ATTEMPT_S = 1.0  # s after which it is worth a try
MIN_ATTEMPT_SPACING_S = 0.5  # s
MAX_SPAN_S = 2.0  # s of frames that are looked at, at most
MIN_FRAMES = 5  # frames
MIN_SHARED_FEATURES = 2 * MIN_POINTS  # features that the first frame must share with the last
MIN_FRAME_SPACING_S = 0.09  # s between the frames that are used
TWO_VIEW_SEED = 0  # of the samples of `two_view`


@dataclass(frozen=True, slots=True, eq=False)
class VisualAligner:
    """What stays the same."""

    settings: VisionSettings

    def align(self, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes, now: float) -> VisualStart | Waiting:
        """Align by the last frames before ``now`` [s], or say what is missing."""
        camera = self.settings.camera
        tracks = derotated(tracks, imu, camera)
        t, marks = _followed(tracks, camera, max(now - MAX_SPAN_S, float(imu.t[0])), min(now, float(imu.t[-1])))
        if len(t) < MIN_FRAMES:
            return Waiting(
                f"{len(t)} frames of the camera share {MIN_SHARED_FEATURES} features, {MIN_FRAMES} are needed"
            )
        scale = np.array([camera.fx, camera.fy]) / camera.std
        seen = structure(marks, t, scale, np.random.default_rng(TWO_VIEW_SEED))
        if isinstance(seen, str):
            return Waiting(seen)
        known = fixes.part(np.searchsorted(fixes.t, now, "right") > np.arange(len(fixes.t)))
        if not np.isfinite(known.v_n[:, :2]).all(axis=1).any():
            return Waiting("no GNSS velocity yet, which is needed for the scale")
        return VisualInertialFit(self.settings, imu, known, t, marks, seen, scale).start()


def align_by_camera(
    aligner: VisualAligner, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes
) -> VisualStart | Waiting:
    """Return the first alignment that the data allow, none of which uses anything later than its end."""
    start = max(float(each.t[0]) for each in (imu, tracks, fixes))
    end = min(float(each.t[-1]) for each in (imu, tracks, fixes))
    found: VisualStart | Waiting = Waiting("IMU, camera and GNSS overlap for less than a second")
    for now in attempt_times(start, end, FIRST_ATTEMPT_S, MIN_ATTEMPT_SPACING_S):
        found = aligner.align(imu, tracks, fixes, now)
        if isinstance(found, VisualStart):
            break
    return found


def _followed(
    tracks: FeatureTracks, camera: PinholeCamera, first: float, last: float
) -> tuple[FloatArray, Landmarks]:
    """Return the frames that share enough features with the last, and their landmarks, not placed yet."""
    times, begin = tracks.frames()
    marks, kept = Landmarks(), list[float]()
    for i in np.flatnonzero((times >= first) & (times <= last)):
        if not kept or times[i] - kept[-1] >= MIN_FRAME_SPACING_S:
            rows = slice(int(begin[i]), int(begin[i + 1]))
            marks.add_frame(tracks.feature[rows], camera.rays(tracks.uv[rows]))
            kept.append(float(times[i]))
    while kept and (marks.sights.seen[:, 0] & marks.sights.seen[:, -1]).sum() < MIN_SHARED_FEATURES:
        marks.drop_first_frame()
        kept.pop(0)
    return np.array(kept), marks
