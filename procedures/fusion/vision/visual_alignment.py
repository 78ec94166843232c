"""From a camera's path up to scale to an alignment: scale, the world's axes, then one fit of all (Han 2022 III).

GNSS's path over the same time gives the scale. The world's axes come from two kinds of vectors at once (Wahba's
problem): the path, Han's yaw by track, and the velocity increments with gravity, Han's eq. 3 in its integral form.
Then tracks, IMU and GNSS velocity are fitted together, which is Han's joint refinement (III.C) and its bundle
adjustment in one. A strange misfit or a wide sigma of tilt, yaw or scale are reasons to go on waiting;
`align_by_camera` attempts it again and again, and the last attempt reports what is missing.
"""

from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray, interpolated
from procedures.frames import rotation_vector, wahba_rotation
from procedures.fusion.alignment_attempts import attempt_times
from procedures.fusion.feature_tracks import FeatureTracks, PinholeCamera, derotated
from procedures.fusion.fusion_records import (
    MAX_TILT_STD,
    MAX_YAW_STD,
    AlignmentState,
    GnssFixes,
    ImuSeries,
    Waiting,
    in_degrees,
)
from procedures.fusion.gnss_velocity import measurements, no_fix
from procedures.fusion.inner.landmarks import Landmarks
from procedures.fusion.inner.visual_inertial_window import VisionSettings, beginning
from procedures.fusion.inner.window_problem import WindowMeasurements, assemble
from procedures.fusion.inner.window_state import HEADING, Factor, WindowState
from procedures.fusion.inner.window_terms import fix_residuals
from procedures.fusion.pose_graph_terms import rz
from procedures.fusion.preintegration import ImuGrid, Preintegrated, grid, preintegrate
from procedures.fusion.vision.two_view import MIN_POINTS, CameraStructure, structure

MAX_SCALE_STD = 0.02  # 1 sigma: of 717 starts on real flights the worst was then 8 % off, of 901 with 0.04 11 %
MAX_MEAN_SQUARE = 2.5  # of a mean square that should be 1
MAX_ITERATIONS = 8
STEP_TOLERANCE = 1e-2  # of a sigma


@dataclass(frozen=True, slots=True, eq=False)
class VisualStart:
    """An alignment, and the IMU's path over the frames ``t`` (k,) [s] that gave it: ``rough`` and ``refined``
    (k, 3) [m] before and after the joint fit; ``scale_std`` is 1 sigma of its length, relative.
    """  # noqa: D205

    aligned: AlignmentState
    t: FloatArray
    rough: FloatArray
    refined: FloatArray
    scale_std: float


