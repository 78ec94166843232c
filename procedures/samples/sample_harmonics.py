"""How many harmonics a periodic error has, and whether a table by its phase would explain more.

The order is the one of largest marginal likelihood. A sample's error is ``H c + e``, e of variance v; of harmonic
h a coefficient is N(0, (s h^-a)^2), and s and a are averaged over a grid (MacKay, Neural Computation 4, 1992):

    ln L = -1/2 ln|A| + 1/2 b' A^-1 b,   A = I + D G D / v,   b = D g / v

with D the prior standard deviations, G = H' H, g = H' y; 0 is the likelihood of noise alone. v is widened by how
much more the scores of whole blocks scatter than those of white noise. A channel's own linear term, which an error
that jumps where the channel wraps has, is one column more, kept where it is likelier.

A table is no model: it is the mean of the samples in bins of the phase. What it explains of the residual, on
blocks held out, no number of harmonics has explained.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.special import logsumexp

from procedures.arrays import FloatArray, IntArray
from procedures.samples.sample_blocks import (
    LEFT_OUT,
    Columns,
    Fitted,
    SampleBlocks,
    Scores,
    determines,
    held_out_share,
    scores_of,
    wald,
)
from procedures.samples.sample_phases import Phase

ORDERS = (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128)  # where a table is as good
FEW = 32  # harmonics, that most errors have not: more are looked at where so many are likeliest
DECISIVE = 3.0  # ln likelihood by which a linear term must be likelier: else the harmonics do as well
SAMPLES_PER_COLUMN = 32  # of all samples, at least
SIZES, DECAYS = 12, (0.0, 1.0)  # of the grid: amplitudes, and powers of the harmonic by which they fall
LARGEST = 10.0  # amplitude, in standard deviations of a sample
BINS = 256  # of a table, at most
SAMPLES_PER_BIN = 256  # at least: of fewer the mean is worth less than it costs
MIN_TABLE_SHARE = 0.02  # of the residual's variance, held out, from which on a table says that structure is left


def with_order(
    blocks: SampleBlocks, phase: Phase, sensors: Sequence[int], trials: int
) -> tuple[bool, dict[int, Fitted]]:
    """Return whether the channel's linear term is likelier in, and each sensor's fit at its likeliest order.

    ``trials`` were made to find the phase.
    """
    most = _most(blocks, phase)
    for order in (min(most, FEW), most):
        scores = scores_of(blocks, with_linear(phase, order))
        plain = Scores(scores.gram[:, 1:, 1:], scores.score[:, 1:], scores.squares)
        found = [
            {i: likeliest(one, i, blocks.rates[:, :, 0].size, trials, linear) for i in sensors}
            for linear, one in enumerate((plain, scores))
        ]
        without, with_it = (sum(gain for _, gain in each.values()) for each in found)
        is_linear = with_it > without + DECISIVE
        fits = {i: fit for i, (fit, _) in found[is_linear].items() if fit is not None}
        if max((fit.order for fit in fits.values()), default=0) < order:
            break
    return is_linear, fits


def with_linear(phase: Phase, harmonics: int) -> Columns:
    """Return the columns (m, 1 + 2 k) of a channel's linear term, in turns, and of its harmonics."""

    def columns(number: int, part: slice) -> FloatArray:
        along = phase.turns[number][part]
        # a channel that wraps falls by a turn each time; one that does not goes on
        linear = along % 1.0 if phase.wraps else along
        return np.column_stack((linear, phase.columns(number, part, harmonics)))

    return columns


