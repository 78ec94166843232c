"""The rotation of a transfer between two rests, integrated from the gyroscopes, and its partial derivatives.

    R = prod of rotation(-phi_k),  phi_k = w_k dt + (phi_(k-1) x phi_k) / 12,    w = K^-1 (N - b)

A direction fixed in space and seen as ``u`` before is seen as ``R u`` after. The cross product is the two-sample
rotation vector (Savage, J. Guidance 21, 1998); the summed output is first drawn through by a quintic spline.
Coning that is left falls with the fourth power of the sample period or faster: a fifth of the difference to half
the sample rate bounds it, taken of parts of half a second by the root of the sum of squares.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.counts.sample_records import CountSeries, Series
from procedures.frames import rotation, rotation_vector

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


FINE_HZ = 200.0  # above which a sample is short enough for the two-sample algorithm
LINEAR_HZ = 50.0  # enough for the change of a rotation with scale factors and bias
COARSE_HZ = 10.0  # enough to try which scale factors turn the cube over at all
SPLINE_ORDER = 5
PART_S = 0.5  # s, of a move: a period or two of what trembles
SHARE_OF_HALF_RATE = 1 / 5  # of the change that half the sample rate makes: 1 sigma of the error


@dataclass(frozen=True, slots=True, eq=False)
class FinerRotations:
    """Rotation (m, 3, 3) of m moves and its change (m, 3, 12) with K and b, as `MoveRotations` has it.

    ``squares`` (m,) [rad2] is the sum of the squared angles of the samples.
    """

    rotation: FloatArray
    sensitivity: FloatArray
    squares: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class FinerMoves:
    """The outputs of m moves [output/s]: ``fine``, drawn through; ``half``, the same of half of both.

    ``linear`` and ``coarse`` join samples: for the change of a rotation, and for trying.

    ``seconds`` (m,) is how long each took; ``counting`` (m,) is 1 where the output counts, else 0. A ``part`` is
    so many samples of ``fine``, a power of 2 and whole samples of half the rate.
    """

    fine: MoveSamples
    half: MoveSamples
    linear: MoveSamples
    coarse: MoveSamples
    seconds: FloatArray
    counting: FloatArray
    part: int

    def integrate(self, K: FloatArray, b: FloatArray) -> FinerRotations:
        """Integrate every move for K (3, 3) [output/deg] and b (3,) [output/s]."""
        found = product(part_rotations(self.fine, K, b, self.part))
        angle = np.radians(self.linear.rates(K, b)) * self.linear.period[:, None, None]
        squares = np.sum(angle**2, axis=(1, 2))
        return FinerRotations(found, integrate_moves(self.linear, K, b).sensitivity, squares)

    def coning(self, K: FloatArray, b: FloatArray) -> FloatArray:
        """Return 1 sigma (m,) [rad] of what coning leaves open of each component.

        ``K`` (3, 3) is in output/deg, ``b`` (3,) in output/s.
        """
        parts = part_rotations(self.fine, K, b, self.part)
        half = part_rotations(self.half, K, b, self.part // 2)
        off = rotation_vector(half @ np.swapaxes(parts[:, : half.shape[1]], 2, 3))
        coning: FloatArray = SHARE_OF_HALF_RATE * np.sqrt(np.sum(np.mean(off**2, axis=2), axis=1))
        return coning

    def variances(self, squares: FloatArray, K: FloatArray, b: FloatArray, noise: FloatArray) -> FloatArray:
        """Return (m, 3) [rad2] of each component of the rotations: by white noise, by rounding, by coning.

        Parameters
        ----------
        squares : (m,) [rad2], as `FinerRotations` has them
        K, b : (3, 3) [output/deg], (3,) [output/s]
        noise : (3,) [output/sqrt(s)]
        """
        k = np.linalg.norm(K, axis=1)
        white = np.radians(np.sqrt(np.mean((noise / k) ** 2) * self.seconds))
        rounding = np.radians(np.sqrt(np.mean(1 / k**2) * self.counting * (2 + squares) / 12))
        return np.column_stack((white, rounding, self.coning(K, b))) ** 2


def finer_moves(series: Sequence[Series]) -> FinerMoves:
    """Draw the gyroscopes' outputs of m gap-free moves through, finely enough to integrate."""
    turned = [_turned(each) for each in series]
    periods = [each.period for each in series]
    parts = [_power_of_2(FINE_HZ * period) for period in periods]
    short = [period / part for period, part in zip(periods, parts, strict=True)]
    fine = [_drawn(each, part) for each, part in zip(turned, parts, strict=True)]
    half = [_halved(each, part) for each, part in zip(turned, parts, strict=True)]
    return FinerMoves(
        _samples(fine, short), _samples(half, [2 * each for each in short]),
        joined_moves(turned, periods, LINEAR_HZ), joined_moves(turned, periods),
        np.array([len(each) for each in series]) * periods,
        np.array([float(isinstance(each, CountSeries)) for each in series]),
        max(_power_of_2(PART_S / float(np.median(short))), 2 * max(parts)),
    )  # fmt: skip


