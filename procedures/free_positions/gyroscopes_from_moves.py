"""Gyroscopes from the moves between rests: gravity's direction, carried by the integrated rotation, must fit.

The model is that of the turns, ``N = K w + b``, ``K = diag(k) E``, ``b = k D`` (Tedaldi, Pretto, Menegatti, ICRA
2014). Two rows a move (carried less seen direction, across up), three a rest (its mean output is the bias and the
Earth's rate). **E refers to the accelerometers' frame**. The Earth's horizontal rate is fitted, two numbers for
every unbroken chain of moves, in axes that the chain itself carries along. A move's own bias is that of the fit
and the mean of what its two rests deviate by, as far as that is more than noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.campaign.campaign import Campaign, RestRecord, SequenceRecord
from procedures.campaign.observations import channel, rest_rates
from procedures.counts.sample_records import CountSeries, Series
from procedures.frames import rotation
from procedures.free_positions.norm_fit import MAX_RELATIVE_SCALE_STD, choose_rests, excess_scatter
from procedures.free_positions.rest_detection import rests_of, scatter_level
from procedures.geodesy import earth_rate_n
from procedures.statistics.least_squares import Fit, minimise_if_determined
from procedures.twelve_positions.accelerometer_fit import MIN_RESPONSE_SIGMAS, TriadFit
from procedures.twelve_positions.transfer_rotation import (
    AXIS_SIGNS_TRIED,
    MoveSamples,
    integrate_moves,
    joined_moves,
    move_rotations,
    padded_moves,
)
from procedures.units import STANDARD_GRAVITY


@dataclass(frozen=True, slots=True, eq=False)
class SegmentedSequence:
    """A sequence of campaign number ``campaign``: its rests and where they lie."""

    campaign: int
    record: SequenceRecord
    stretches: tuple[slice, ...]
    rests: tuple[RestRecord, ...]

    def moves(self) -> list[tuple[int, slice]]:
        """Return per move without a gap the number of the rest it begins from, and its samples."""
        gaps = self.record.series.starts
        return [
            (i, slice(before.stop, after.start)) for i, (before, after) in enumerate(pairwise(self.stretches))
            if not np.any((gaps > before.stop - 1) & (gaps <= after.start))
        ]  # fmt: skip


def segment(campaigns: Sequence[Campaign]) -> tuple[SegmentedSequence, ...]:
    """Find the rests of every sequence."""
    found = []
    for number, campaign in enumerate(campaigns):
        for record in campaign.sequences:
            measured = scatter_level(record.series)
            _, stretches = choose_rests(measured, campaign.site.gravity / STANDARD_GRAVITY)
            rests = rests_of(record, stretches)
            found.append(SegmentedSequence(number, record, tuple(stretches), rests))
    return tuple(found)


def all_rests(
    campaigns: Sequence[Campaign], segmented: Sequence[SegmentedSequence]
) -> list[tuple[int, RestRecord]]:
    """Return every rest outside the twelve positions with its campaign's number: those of sequences last."""
    alone = [(number, rest) for number, campaign in enumerate(campaigns) for rest in campaign.rests]
    return [*alone, *((each.campaign, rest) for each in segmented for rest in each.rests)]


MIN_MOVES = 6  # two rows each for nine numbers, and some to judge by
POLE_RATE_STD_DEG_S = 1e-9  # deg/s, 1 sigma of the Earth's horizontal rate at a pole
DIRECTION_STEP_RAD = 1e-6  # rad, for central differences
REWEIGHTINGS = 6  # of carrying again by what was found, and weighting again by the scatter
# rad, of a usual move: what k is tried for
MOVE_ANGLES_TRIED_RAD = np.exp(np.arange(np.log(0.1), np.log(20.0), 0.1))
MAX_CONDITION_OF_K = 1e3  # condition of K: axes all but in one plane
MAX_GUESS_ERROR_RAD = 0.5  # rad rms above which no k tried fits


