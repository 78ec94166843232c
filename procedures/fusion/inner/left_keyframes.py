"""Keyframes that have left a window: where they stood by what was measured since, and how they err together.

Each was eliminated with what tied it to the next, so that its step is ``-S d`` for a step d of what stayed
(Rauch, Tung, Striebel 1965). Without a camera alone, for landmarks tie more than a keyframe and the next.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.inner.window_factor import Factor
from procedures.fusion.inner.window_problem import Gone, Held
from procedures.fusion.inner.window_state import COMMON, FRAME, PLACE, WindowState


@dataclass(frozen=True, slots=True, eq=False)
class Left:
    """A keyframe and the next, ``two``, what ``held`` them, and how the first was eliminated."""

    two: WindowState
    held: Held
    gone: Gone


def swept_back(left: Sequence[Left], after: WindowState) -> list[WindowState]:
    """Return each keyframe that has left by the step that the one after leaves it, and ``after``, the last."""
    states = [after]
    for each in reversed(left):
        step = states[-1].less(each.two.part(slice(1, None)))
        gone = -(each.gone.by[:, :-1] @ step + each.gone.by[:, -1])
        states.append(each.two.part(slice(1)).moved(np.r_[step[:COMMON], gone]))
    return states[::-1]


def shares(left: Sequence[Left], window: Factor, frames: int, end: int) -> FloatArray:
    """Return each step's covariance (m, 3, 3) [m2] with the way from the oldest keyframe to ``end``.

    There are m = n + frames - 1 steps. The first ``end`` of them sum up to the covariance of that way. It is a
    column of the inverse of all keyframes' normal equations, so that it takes one sweep on and one back.

    Parameters
    ----------
    left : n keyframes, the oldest of the way first
    window : factor of what follows them, ``frames`` keyframes
    end : index of the way's last keyframe, counted from the oldest
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
    along: FloatArray = np.diff(np.array(found[::-1])[:, PLACE], axis=0)
    return along
