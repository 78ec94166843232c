"""Odometry steps of a window, revised when later measurements change them.

The steps between all keyframes that are still in the window are reported again with each new one; the oldest of
them stays where it was reported.

*An outage of velocities* is kept until some seconds after its end: the first velocities after it determine most of
the one error that bends it. Its steps err together, yet a graph's are independent. But nothing is measured between
its ends, so that only the displacement d from end to end counts, and how its steps s_k share in a correction of d.
Independent steps of

    Q_k = cov(s_k, d),   sum Q_k = cov(d)

do what the path itself does: d has its covariance, and d moved by x moves s_k by ``Q_k cov(d)^-1 x``, the mean of
s_k given that. A keyframe was eliminated with what tied it to the next, so that its step is ``-S d`` for a step d
of what stayed (Rauch, Tung, Striebel 1965); not with a camera, whose landmarks tie more than a keyframe and the
next.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.inner.window_problem import BackSubstitution, WindowMeasurements
from procedures.fusion.inner.window_state import COMMON, FRAME, PLACE, Factor, WindowState
from procedures.fusion.odometry import OdometryPose


@dataclass(frozen=True, slots=True, eq=False)
class MarginalisedKeyframe:
    """A keyframe and the next, ``two``, what ``held`` them, and how the first was eliminated."""

    two: WindowState
    held: WindowMeasurements
    gone: BackSubstitution


def smoothed_states(left: Sequence[MarginalisedKeyframe], after: WindowState) -> list[WindowState]:
    """Return each keyframe that has left by the step that the one after leaves it, and ``after``, the last."""
    states = [after]
    for each in reversed(left):
        step = states[-1].less(each.two.part(slice(1, None)))
        gone = -(each.gone.by[:, :-1] @ step + each.gone.by[:, -1])
        states.append(each.two.part(slice(1)).moved(np.r_[step[:COMMON], gone]))
    return states[::-1]


def shares(left: Sequence[MarginalisedKeyframe], window: Factor, frames: int, end: int) -> FloatArray:
    """Return each step's covariance (m, 3, 3) [m2] with the path from the oldest keyframe to ``end``.

    There are m = n + frames - 1 steps. The first ``end`` of them sum up to the covariance of that path. It is a
    column of the inverse of all keyframes' normal equations, so that it takes one sweep on and one back.

    Parameters
    ----------
    left : n keyframes, the oldest of the path first
    window : factor of what follows them, ``frames`` keyframes
    end : index of the path's last keyframe, counted from the oldest
    """
    ends = np.zeros((len(left) + frames, FRAME, 3))
    ends[0, PLACE], ends[end, PLACE] = -np.eye(3), np.eye(3)
    pulls, common = list[FloatArray](), np.zeros((COMMON, 3))
    pull = ends[0]
    for each, own in zip(left, ends[1:], strict=False):
        pulls.append(pull)
        passed = each.gone.by[:, :-1].T @ pull
        common, pull = common - passed[:COMMON], own - passed[COMMON:]
    moved = window.solve(np.vstack((common, pull, *ends[len(left) + 1 :])))
    common, steps = moved[:COMMON], moved[COMMON:].reshape(frames, FRAME, 3)
    last, found = steps[0], list(steps[::-1])
    for each, pull in zip(reversed(left), reversed(pulls), strict=True):
        last = each.gone.factor.solve(pull) - each.gone.by[:, :-1] @ np.vstack((common, last))
        found.append(last)
    return np.diff(np.array(found[::-1])[:, PLACE], axis=0)


REVISE_AT_VELOCITIES = (1, 4, 16, 64)  # velocities behind an outage: 1, 2, 4, 8 and so on gave the same figures
SETTLED_S = 5.0  # s of velocities behind an outage until its motion is left as it is known
MAX_OUTAGE_S = 120.0  # s of an outage that are estimated again: what lies before stays as it was reported
VARIANCE_FACTOR = 2.0  # of an outage's variance: measured on real IMUs, docs/how-to/locate.md


class RevisedPath:
    """``poses`` are the window's but the newest, behind those of an outage whose keyframes have left it."""

    def __init__(self) -> None:
        self.poses = list[OdometryPose]()
        self._left = list[MarginalisedKeyframe]()
        self._is_kept = False  # from the first pose on, for an outage
        self._end = self._heard = 0  # the keyframe at which that ended; velocities since
        self._shift = np.zeros(3)  # m from the window's places to those reported

    @property
    def open_since(self) -> float | None:
        """The time [s] from which the path may still be revised."""
        return self.poses[0].t if self.poses else None

    def slid(self, left: MarginalisedKeyframe) -> None:
        """Take note that the window's oldest keyframe has left it."""
        if self._is_kept:
            self._left.append(left)
        elif self.poses:
            del self.poses[0]

    def add(self, pose: OdometryPose) -> None:
        """Add the newest pose as it is reported."""
        self.poses.append(pose)
        if self._left and not self._end and pose.t - self.poses[0].t > MAX_OUTAGE_S:
            del self.poses[0], self._left[0]

    def listen(self, has_velocity: bool, is_outage: bool) -> bool:
        """Count a new keyframe, and return whether it is time to look back on an outage.

        That is at the first velocities behind it and when it is settled.
        """
        if is_outage and self.poses and (self._end or not self._is_kept):
            self._release()
            self._is_kept = True
        if not self._is_kept or not (has_velocity or self._end):
            return False
        self._end = self._end or len(self.poses)
        self._heard += has_velocity
        return (has_velocity and self._heard in REVISE_AT_VELOCITIES) or self._is_settled()

    def revise(
        self, state: WindowState, factor: Factor, least: float, looks_back: bool
    ) -> tuple[OdometryPose, ...]:
        """Have the poses as they are known now, and return those that have changed.

        ``state`` and ``factor`` are the window's, ``least`` [m2/s] is the density of a step's variance that none
        falls below.
        """
        left = self._left if looks_back else []
        first = len(self._left) - len(left)
        known = [*(each.part(slice(1)) for each in smoothed_states(left, state)[:-1]), state]
        p, C = (np.concatenate([getattr(each, name) for each in known]) for name in ("p", "C_ob"))
        if first < len(self.poses):
            self._shift = self.poses[first].p_o - p[0]
        for k, pose in enumerate(self.poses[first + 1 :], 1):
            self.poses[first + k] = replace(pose, p_o=p[k] + self._shift, C_ob=C[k])
        if looks_back:
            self._share(shares(left, factor, len(state.p), self._end), least)
        revised = tuple(self.poses[first + 1 :])
        if self._is_settled():
            self._release()
        return revised

    def newest(self, state: WindowState) -> FloatArray:
        """Return the newest place (3,) [m] as it is reported."""
        newest: FloatArray = state.p[-1] + self._shift
        return newest

    def _share(self, along: FloatArray, least: float) -> None:
        for k, P in enumerate(along[: min(self._end, len(self.poses) - 1)], 1):
            drift = self.poses[k].drift.copy()
            drift[:3, :3] = _at_least(VARIANCE_FACTOR * P, least * (self.poses[k].t - self.poses[k - 1].t))
            self.poses[k] = replace(self.poses[k], drift=drift)

    def _is_settled(self) -> bool:
        return bool(self._end) and self.poses[-1].t - self.poses[min(self._end, len(self.poses) - 1)].t > SETTLED_S

    def _release(self) -> None:
        del self.poses[: len(self._left)]
        self._left, self._is_kept, self._end, self._heard = [], False, 0, 0


def _at_least(P: FloatArray, least: float) -> FloatArray:
    """Return the symmetric part of P (3, 3), with no variance below ``least``."""
    size, axes = np.linalg.eigh((P + P.T) / 2)
    found: FloatArray = (axes * np.maximum(size, least)) @ axes.T
    return found
