"""The samples of recordings in blocks, each less its own line, and regressions on them that know of correlation.

What acts sample by sample vanishes in means over 100 s. So every channel is cut into blocks of some thousand
samples; what is slower than a block is subtracted from the channel and from every column alike. Columns are judged
by their scores ``H_b' e_b`` of every block b: under noise of whatever correlation within a block, and whatever
variance, they scatter about zero, and how much is known to as many degrees of freedom as there are blocks. So
their sum is Student t, and `procedures.inference.odds` says how much likelier the columns make it. A share is that
of the variance within blocks, on groups of blocks left out in turn.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from procedures.arrays import FloatArray
from procedures.inference import odds
from procedures.inference.marginal import log_mean
from procedures.samples.held_samples import HeldChannel, Record, Scales, held_channels

BLOCKS = 96  # of all recordings
MIN_BLOCK, MAX_BLOCK = 128, 16384  # samples
LEFT_OUT = 8  # groups of blocks
MIN_BLOCKS_PER_COLUMN = 4
MAX_CONDITION = 1e8
COUNTED_STD = 0.7  # counts: a channel that scatters less is its own rounding
AUXILIARY = "aux_"

Columns = Callable[[int, slice], FloatArray]
"""Columns (m, k) of samples of a recording, by its number."""


@dataclass(frozen=True, slots=True, eq=False)
class SampleBlocks:
    """Recordings of the same ``sensors`` in blocks: which samples of which recording each is.

    ``rates`` (b, m, s) are detrended, in natural units; ``channels`` are the sensors of every recording;
    ``auxiliary`` has the channels that all of them hold, without gaps, (n,) a recording.
    """

    sensors: tuple[HeldChannel, ...]
    channels: tuple[tuple[HeldChannel, ...], ...]
    auxiliary: dict[str, tuple[FloatArray, ...]]
    blocks: tuple[tuple[int, slice], ...]
    rates: FloatArray

    @property
    def period(self) -> float:
        """The sample period [s]."""
        return self.sensors[0].period

    def each(self) -> Iterator[tuple[int, slice, FloatArray]]:
        """Yield recording, samples and the detrended rates (m, s) of every block."""
        for (number, part), e in zip(self.blocks, self.rates, strict=True):
            yield number, part, e


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """Of every block: ``gram`` (b, k, k) of k columns, ``score`` (b, k, s) with s sensors, ``squares`` (b, s)."""

    gram: FloatArray
    score: FloatArray
    squares: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """Coefficients (k,) of the first columns for a sensor, covariance (k, k), and the share held out.

    ``order`` is how many groups of columns there are; ``gain`` is ln of the marginal likelihood over that of noise
    alone, averaged over the orders.
    """

    order: int
    value: FloatArray
    covariance: FloatArray
    gain: float
    share: float


def sample_blocks(records: Sequence[Record], scales: Scales) -> SampleBlocks | None:
    """Return the channels that all recordings have, in blocks; None where too few samples would stand in them."""
    channels = [tuple(held_channels(record, scales)) for record in records]
    kept = [(record, found) for record, found in zip(records, channels, strict=True) if _named(found)]
    if not kept:
        return None
    longest = max(kept, key=lambda each: len(each[0].series))
    alike = [
        (record, found)
        for record, found in kept
        if _named(found) == _named(longest[1]) and abs(record.series.period / longest[0].series.period - 1) < 0.01
    ]
    total = sum(len(record.series) for record, _ in alike)
    size = int(np.clip(total // BLOCKS, MIN_BLOCK, MAX_BLOCK))
    blocks = [
        (number, slice(begin, begin + size))
        for number, (_, found) in enumerate(alike)
        for part in found[0].parts
        for begin in range(part.start, part.stop - size + 1, size)
    ]
    if len(blocks) < LEFT_OUT:
        return None
    rates = np.empty((len(blocks), size, len(longest[1])))
    for i, (number, part) in enumerate(blocks):
        rates[i] = detrended(np.stack([each.rate[part] for each in alike[number][1]], axis=1))
    auxiliary = _auxiliary([record for record, _ in alike])
    return SampleBlocks(longest[1], tuple(found for _, found in alike), auxiliary, tuple(blocks), rates)


def _named(found: Sequence[HeldChannel]) -> tuple[str, ...]:
    return tuple(each.name for each in found)


def _auxiliary(records: Sequence[Record]) -> dict[str, tuple[FloatArray, ...]]:
    names = [name for name in records[0].series.extra if name.startswith(AUXILIARY)]
    found = {}
    for name in names:
        filled = [_filled(record.series.extra[name]) for record in records if name in record.series.extra]
        known = [values for values in filled if values is not None]
        if len(known) == len(records):
            found[name.removeprefix(AUXILIARY)] = tuple(known)
    return found


def _filled(values: FloatArray) -> FloatArray | None:
    """Return a channel (n,) that is known nearly everywhere, straight between; None of others and constants."""
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < 0.9 * len(values) or not np.ptp(values[known]) > 0:
        return None
    return values if len(known) == len(values) else np.interp(np.arange(len(values)), known, values[known])


def detrended(values: FloatArray) -> FloatArray:
    """Return ``values`` (m, k) in any unit less the mean and slope of each column."""
    t = np.linspace(-1.0, 1.0, len(values))[:, None]
    level: FloatArray = values - values.mean(axis=0)
    level -= t * (np.sum(t * level, axis=0) / np.sum(t * t))
    return level


def scores_of(blocks: SampleBlocks, columns: Columns) -> Scores:
    """Return what every block says of some columns."""
    gram, score = list[FloatArray](), list[FloatArray]()
    for number, part, e in blocks.each():
        H = detrended(columns(number, part))
        gram.append(H.T @ H)
        score.append(H.T @ e)
    return Scores(np.array(gram), np.array(score), np.einsum("bms,bms->bs", blocks.rates, blocks.rates))


def fit_scores(scores: Scores, sensor: int, group: int = 2) -> Fitted | None:
    """Fit a sensor by the likeliest number of groups of ``group`` columns.

    None where blocks are too few or columns do not move.
    """
    most = min(scores.gram.shape[1], len(scores.gram) // MIN_BLOCKS_PER_COLUMN) // group
    fits = list[Fitted]()
    for order in range(1, most + 1):
        k = order * group
        G, g, e2 = scores.gram[:, :k, :k], scores.score[:, :k, sensor], scores.squares[:, sensor]
        share = held_out_share(G, g, e2) if determines(G.sum(axis=0)) else None
        if share is None:
            break
        fits.append(fit_of_order(G, g, order, share))
    if not fits:
        return None
    best = max(fits, key=lambda fit: fit.gain)
    return replace(best, gain=float(log_mean(np.array([fit.gain for fit in fits]))))


def determines(gram: FloatArray) -> bool:
    """Say whether columns of a Gram matrix ``gram`` (k, k), of any unit, move, and are not each other."""
    size = np.diag(gram)
    return bool(np.all(size > 0) and np.linalg.cond(gram / np.sqrt(size[:, None] * size)) <= MAX_CONDITION)


def held_out_share(G: FloatArray, g: FloatArray, e2: FloatArray) -> float | None:
    """Return the share of the squared error that held-out blocks lose by the coefficients of all other blocks.

    None where the others do not determine them, as of a channel that moved in these blocks only.

    Parameters
    ----------
    G : (b, k, k) float64
        Gram matrix of each block.
    g : (b, k) float64
        Scores of each block, in any unit.
    e2 : (b,) float64
        Sum of the squares of each block, in the square of that unit.
    """
    edges = np.linspace(0, len(G), LEFT_OUT + 1).astype(int)
    left = 0.0
    for i, j in pairwise(edges):
        others = np.ones(len(G), dtype=bool)
        others[i:j] = False
        gram = G[others].sum(axis=0)
        if not determines(gram):
            return None
        c = np.linalg.solve(gram, g[others].sum(axis=0))
        left += float(e2[i:j].sum() - 2 * c @ g[i:j].sum(axis=0) + c @ G[i:j].sum(axis=0) @ c)
    return 1 - left / float(e2.sum())


def fit_of_order(G: FloatArray, g: FloatArray, order: int, share: float) -> Fitted:
    """Return the coefficients (k,) with their covariance by how the blocks' scores scatter, and their gain.

    The gain is that of as many columns as there are blocks for.

    Parameters
    ----------
    G, g : (b, k, k), (b, k), each block's Gram matrix and scores, in any unit
    order, share : what is known of the fit
    """
    whole, total, blocks = G.sum(axis=0), g.sum(axis=0), len(G)
    c, k = np.linalg.solve(whole, total), min(g.shape[1], blocks // MIN_BLOCKS_PER_COLUMN)
    u = g - G @ c
    inverse = np.linalg.inv(whole)
    first = u if k == g.shape[1] else g[:, :k] - G[:, :k, :k] @ np.linalg.solve(whole[:k, :k], total[:k])
    of_noise = np.linalg.pinv(first.T @ first * blocks / (blocks - k), hermitian=True)
    along = whole[:k, :k] @ of_noise
    found = odds.gain(along @ whole[:k, :k], along @ total[:k], blocks - k)
    covariance = inverse @ (u.T @ u * blocks / (blocks - k)) @ inverse
    return Fitted(order, c, covariance, found, share)