def _most(blocks: SampleBlocks, phase: Phase) -> int:
    """Return the highest order that the samples resolve: two different phases a harmonic."""
    at = np.concatenate([phase.turns[number][part] for number, part in blocks.blocks]) % 1.0
    different = len(np.unique(np.round(at * 4 * ORDERS[-1]))) // 2
    return max(min(ORDERS[-1], different, len(at) // (2 * SAMPLES_PER_COLUMN)), 1)


def likeliest(
    scores: Scores, sensor: int, samples: int, trials: int, linear: int = 0
) -> tuple[Fitted | None, float]:
    """Return a sensor's fit at its likeliest order, and its ln likelihood over that of noise alone.

    ``scores`` are of ``samples`` samples, with ``linear`` columns before the two of each harmonic.
    """
    G, g, e2 = scores.gram, scores.score[:, :, sensor], scores.squares[:, sensor]
    whole, total = G.sum(axis=0), g.sum(axis=0)
    orders = [order for order in ORDERS if linear + 2 * order <= len(total)]
    ends = [linear + 2 * order for order in orders]
    while ends and not determines(whole[: ends[-1], : ends[-1]]):
        ends.pop()
    if not ends:
        return None, 0.0
    k = ends[-1]
    c = np.linalg.solve(whole[:k, :k], total[:k])
    left = g[:, :k] - G[:, :k, :k] @ c
    white = max(float(e2.sum() - c @ total[:k]) / samples, np.finfo(float).tiny)
    wider = float(np.mean(np.sum(left**2, axis=0) / (white * np.diag(whole[:k, :k]))))
    variance = white * max(wider, 1.0)
    gains = [_log_likelihood(whole[:k, :k], total[:k], variance, linear) for k in ends]
    at = int(np.argmax(gains))
    order, k, gain = orders[at], ends[at], gains[at]
    share = held_out_share(G[:, :k, :k], g[:, :k], e2) if gain > 0 else None
    if share is None:
        return None, 0.0
    return wald(G[:, :k, :k], g[:, :k], order, share, trials, -gain), gain


def _log_likelihood(G: FloatArray, g: FloatArray, variance: float, linear: int) -> float:
    """Return ln likelihood over that of noise alone, averaged over the prior's grid."""
    k, size = len(g), np.sqrt(np.maximum(np.diag(G), np.finfo(float).tiny))
    harmonic = np.concatenate((np.ones(linear), np.repeat(np.arange(1, (k - linear) // 2 + 1), 2)))
    found = list[float]()
    for decay in DECAYS:
        shape = harmonic**-decay
        low = np.sqrt(variance) / float(np.max(size * shape))
        values, vectors = np.linalg.eigh(shape[:, None] * G * shape / variance)
        values, along = np.maximum(values, 0.0), (vectors.T @ (shape * g)) ** 2 / variance**2
        for s in np.geomspace(low, max(LARGEST * np.sqrt(variance), 2 * low), SIZES):
            wide = 1 + s**2 * values
            found.append(float(np.sum(s**2 * along / wide - np.log(wide)) / 2))
    return float(logsumexp(found) - np.log(len(found)))


def left_by_phase(
    blocks: SampleBlocks, phases: Sequence[Phase], is_usable: Sequence[bool]
) -> Iterator[tuple[Phase, int, float]]:
    """Yield a phase, sensor and the share of its residual's variance, held out, that a table by it explains."""
    size = blocks.rates.shape[1]
    group = np.repeat(np.arange(len(blocks.blocks)) * LEFT_OUT // len(blocks.blocks), size)
    for phase in phases:
        at = np.concatenate([phase.turns[number][part] for number, part in blocks.blocks]) % 1.0
        bins = int(np.clip(len(at) // SAMPLES_PER_BIN, 2, BINS))
        edges = np.unique(np.quantile(at, np.linspace(0, 1, bins + 1)))[1:-1]
        place = group * (len(edges) + 1) + np.searchsorted(edges, at, side="right")
        for sensor in np.flatnonzero(is_usable).tolist():
            if phase.sensor in {-1, sensor}:
                share = _share_of_table(place, blocks.rates[:, :, sensor].ravel(), len(edges) + 1)
                if share > MIN_TABLE_SHARE:
                    yield phase, sensor, share


def _share_of_table(place: IntArray, samples: FloatArray, bins: int) -> float:
    """Return the share of the squares of ``samples`` (n,) that groups lose by the table of all others.

    ``place`` (n,) is the number of each sample's group, times ``bins``, and of its bin.
    """
    whole = LEFT_OUT * bins
    count, total = (np.bincount(place, w, whole).reshape(LEFT_OUT, bins) for w in (None, samples))
    others = np.maximum(count.sum(axis=0) - count, 1)
    mean = (total.sum(axis=0) - total) / others
    return float(np.sum(2 * mean * total - count * mean**2) / np.sum(samples**2))