class VisualInertialFit:
    """One set of frames with their structure: the rough alignment, and the fit of all."""

    def __init__(
        self, settings: VisionSettings, imu: ImuSeries, fixes: GnssFixes, t: FloatArray, marks: Landmarks,
        seen: CameraStructure, scale: FloatArray,
    ) -> None:  # fmt: skip
        self.settings, self.imu, self.fixes, self.t, self.marks, self.seen = settings, imu, fixes, t, marks, seen
        self.scale = scale
        self.grid = grid(imu, t)
        C_bc = settings.camera.C_bc
        self.C_0b = C_bc @ seen.C_0c @ C_bc.T  # body k in the axes of body 0
        self.gyro_bias = self._gyro_bias()
        self.parts = self._parts(np.zeros((len(t), 3)))

    def start(self) -> VisualStart | Waiting:
        """Return the alignment, or why it is none yet."""
        way_n, v_n = self._gnss_way()
        length = float(np.linalg.norm(way_n[-1])) / float(np.linalg.norm(self.seen.p_0[-1]))
        rough = self._way_b(length)
        C_nb = self._wahba(way_n, v_n, rough)
        self._place(C_nb, length)
        return self._refined(C_nb, rough @ C_nb.T, v_n)

    def _gyro_bias(self) -> FloatArray:
        """Return what the turns between frames, as the camera saw them, say of the gyro's bias."""
        self.gyro_bias = np.zeros(3)
        parts = self._parts(np.zeros((len(self.t), 3)))
        turned = np.swapaxes(self.C_0b[:-1], 1, 2) @ self.C_0b[1:]
        off = rotation_vector(np.swapaxes(np.array([part.turn for part in parts]), 1, 2) @ turned)
        by_bias = np.array([part.by_bias[:3, :3] for part in parts])
        return np.asarray(np.linalg.lstsq(by_bias.reshape(-1, 3), off.ravel(), rcond=None)[0], np.float64)

    def _parts(self, earth_b: FloatArray) -> list[Preintegrated]:
        g, noise = self.grid, self.settings.site.noise
        rows = [slice(int(a), int(b)) for a, b in zip(g.at[:-1], g.at[1:], strict=True)]
        return [
            preintegrate(
                ImuGrid(g.dt[k], g.omega_b[k], g.f_b[k], g.at[:0]), self.gyro_bias, np.zeros(3), earth_b[i], noise
            )
            for i, k in enumerate(rows)
        ]

    def _gnss_way(self) -> tuple[FloatArray, FloatArray]:
        """Return the path (k, 3) [m] since the first frame by GNSS velocities, and these at the frames (k, 3)."""
        known = self.fixes.has_velocity
        t, v = self.fixes.t[known], np.nan_to_num(self.fixes.v_n[known])
        fine = np.union1d(self.t, t[(t > self.t[0]) & (t < self.t[-1])])
        at = interpolated(fine, t, v)
        path = np.vstack((np.zeros(3), np.cumsum((at[1:] + at[:-1]) / 2 * np.diff(fine)[:, None], axis=0)))
        here = np.searchsorted(fine, self.t)
        return path[here], at[here]

    def _way_b(self, length: float) -> FloatArray:
        """Return the IMU's path (k, 3) [m] in the axes of body 0, the camera's being ``length`` times its unit."""
        camera = self.settings.camera
        return length * self.seen.p_0 @ camera.C_bc.T + camera.t_bc - self.C_0b @ camera.t_bc

    def _wahba(self, way_n: FloatArray, v_n: FloatArray, way_b: FloatArray) -> FloatArray:
        """Return C_nb of body 0 from the path and from velocity increments with gravity, each by its own sigma."""
        elapsed = self.t - self.t[0]
        alpha = np.cumsum([C @ part.dv for C, part in zip(self.C_0b, self.parts, strict=False)], axis=0)
        felt = v_n[1:] - v_n[0] + np.outer(elapsed[1:], [0.0, 0.0, self.settings.site.gravity])
        std = float(np.nanmedian(self.fixes.velocity_std))
        way_weight = 1 / (std**2 * np.maximum(elapsed[1:], 0.1) * 0.1)
        return wahba_rotation((way_n[1:] * way_weight[:, None]).T @ way_b[1:] + felt.T @ alpha / (2 * std**2))

    def _place(self, C_nb: FloatArray, length: float) -> None:
        """Turn the landmarks into the frame of C_nb, with the origin at body 0, and to their size."""
        s, camera = self.marks.sights, self.settings.camera
        a = (length * s.a @ camera.C_bc.T + camera.t_bc) @ C_nb.T
        at = s.at / [1.0, 1.0, length]
        self.marks.sights = replace(s, a=a, A=C_nb @ camera.C_bc @ s.A, at=at)

    def _refined(self, C_nb: FloatArray, rough_n: FloatArray, v_n: FloatArray) -> VisualStart | Waiting:
        none, k, site = np.zeros(3), len(self.t), self.settings.site
        first = AlignmentState(
            float(self.t[0]), C_nb, v_n[0], self.gyro_bias, none, np.zeros((12, 12)), float(self.t[-1]), C_nb,
            0.0, 0.0, 0.0,
        )  # fmt: skip
        at_once = replace(self.settings.camera, row_time=0.0)  # the tracks are `derotated`
        one, prior = beginning(first, at_once, site.noise)
        C_ob = C_nb @ self.C_0b
        self.parts = self._parts(np.einsum("kji,j->ki", C_ob, site.earth_n))
        state = replace(one, C_ob=C_ob, p=rough_n, v=v_n, bg=np.tile(self.gyro_bias, (k, 1)), ba=np.zeros((k, 3)))
        held = self._held(state)
        for _ in range(MAX_ITERATIONS):
            normal, free = assemble(state, prior, held, site, self.marks, self.marks.sights.seen, self.scale)
            factor = Factor(normal.A)
            step = -factor.solve(normal.g)
            state = state.moved(step)
            self.marks.step(free.rows, free.step(step), state.held)
            if step @ normal.A @ step < STEP_TOLERANCE**2 * len(step):
                break
        return self._judged(state, held, factor, rough_n)

    def _held(self, state: WindowState) -> WindowMeasurements:
        seen, site = measurements(self.fixes, self.imu), self.settings.site
        fixes = [
            seen.at_end(t, part, C, site.pull(v), self.settings.antenna)
            for t, part, C, v in zip(self.t.tolist(), self.parts, state.C_ob, state.v, strict=False)
        ]
        return WindowMeasurements(self.parts, [no_fix(), *fixes])

    def _judged(
        self, state: WindowState, held: WindowMeasurements, factor: Factor, rough: FloatArray
    ) -> VisualStart | Waiting:
        tilt_std, yaw_std, scale_std = _sigmas(state, factor)
        R = rz(np.array(state.heading))[0]
        off, _, weight = fix_residuals(state, range(len(held.fixes)), held.fixes)
        misfit = max(self.seen.misfit, float(np.sum(off**2 * weight)) / max(int((weight > 0).sum()), 1))
        why = _why_waiting(tilt_std, yaw_std, scale_std, misfit)
        if why:
            return Waiting(why)
        C = R @ state.C_ob
        aligned = AlignmentState(
            float(self.t[0]), C[0], R @ state.v[0], state.bg[0], state.ba[0], np.zeros((12, 12)),
            float(self.t[-1]), C[-1], tilt_std, yaw_std, misfit,
        )  # fmt: skip
        return VisualStart(aligned, self.t, rough, state.p @ R.T, scale_std)