@dataclass(frozen=True, slots=True, eq=False)
class MovesAndRests:
    """What m moves and r rests show: the moves' samples, which rests each move joins (m,), the rests' chains (r,).

    ``up`` (r, 3) and its 1 sigma (r,) [rad], and its change with the accelerometers' K and b (r, 3, 12); ``rate``,
    ``std`` (r, 3) [output/s] of the gyroscopes at rest; ``noise`` (3,) [output/sqrt(s)]; ``earth`` (r, 2) the
    Earth's horizontal and vertical rate [deg/s]; ``rests`` their recordings.
    """

    samples: MoveSamples
    before: IntArray
    after: IntArray
    chain: IntArray
    up: FloatArray
    up_std: FloatArray
    up_by_accelerometer: FloatArray
    rate: FloatArray
    std: FloatArray
    noise: FloatArray
    earth: FloatArray
    rests: tuple[Series, ...]


@dataclass(frozen=True, slots=True, eq=False)
class MovesFit:
    """K and b with the fit behind them, whose parameters they are first.

    ``error`` (m, 2) [rad] is by how much carried and seen directions differ and ``sigma`` (m,) its 1 sigma;
    ``scatter`` (2,) the part of it beyond noise [rad] and that of the rests' rates over k [deg/s].
    ``by_accelerometer`` (12, 12) is the change of K and b with the accelerometers' K and b. ``chi2`` and ``dof``
    judge the residual against noise alone. ``rate_error`` (r, 3) is the rests' residual [deg/s].
    """

    fit: Fit
    error: FloatArray
    sigma: FloatArray
    scatter: FloatArray
    by_accelerometer: FloatArray
    chi2: float
    dof: int
    rate_error: FloatArray

    @property
    def K(self) -> FloatArray:
        """Scale factor times misalignment (3, 3) [output/deg], rows sensors, columns the accelerometers' frame."""
        return self.fit.x[:9].reshape(3, 3)

    @property
    def b(self) -> FloatArray:
        """Scale factor times bias (3,) [output/s]."""
        return self.fit.x[9:12]


def solve_moves(
    campaigns: Sequence[Campaign], segmented: Sequence[SegmentedSequence], accelerometer: TriadFit
) -> MovesFit | None:
    """Solve k, E and D of the gyroscopes from the moves of sequences; None if they do not determine them."""
    seen = moves_and_rests(campaigns, segmented, accelerometer)
    if seen is None or (guess := first_guess(seen)) is None:
        return None
    K, b = guess
    x, scatter = np.concatenate((K.ravel(), b, np.zeros(2 * (seen.chain.max() + 1)))), np.zeros(2)
    instability = np.zeros_like(seen.rate)
    for _ in range(REWEIGHTINGS):
        if np.linalg.cond(x[:9].reshape(3, 3)) > MAX_CONDITION_OF_K:
            return None
        model = _MovesModel(seen, x, scatter, instability)
        found = minimise_if_determined(model.residual, x, model.scale)
        if found is None:
            return None
        fit = found
        x, used, scatter = fit.x, scatter, model.scatter_of(fit)
        instability = model.instability(fit.x, scatter[1])
    k = np.linalg.norm(fit.x[:9].reshape(3, 3), axis=1)
    if np.any(np.sqrt(np.diag(fit.covariance)[[0, 4, 8]]) > MAX_RELATIVE_SCALE_STD * k):
        return None
    return model.result(fit, used)


def moves_and_rests(
    campaigns: Sequence[Campaign], segmented: Sequence[SegmentedSequence], accelerometer: TriadFit
) -> MovesAndRests | None:
    """Collect moves and rests that hold both triads; None if the moves are too few."""
    if accelerometer.rests is None:
        return None
    place = {id(rest.series): i for i, (_, rest) in enumerate(accelerometer.rests.rests.rests)}
    rests, before, outputs, periods, chain = list[tuple[int, RestRecord]](), [], [], [], list[int]()
    for each in segmented:
        gyro = channel(each.record.series, "gyroscope")
        if gyro is None or any(id(rest.series) not in place for rest in each.rests):
            continue
        moves, first = each.moves(), len(rests)
        joined = {i for i, _ in moves}
        chain += np.cumsum([int(i == 0 or i - 1 not in joined) for i in range(len(each.rests))]).tolist()
        chain[first:] = [c - 1 + (max(chain[:first]) + 1 if first else 0) for c in chain[first:]]
        rests += [(each.campaign, rest) for rest in each.rests]
        period = each.record.series.period
        per_s = period if isinstance(each.record.series, CountSeries) else 1.0
        before += [first + i for i, _ in moves]
        outputs += [np.asarray(gyro[s], dtype=np.float64) / per_s for _, s in moves]
        periods += [period] * len(moves)
    at_rest = rest_rates(rests, "gyroscope")
    if len(before) < MIN_MOVES or at_rest is None:
        return None
    rows = np.array([place[id(rest.series)] for _, rest in rests])
    up, std, change = _ups(accelerometer, rows)
    earth = np.degrees([np.abs(earth_rate_n(campaigns[n].site.latitude)[1:]) for n, _ in rests])
    earth[:, 1] *= np.sign([campaigns[n].site.latitude for n, _ in rests])
    return MovesAndRests(
        padded_moves(outputs, periods), np.array(before), np.array(before) + 1, np.array(chain), up, std, change,
        at_rest.rate, at_rest.std, at_rest.noise, earth, tuple(rest.series for _, rest in rests),
    )  # fmt: skip


