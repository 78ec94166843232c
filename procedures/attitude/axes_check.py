"""Whether gyros and accelerometers speak of the same axes, in the same units.

Averaged over a second *in a frame that the rates say does not turn*, the specific force is gravity and little
motion. If the rates are right, the next second's average, carried back by the rates in between, points the same
way. Each other reading of the rates is tried too: signs changed, axes exchanged, degrees taken for radians. Only
one under which the averages agree far better than under the axes as given is believed; in a flight's turns none
does.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.frames import rotation

BLOCK_S, BLOCKS_PER_WINDOW = 0.05, 20  # a window is a second
MAX_WINDOWS = 3600  # windows that are looked at
MIN_TILT_CHANGE = np.radians(20.0)  # of gravity in the body, before anything is judged
MAX_MISFIT_RATIO = 0.35  # of the squared disagreement that is left
TIE_RATIO = 1.5  # times the least that is left: readings that cannot be told apart; the fewest changes are named
RATE_LETTERS = "pqr"


@dataclass(frozen=True, slots=True)
class AxesDisagreement:
    """What the rates seem to be: ``reading`` such as "p,-q,r", ``in_degrees``, the row at which it is clear."""

    reading: str
    in_degrees: bool
    row: int


def disagreement(log: AttitudeLog) -> AxesDisagreement | None:
    """Return how gyros and accelerometers disagree, None where they agree or the log cannot tell."""
    rows = max(round(BLOCK_S / log.nominal), 1)
    windows = min(len(log.t) // (rows * BLOCKS_PER_WINDOW), MAX_WINDOWS)
    if windows < 3:
        return None
    used = windows * BLOCKS_PER_WINDOW * rows
    force = log.f_b[:used].reshape(windows, BLOCKS_PER_WINDOW, rows, 3).mean(axis=2)
    turn = (log.omega_b * log.intervals[:, None])[:used].reshape(windows, BLOCKS_PER_WINDOW, rows, 3).sum(axis=2)
    tilt = _angles_to_first(force.mean(axis=1))
    if tilt.max() < MIN_TILT_CHANGE:
        return None
    readings = [(scale, S) for scale in (1.0, np.pi / 180) for S in _signed_permutations()]
    carried = {
        (scale, sign): _carried(sign * scale * turn) for scale in (1.0, np.pi / 180) for sign in (1.0, -1.0)
    }
    left = [_left(S, carried[scale, np.linalg.det(S).round()], force) for scale, S in readings]
    unturned = _left(
        np.eye(3), _carried(0 * turn), force
    )  # as in flight, where the specific force follows the wings
    least = min(left)
    if least > MAX_MISFIT_RATIO * min(left[0], unturned):  # the first reading is that of the axes as given
        return None
    near = [reading for reading, value in zip(readings, left, strict=True) if value < TIE_RATIO * least]
    scale, S = max(near, key=lambda reading: float(np.trace(reading[1])))
    return AxesDisagreement(
        _named(S), scale != 1.0, int(np.argmax(tilt >= MIN_TILT_CHANGE)) * BLOCKS_PER_WINDOW * rows
    )


def _carried(turn: FloatArray) -> FloatArray:
    """Return rotations (windows, blocks + 1, 3, 3) to the start, from each block's middle and from the end."""
    C = np.broadcast_to(np.eye(3), (len(turn), 3, 3))
    found = np.empty((len(turn), BLOCKS_PER_WINDOW + 1, 3, 3))
    for i in range(BLOCKS_PER_WINDOW):
        found[:, i] = C @ rotation(0.5 * turn[:, i])
        C = C @ rotation(turn[:, i])
    found[:, BLOCKS_PER_WINDOW] = C
    return found


def _left(S: FloatArray, carried: FloatArray, force: FloatArray) -> float:
    """Return the mean square sine between one window's average force and the next's, read by ``S``.

    A signed exchange of axes turns ``exp([theta])`` into ``S exp(det S [theta]) S'``.
    """
    mean = np.einsum("wbij,wbj->wi", carried[:, :BLOCKS_PER_WINDOW], force @ S)
    after = np.einsum("wij,wj->wi", carried[:-1, BLOCKS_PER_WINDOW], mean[1:])
    norm = np.linalg.norm(mean[:-1], axis=1) * np.linalg.norm(after, axis=1)
    cosine = np.sum(mean[:-1] * after, axis=1) / np.maximum(norm, 1e-9)
    return float(np.mean(1.0 - cosine)) + 1e-9


def _angles_to_first(direction: FloatArray) -> FloatArray:
    unit = direction / np.maximum(np.linalg.norm(direction, axis=1), 1e-9)[:, None]
    angles: FloatArray = np.arccos(np.clip(unit @ unit[0], -1, 1))
    return angles


def _signed_permutations() -> list[FloatArray]:
    """Return the 48 ways to read three axes, the axes as they are first."""
    return [
        np.diag(signs) @ np.eye(3)[list(order)]
        for order in itertools.permutations(range(3))
        for signs in itertools.product((1.0, -1.0), repeat=3)
    ]


def _named(S: FloatArray) -> str:
    return ",".join(("-" if row.min() < 0 else "") + RATE_LETTERS[int(np.argmax(np.abs(row)))] for row in S)