def _sigmas(state: WindowState, factor: Factor) -> tuple[float, float, float]:
    """Return 1 sigma of tilt and yaw [rad] at the last frame, and of the path's length, relative."""
    last, first = state.frame(len(state.p) - 1).start, state.frame(0).start
    path = state.p[-1] - state.p[0]
    length = max(float(np.linalg.norm(path)), 1e-6)
    pick = np.zeros((state.size, 4))
    pick[last : last + 3, :3] = state.C_ob[-1].T
    pick[HEADING, 2] = 1.0
    pick[last + 3 : last + 6, 3], pick[first + 3 : first + 6, 3] = path / length**2, -path / length**2
    variance = np.sum(pick * factor.solve(pick), axis=0)
    tilt, yaw, scale = np.sqrt([variance[:2].max(), variance[2], variance[3]])
    return float(tilt), float(yaw), float(scale)


def _why_waiting(tilt_std: float, yaw_std: float, scale_std: float, misfit: float) -> str:
    if not misfit < MAX_MEAN_SQUARE:
        return (
            f"camera, IMU and GNSS velocity do not match (mean square {misfit:.1f}, at most "
            f"{MAX_MEAN_SQUARE:g}): check time stamps, imu_from_camera, std_px and velocity_std_m_s"
        )
    if tilt_std < MAX_TILT_STD and yaw_std < MAX_YAW_STD and scale_std < MAX_SCALE_STD:
        return ""
    tilt, yaw, tilt_asked, yaw_asked = in_degrees(tilt_std, yaw_std, MAX_TILT_STD, MAX_YAW_STD)
    return (
        f"tilt is known to {tilt:.1f} deg, yaw to {yaw:.1f} deg and scale to {100 * scale_std:.0f} % (u), "
        f"{tilt_asked:.0f}, {yaw_asked:.0f} and {100 * MAX_SCALE_STD:.0f} are needed: move it further"
    )


FIRST_ATTEMPT_S = 1.0  # s after which it is worth a try
MIN_ATTEMPT_SPACING_S = 0.5  # s
MAX_SPAN_S = 2.0  # s of frames that are looked at, at most
MIN_FRAMES = 5  # frames
MIN_SHARED_FEATURES = 2 * MIN_POINTS  # features that the first frame must share with the last
MIN_FRAME_SPACING_S = 0.09  # s between the frames that are used
TWO_VIEW_SEED = 0  # of the samples of `two_view`


def align_at(
    settings: VisionSettings, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes, now: float
) -> VisualStart | Waiting:
    """Align by the last frames before ``now`` [s], or say what is missing."""
    camera = settings.camera
    tracks = derotated(tracks, imu, camera)
    t, marks = _followed(tracks, camera, max(now - MAX_SPAN_S, float(imu.t[0])), min(now, float(imu.t[-1])))
    if len(t) < MIN_FRAMES:
        why = f"{len(t)} frames of the camera share {MIN_SHARED_FEATURES} features, {MIN_FRAMES} are needed"
        return Waiting(why)
    scale = np.array([camera.fx, camera.fy]) / camera.std
    seen = structure(marks, t, scale, np.random.default_rng(TWO_VIEW_SEED))
    if isinstance(seen, str):
        return Waiting(seen)
    known = fixes.part(np.searchsorted(fixes.t, now, "right") > np.arange(len(fixes.t)))
    if not known.has_velocity.any():
        return Waiting("no GNSS velocity yet, which is needed for the scale")
    return VisualInertialFit(settings, imu, known, t, marks, seen, scale).start()


def align_by_camera(
    settings: VisionSettings, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes
) -> VisualStart | Waiting:
    """Return the first alignment that the data allow, none of which uses anything later than its end."""
    start = max(float(each.t[0]) for each in (imu, tracks, fixes))
    end = min(float(each.t[-1]) for each in (imu, tracks, fixes))
    found: VisualStart | Waiting = Waiting("IMU, camera and GNSS overlap for less than a second")
    for now in attempt_times(start, end, FIRST_ATTEMPT_S, MIN_ATTEMPT_SPACING_S):
        found = align_at(settings, imu, tracks, fixes, now)
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