def _ups(accelerometer: TriadFit, rows: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return up vectors (r, 3), their 1 sigma (r,) and their change (r, 3, 12) with accelerometer K and b."""
    seen = accelerometer.rests
    assert seen is not None
    up, rests = seen.up[rows], seen.rests
    inverse = np.linalg.inv(accelerometer.K)
    std = np.hypot(np.sqrt(np.mean((rests.std[rows] / accelerometer.k) ** 2, axis=1)), seen.excess)
    across = np.eye(3) - up[:, :, None] * up[:, None, :]
    by_K = -np.einsum("ab,rj->rabj", inverse, up).reshape(len(up), 3, 9)
    by_b = np.broadcast_to(-inverse, (len(up), 3, 3))
    return up, std, across @ np.concatenate((by_K, by_b), axis=2)


def first_guess(seen: MovesAndRests) -> tuple[FloatArray, FloatArray] | None:
    """Try one k for all axes, each forward or backward.

    Returns K (3, 3) [output/deg] that carries gravity best and b (3,) [output/s]; None if no k does.
    """
    b, every = np.median(seen.rate, axis=0), seen.samples
    turned = np.linalg.norm(((every.output - b) * every.real[..., None]).sum(axis=1), axis=1)
    usual = float(np.median(turned * every.period))
    moved = [each[real] * dt for each, real, dt in zip(every.output, every.real, every.period, strict=True)]
    samples = joined_moves(moved, every.period.tolist())
    if not usual > MIN_RESPONSE_SIGMAS * float(np.median(seen.std)):
        return None
    best, found = MAX_GUESS_ERROR_RAD, None
    for signs in AXIS_SIGNS_TRIED:
        for angle in MOVE_ANGLES_TRIED_RAD:
            K = np.diag(signs) * usual / np.degrees(angle)
            carried = move_rotations(samples, K, b) @ seen.up[seen.before][..., None]
            error = float(np.sqrt(np.mean(np.sum((carried[..., 0] - seen.up[seen.after]) ** 2, axis=1))))
            if error < best:
                best, found = error, K
        if found is not None:
            return found, b
    return None


def _level(up: FloatArray) -> FloatArray:
    """Return two axes (..., 3, 2) across up, of unit length."""
    least = np.eye(3)[np.argmin(np.abs(up), axis=-1)]
    first = np.cross(up, least)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack((first, np.cross(up, first)), axis=-1)


class _MovesModel:
    """The residual about the parameters ``x0``: K (9), b (3), the Earth's horizontal rate (2) of every chain."""

    def __init__(self, seen: MovesAndRests, x0: FloatArray, scatter: FloatArray, instability: FloatArray) -> None:
        self.seen, self.x0, self.scatter = seen, x0, scatter
        K, b = x0[:9].reshape(3, 3), x0[9:12]
        self.k = np.linalg.norm(K, axis=1)
        mean_instability = (instability[seen.before] + instability[seen.after]) / 2
        steady = replace(seen.samples, output=seen.samples.output - mean_instability[:, None])
        self.carried = integrate_moves(steady, K, b)
        self.level = self._levels()
        self.across = _level(seen.up[seen.after])
        drift = np.radians(np.sqrt(np.mean((seen.noise / self.k) ** 2) * seen.samples.seconds))
        self.noise = np.sqrt(seen.up_std[seen.before] ** 2 + seen.up_std[seen.after] ** 2 + drift**2)
        first = np.unique(seen.chain, return_index=True)[1]
        self.range = np.maximum(seen.earth[first, 0] / np.sqrt(2), POLE_RATE_STD_DEG_S)
        size = np.max(np.abs(K))
        self.scale = np.concatenate((np.full(9, size), np.full(3, size), np.repeat(self.range, 2)))

    def _levels(self) -> FloatArray:
        """Return (r, 3, 2): two level axes at every rest, carried along each chain."""
        level = _level(self.seen.up)
        for move, (i, j) in enumerate(zip(self.seen.before, self.seen.after, strict=True)):
            up, axis = self.seen.up[j], self.carried.rotation[move] @ level[i, :, 0]
            axis -= up * (up @ axis)
            axis /= np.linalg.norm(axis)
            level[j] = np.stack((axis, np.cross(up, axis)), axis=-1)
        return level

    def parts(self, x: FloatArray, up: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the moves' errors (m, 2) [rad] and the rests' residual rates (r, 3) [output/s]."""
        seen, K, b = self.seen, x[:9].reshape(3, 3), x[9:12]
        horizontal = (self.level @ x[12:].reshape(-1, 2)[seen.chain][..., None])[..., 0]
        earth = seen.earth[:, 1:] * up + horizontal
        change = -(self.carried.sensitivity @ (x[:12] - self.x0[:12]))
        change += np.radians(earth[seen.after]) * seen.samples.seconds[:, None]
        seen_from = (self.carried.rotation @ up[seen.before][..., None])[..., 0]
        predicted = (rotation(change) @ seen_from[..., None])[..., 0]
        error = np.einsum("mac,ma->mc", self.across, predicted - up[seen.after])
        return error, seen.rate - earth @ K.T - b

    def residual(self, x: FloatArray, up: FloatArray | None = None) -> FloatArray:
        """Return moves, rests and what is known of the Earth's horizontal rate, whitened."""
        error, rate = self.parts(x, self.seen.up if up is None else up)
        known = x[12:].reshape(-1, 2) / self.range[:, None]
        moves = error / np.hypot(self.noise, self.scatter[0])[:, None]
        rests = rate / np.hypot(self.seen.std, self.scatter[1] * self.k)
        return np.concatenate((moves.ravel(), rests.ravel(), known.ravel()))

    def scatter_of(self, fit: Fit) -> FloatArray:
        """Return the scatter (2,) of moves [rad] and rests [deg/s] beyond noise."""
        m, r = 2 * len(self.noise), 3 * len(self.seen.rate)
        free = 1 - fit.leverage
        error, rate = self.parts(fit.x, self.seen.up)
        moves = excess_scatter(error.ravel(), np.repeat(self.noise, 2), float(free[:m].sum()))
        std = (self.seen.std / self.k).ravel()
        return np.array([moves, excess_scatter((rate / self.k).ravel(), std, float(free[m : m + r].sum()))])

    def instability(self, x: FloatArray, scatter: float) -> FloatArray:
        """Return by how much the bias at every rest (r, 3) [output/s] is likely off the mean one.

        A rest's rate deviates by instability and noise; the share of instability is the ratio of variances.
        """
        _, rate = self.parts(x, self.seen.up)
        instability = (scatter * self.k) ** 2
        likely: FloatArray = rate * instability / (instability + self.seen.std**2)
        return likely

    def result(self, fit: Fit, used: FloatArray) -> MovesFit:
        error, rate = self.parts(fit.x, self.seen.up)
        rows = [(error / self.noise[:, None]).ravel(), (rate / self.seen.std).ravel()]
        rows.append(fit.residual[-2 * len(self.range) :])
        columns = []
        for p in range(12):
            d = self.seen.up_by_accelerometer[:, :, p]
            size = DIRECTION_STEP_RAD / max(float(np.max(np.abs(d))), np.finfo(float).tiny)
            up = [self.seen.up + sign * size * d for sign in (1, -1)]
            columns.append((self.residual(fit.x, up[0]) - self.residual(fit.x, up[1])) / (2 * size))
        gain = -fit.covariance[:12] @ fit.jacobian.T @ np.stack(columns, axis=1)
        chi2 = sum(float(row @ row) for row in rows)
        return MovesFit(fit, error, np.hypot(self.noise, used[0]), used, gain, chi2, fit.dof, rate / self.k)
