"""Data association: which GNSS fix belongs to which node of the odometry; a store of both that grows.

The heading of an odometry's frame is that of its track against the track of GNSS (`track_yaw`). With positions as
complex numbers, East + i North, ``q`` the odometry's and ``z`` GNSS's, both about their means, ``z = exp(i yaw)
q`` gives ``yaw = arg sum conj(q) z``; so do velocities (Han 2022 aligns positions only). Outliers count less
(Huber).
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from procedures.arrays import FloatArray, IntArray
from procedures.frames import wrapped
from procedures.fusion.fusion_records import GnssFixes
from procedures.fusion.odometry import OdometryPose
from procedures.fusion.pose_graph_terms import FixTerms, OdometrySteps, huber

Complex = NDArray[np.complex128]
MAX_TRACK_MISFIT = 4.0  # of the misfit above which the tracks are not the same motion
HUBER_LIMIT = 1.9  # of a whitened vector of two: 95 % efficient on clean fixes
CHI2_MEDIAN = 1.386  # of two degrees of freedom
HUBER_ITERATIONS = 8
TINY = 1e-12


@dataclass(frozen=True, slots=True)
class TrackYaw:
    """``yaw`` [rad], 1 sigma, ``spread`` [m] rms of the odometry's track about its mean.

    ``misfit`` is the median of the whitened residuals squared over what noise alone would give, of positions or of
    velocities, whichever fit worse.
    """

    yaw: float
    std: float
    spread: float
    misfit: float


def track_yaw(
    q: FloatArray, z: FloatArray, z_std: FloatArray, v: FloatArray, u: FloatArray, u_std: FloatArray, drift: float
) -> TrackYaw:
    """Return the yaw that turns the odometry's track onto GNSS's.

    Parameters
    ----------
    q, z : (n, 2), m
        Horizontal positions of odometry and GNSS at the same times; ``z_std`` (n,) is 1 sigma of each axis.
    v, u : (n, 2), m/s
        Their velocities, nan where there is none; ``u_std`` (n,) is 1 sigma of each axis of the difference.
    drift : m2
        Variance that the odometry's own drift adds at the end of the track.
    """
    track, fixed = _complex(q), _complex(z)
    ours, theirs = _complex(v), _complex(u)
    known = np.isfinite(ours * theirs)
    ours, theirs, u_weight = ours[known], theirs[known], 1 / u_std[known] ** 2
    given = 1 / (z_std**2 + drift)
    weight, v_weight = given, u_weight
    for _ in range(HUBER_ITERATIONS):
        local, fix = track - np.average(track, weights=weight), fixed - np.average(fixed, weights=weight)
        turned = np.sum(weight * np.conj(local) * fix) + np.sum(v_weight * np.conj(ours) * theirs)
        turn = np.exp(1j * np.angle(turned))
        off, v_off = np.abs(fix - local * turn) * np.sqrt(given), np.abs(theirs - ours * turn) * np.sqrt(u_weight)
        weight, v_weight = given * huber(off, HUBER_LIMIT), u_weight * huber(v_off, HUBER_LIMIT)
    power, v_power = float(np.sum(weight * np.abs(local) ** 2)), float(np.sum(v_weight * np.abs(ours) ** 2))
    spread = float(np.mean(np.abs(local) ** 2))
    # white noise averages out over the fixes; drift does not: it is one draw over the whole track
    systematic = min(drift / max(spread, TINY), 1 / max(v_power, TINY))
    misfit = max(float(np.median(part**2)) for part in (off, v_off) if len(part)) / CHI2_MEDIAN
    std = np.sqrt(max(misfit, 1.0) * (1 / max(power + v_power, TINY) + systematic))
    return TrackYaw(float(np.angle(turned)), float(std), float(np.sqrt(spread)), misfit)


def _complex(pairs: FloatArray) -> Complex:
    return pairs[:, 0] + 1j * pairs[:, 1]


MIN_COURSE_SPEED = 0.5  # m/s, below which a course says nothing
COURSE_STD = np.radians(4.0)  # 1 sigma of a course however fast: odometry's velocity over a frame is not GNSS's
UNSTEADY_ACCELERATION = 2.0  # m/s2 by which a motion may differ from a straight one between two poses
MOTION_SIGMAS = 3.0  # sigmas of velocity that are a motion
YAW_TRACK_S = 60.0  # s of track behind the yaw by track: what is older has drifted
_NODE = np.dtype([("t", "f8"), ("p_o", "f8", 3), ("C_ob", "f8", (3, 3)), ("drift", "f8", (4, 4))])
_FIX = np.dtype([  # as `FixTerms`, and GNSS's velocity
    ("node", "i8"), ("arm_o", "f8", 3), ("C_of", "f8", (3, 3)), ("v_o", "f8", 3), ("tau", "f8"), ("z", "f8", 3),
    ("weight", "f8"), ("course", "f8"), ("course_weight", "f8"), ("v_n", "f8", 3), ("v_std", "f8"),
])  # fmt: skip


class _Rows:
    """Rows that are appended, in one array that doubles when it is full."""

    def __init__(self, row: np.dtype[np.void]) -> None:
        self._array, self.count = np.zeros(256, row), 0

    def append(self, *values: FloatArray | float) -> None:
        if self.count == len(self._array):
            self._array = np.concatenate((self._array, np.zeros_like(self._array)))
        self._array[self.count] = values
        self.count += 1

    def set(self, row: int, *values: FloatArray | float) -> None:
        self._array[row] = values

    def cut(self, count: int) -> int:
        """Drop the rows behind the first ``count``; return how many."""
        dropped, self.count = self.count - count, count
        return dropped

    def get(self, name: str, first: int = 0, end: int | None = None) -> NDArray[Any]:
        return self._array[name][first : self.count if end is None else end]


class FixAssociation:
    """Odometry poses and the fixes that are tied to them.

    ``lever_arm`` (3,) [m] and ``time_offset`` [s], added to stamps, are what later fixes are associated by.
    """

    def __init__(self, lever_arm: FloatArray, time_offset: float) -> None:
        self.lever_arm, self.time_offset = lever_arm, time_offset
        self.fixes: GnssFixes | None = None
        self.yaw_std: float | None = None
        self._uses_velocity = False
        self._nodes, self._terms = _Rows(_NODE), _Rows(_FIX)
        self._next = 0  # of the fixes

    @property
    def t(self) -> FloatArray:
        """Times (n,) of all nodes [s]."""
        return self._nodes.get("t")

    @property
    def p_o(self) -> FloatArray:
        """Their odometry positions (n, 3) [m]."""
        return self._nodes.get("p_o")

    @property
    def C_ob(self) -> FloatArray:
        """Their odometry attitudes (n, 3, 3)."""
        return self._nodes.get("C_ob")

    def add(self, pose: OdometryPose) -> int:
        """Add a node and the fixes up to its time; return how many."""
        self._nodes.append(pose.t, pose.p_o, pose.C_ob, pose.drift)
        self.yaw_std, self._uses_velocity = pose.yaw_std, pose.uses_velocity
        return self._associate_up_to(pose.t) if self._nodes.count > 1 else 0

    def revise(self, poses: Sequence[OdometryPose]) -> None:
        """Have ``poses`` stand for the newest ones, and associate the fixes at them again."""
        first = max(len(self.t) - len(poses), 0)
        for node, pose in enumerate(poses[first - len(self.t) :], first):
            self._nodes.set(node, pose.t, pose.p_o, pose.C_ob, pose.drift)
        self._next -= self._terms.cut(int(np.searchsorted(self._terms.get("node"), first)))
        self._associate_up_to(float(self.t[-1]))

    def associate_again(self, time_offset: float) -> None:
        """Associate all fixes again, at another time offset."""
        self._terms, self._next, self.time_offset = _Rows(_FIX), 0, time_offset
        self._associate_up_to(float(self.t[-1]))

    def last_step(self) -> tuple[FloatArray, FloatArray]:
        """Return the last step (3,) in o [m] and its drift (4, 4)."""
        return self.p_o[-1] - self.p_o[-2], self._nodes.get("drift")[-1]

    def window(
        self, first: int, end: int | None = None, fixes_of: int | None = None
    ) -> tuple[OdometrySteps, FixTerms]:
        """Return nodes ``first`` to ``end`` with the fixes of all, or of the first ``fixes_of`` of them."""
        p_o, drift = (self._nodes.get(name, first, end) for name in ("p_o", "drift"))
        last = len(self.t) if end is None else end
        last = last if fixes_of is None else first + fixes_of
        begin, stop = np.searchsorted(self._terms.get("node"), (first, last)).tolist()
        node, *others = (self._terms.get(field.name, begin, stop) for field in fields(FixTerms))
        steps = OdometrySteps(np.diff(p_o, axis=0), np.asarray(np.linalg.inv(drift[1:]), np.float64))
        return steps, FixTerms(node - first, *others)

    def yaw_by_track(self) -> TrackYaw:
        """Return the heading of the odometry's frame by the last minute of track."""
        recent = self.t[self._terms.get("node")] > self.t[-1] - YAW_TRACK_S
        get = {name: self._terms.get(name)[recent] for name in _FIX.names or ()}
        node, antenna = get["node"], get["C_of"] @ self.lever_arm
        q = self.p_o[node] + get["arm_o"] + antenna
        v_o, z, z_std = get["v_o"][:, :2], get["z"][:, :2], get["weight"] ** -0.5
        changed = np.r_[0.0, np.linalg.norm(np.diff(v_o, axis=0), axis=1)]  # blurs a velocity over a frame
        v_std = np.sqrt(get["v_std"] ** 2 + self._walk(node) ** 2 + (0.5 * changed) ** 2)
        moves = np.linalg.norm(v_o, axis=1) > MOTION_SIGMAS * v_std  # more than the noise at rest
        total = float(self._nodes.get("drift")[int(node[0]) :, 0, 0].sum())
        return track_yaw(
            q[:, :2], z, z_std, np.where(moves[:, None], v_o, np.nan), get["v_n"][:, :2], v_std, total
        )

    def _associate_up_to(self, t: float) -> int:
        assert self.fixes is not None
        added = 0
        while self._next < len(self.fixes.t) and self.fixes.t[self._next] + self.time_offset <= t:
            if self.fixes.t[self._next] + self.time_offset > self.t[0]:
                self._associate(self.fixes, self._next)
                added += 1
            self._next += 1
        return added

    def _associate(self, fixes: GnssFixes, i: int) -> None:
        """Tie a fix to the first node at or after it, by the straight motion between the two nodes."""
        t, before = fixes.t[i] + self.time_offset, self._terms.get("node")[-1:].tolist()
        node = max(int(np.searchsorted(self.t, t)), 1, *before)
        dt = self.t[node] - self.t[node - 1]
        back = (self.t[node] - t) / dt
        v_o = (self.p_o[node] - self.p_o[node - 1]) / dt
        C = self.C_ob[node - 1 : node + 1]
        v_antenna = v_o + (C[1] - C[0]) @ self.lever_arm / dt
        off = 0.5 * UNSTEADY_ACCELERATION * min(back, 1 - back) ** 2 * dt**2  # m
        course, course_weight = self._course(fixes, i, v_antenna, self._walk(node))
        self._terms.append(
            node, -back * dt * v_o, back * C[0] + (1 - back) * C[1], v_antenna, self.time_offset, fixes.p_n[i],
            1 / (fixes.position_std[i] ** 2 + off**2), course, course_weight, fixes.v_n[i], fixes.velocity_std[i],
        )  # fmt: skip

    def _walk(self, node: IntArray | int) -> FloatArray:
        """Return 1 sigma [m/s] of an odometry's velocity over a frame, by what it says of its drift."""
        std: FloatArray = np.sqrt(self._nodes.get("drift")[node, 0, 0]) / (self.t[node] - self.t[node - 1])
        return std

    def _course(self, fixes: GnssFixes, i: int, v_o: FloatArray, v_o_std: FloatArray) -> tuple[float, float]:
        """Return GNSS's course less that of the odometry's velocity, from East to North, and its weight."""
        v, speed = fixes.v_n[i, :2], float(np.hypot(*v_o[:2]))
        course = np.arctan2(v[1], v[0]) if np.isfinite(v).all() else np.pi / 2 - fixes.course[i]
        if self._uses_velocity or not np.isfinite(course) or speed < MIN_COURSE_SPEED:
            return 0.0, 0.0
        difference = float(wrapped(course - np.arctan2(v_o[1], v_o[0])))
        return difference, 1 / (COURSE_STD**2 + (fixes.velocity_std[i] ** 2 + float(v_o_std) ** 2) / speed**2)