def _power_of_2(near: float) -> int:
    """Return the power of 2, 1 at the least, nearest to a number."""
    return int(2 ** max(round(np.log2(near)), 0))


def _turned(series: Series) -> FloatArray:
    """Return what every sample turned (n, 3) [output]."""
    assert series.gyro is not None
    per_sample = 1.0 if isinstance(series, CountSeries) else series.period
    turned: FloatArray = np.asarray(series.gyro, dtype=np.float64) * per_sample
    return turned


def _samples(turned: Sequence[FloatArray], periods: Sequence[float]) -> MoveSamples:
    return padded_moves([each / period for each, period in zip(turned, periods, strict=True)], periods)


def joined_moves(turned: Sequence[FloatArray], periods: Sequence[float], hz: float = COARSE_HZ) -> MoveSamples:
    """Return moves ``turned`` (s_i, 3) [output] with samples joined, ``hz`` [1/s] of them left or more."""
    sizes = [joined_samples(period, hz) for period in periods]
    joined = [_joined(each, size) for each, size in zip(turned, sizes, strict=True)]
    return _samples(joined, [period * size for period, size in zip(periods, sizes, strict=True)])


def joined_samples(period: float, hz: float) -> int:
    """Return how many samples of ``period`` [s] joined leave ``hz`` [1/s] of them or more, where there are any."""
    return max(int(1 / (hz * period)), 1)


def _joined(turned: FloatArray, size: int) -> FloatArray:
    """Return the sums of ``size`` neighbours; what is missing in the last is taken to go on as its mean did."""
    missing = -len(turned) % size
    if missing:
        rest = turned[missing - size :].mean(axis=0)
        turned = np.vstack((turned, np.tile(rest, (missing, 1))))
    joined: FloatArray = turned.reshape(-1, size, 3).sum(axis=1)
    return joined


def _halved(turned: FloatArray, parts: int) -> FloatArray:
    """Return what `_drawn` makes of half the samples, in parts twice as long; an odd last one is one of them."""
    even = len(turned) // 2 * 2
    return np.vstack((_drawn(_joined(turned[:even], 2), parts), turned[even:]))


def _drawn(turned: FloatArray, parts: int) -> FloatArray:
    """Return what each of ``parts`` parts of every sample turned, by a spline through the sums."""
    if parts == 1:
        return turned
    from scipy.interpolate import make_interp_spline  # a tenth of a second to import, which most solves do without

    edges = np.arange(len(turned) + 1.0)
    sums = np.vstack((np.zeros(3), np.cumsum(turned, axis=0)))
    fine = np.arange(len(turned) * parts + 1) / parts
    drawn: FloatArray = np.diff(make_interp_spline(edges, sums, k=min(SPLINE_ORDER, len(turned)))(fine), axis=0)
    return drawn
