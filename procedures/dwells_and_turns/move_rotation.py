"""What the gyroscopes' samples between rests make of a direction: the rotation of each move and how it changes.

    R = prod of rotation(-phi_k),  phi_k = w_k dt + (phi_(k-1) x phi_k) / 12,    w = K^-1 (N - b)

A direction ``u`` fixed in space and seen as ``u`` before is seen as ``R u`` after. The cross product is the
two-sample rotation vector (Savage, J. Guidance 21, 1998): a hand turns about changing axes within a sample.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.frames import rotation

CONING = 1 / 12
WHOLE = 1 << 40  # samples, a power of 2: a part as long as any move
SAMPLES_AT_ONCE = 2000  # of short moves together: a call costs as much as many samples, but memory is slow
AXIS_SIGNS_TRIED = tuple(itertools.product((1.0, -1.0), repeat=3))


@dataclass(frozen=True, slots=True, eq=False)
class MoveRotations:
    """Rotation (m, 3, 3) of every move and the change of its rotation vector [rad] with K and b, (m, 3, 12).

    The rotation at other parameters is ``rotation(-(sensitivity @ change)) @ rotation`` to first order.
    """

    rotation: FloatArray
    sensitivity: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class MoveSamples:
    """The gyroscopes' outputs of m moves, (m, s, 3) [output/s], padded at the end, and what is ``real`` (m, s)."""

    output: FloatArray
    real: BoolArray
    period: FloatArray  # (m,) s

    @property
    def seconds(self) -> FloatArray:
        """How long each move took (m,)."""
        total: FloatArray = self.real.sum(axis=1) * self.period
        return total

    def rates(self, K: FloatArray, b: FloatArray) -> FloatArray:
        """Return rates (m, s, 3) [deg/s], 0 where padded, by ``K`` (3, 3) [output/deg], ``b`` (3,) [output/s]."""
        return (self.output - b) @ np.linalg.inv(K).T * self.real[..., None]


def padded_moves(moves: Sequence[FloatArray], period: Sequence[float]) -> MoveSamples:
    """Put moves (s_i, 3) [output/s] into one array."""
    longest = max(len(move) for move in moves)
    output = np.zeros((len(moves), longest, 3))
    real = np.zeros((len(moves), longest), dtype=bool)
    for row, (mask, move) in enumerate(zip(real, moves, strict=True)):
        mask[: len(move)] = True
        output[row, : len(move)] = move
    return MoveSamples(output, real, np.array(period))


def integrate_moves(samples: MoveSamples, K: FloatArray, b: FloatArray) -> MoveRotations:
    """Integrate every move for K (3, 3) [output/deg] and b (3,) [output/s]."""
    w = samples.rates(K, b)
    dt = samples.period[:, None, None]
    small = _sample_rotations(dt, w)
    means = (np.eye(3) + 4 * rotation(-np.radians(w) * dt / 2) + small) / 6  # Simpson's, from within to its end
    to_end = np.broadcast_to(np.eye(3), (len(w), 3, 3)).copy()
    by_rate, by_time = np.zeros((len(w), 3, 3, 3)), np.zeros((len(w), 3, 3))
    for k in range(w.shape[1] - 1, -1, -1):
        of_sample = to_end @ means[:, k]
        by_rate += of_sample[..., None] * w[:, k, None, None, :]
        by_time += of_sample * samples.real[:, k, None, None]
        to_end = to_end @ small[:, k]
    inverse = -np.radians(np.linalg.inv(K))
    by_K: FloatArray = np.einsum("mabj,bi->maij", by_rate, inverse).reshape(len(w), 3, 9)
    sensitivity = np.concatenate((by_K, by_time @ inverse), axis=2) * dt
    return MoveRotations(to_end, sensitivity)


def rotations_to_end(samples: MoveSamples, K: FloatArray, b: FloatArray) -> FloatArray:
    """Return the rotations (m, s, 3, 3) from the middle of every sample to the end of its move.

    ``K`` (3, 3) is in output/deg, ``b`` (3,) in output/s.
    """
    w = samples.rates(K, b)
    small = _sample_rotations(samples.period[:, None, None], w)
    found, to_end = np.empty_like(small), np.broadcast_to(np.eye(3), (len(w), 3, 3))
    for k in range(w.shape[1] - 1, -1, -1):
        before = to_end @ small[:, k]
        found[:, k] = (to_end + before) / 2
        to_end = before
    return found


def move_rotations(samples: MoveSamples, K: FloatArray, b: FloatArray) -> FloatArray:
    """Return the rotations (m, 3, 3) alone, neighbours multiplied in pairs, which is faster.

    ``K`` (3, 3) is in output/deg, ``b`` (3,) in output/s.
    """
    return part_rotations(samples, K, b, WHOLE)[:, 0]


def part_rotations(samples: MoveSamples, K: FloatArray, b: FloatArray, size: int) -> FloatArray:
    """Return the rotations (m, p, 3, 3) of parts of ``size`` samples, a power of 2; none where a move is over.

    ``K`` (3, 3) is in output/deg, ``b`` (3,) in output/s.
    """
    w = samples.rates(K, b)
    lengths, dt = samples.real.sum(axis=1), samples.period[:, None, None]
    at_once = max(SAMPLES_AT_ONCE // w.shape[1], 1)
    found = np.tile(np.eye(3), (len(w), -(-w.shape[1] // size), 1, 1))
    for first in range(0, len(w), at_once):  # a move that took long does not lengthen those of other parts
        some = slice(first, first + at_once)
        parts = product(_sample_rotations(dt[some], w[some, : lengths[some].max()]), size)
        found[some, : parts.shape[1]] = parts
    return found


def product(small: FloatArray, size: int = 0) -> FloatArray:
    """Return the products (m, 3, 3) of rotations ``small`` (m, s, 3, 3), the last one leftmost.

    With ``size``, a power of 2, those (m, p, 3, 3) of so many neighbours each.
    """
    joined = 1
    while small.shape[1] > 1 and joined != size:
        if small.shape[1] % 2:
            small = np.concatenate((small, np.broadcast_to(np.eye(3), (len(small), 1, 3, 3))), axis=1)
        small, joined = small[:, 1::2] @ small[:, ::2], 2 * joined
    return small if size else small[:, 0]


def _sample_rotations(period: FloatArray, w: FloatArray) -> FloatArray:
    """Return the rotations (..., s, 3, 3) of samples of ``period`` [s], for rates ``w`` (..., s, 3) [deg/s]."""
    step = np.radians(w) * period
    step[..., 1:, :] += CONING * np.cross(step[..., :-1, :], step[..., 1:, :])
    return rotation(-step)
