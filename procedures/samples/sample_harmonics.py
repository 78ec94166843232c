"""How many harmonics a periodic error has, and whether a table by its phase would explain more.

The order is the one of largest marginal likelihood (`procedures.inference.odds`). A sample's error is ``H c + e``,
e of variance v; of harmonic h a coefficient is N(0, (s h^-a)^2), and s and a are averaged over a grid (MacKay,
Neural Computation 4, 1992). v is widened by how much more the scores of whole blocks scatter than those of white
noise. A channel's own linear term, which an error that jumps where the channel wraps has, is one column more, kept
where it is likelier.

A table is no model: it is the mean of the samples in bins of the phase. What it explains of the residual, on
blocks held out, no number of harmonics has explained.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.inference import odds, priors
from procedures.inference.marginal import log_mean
from procedures.samples.sample_blocks import (
    LEFT_OUT,
    Columns,
    Fitted,
    SampleBlocks,
    Scores,
    determines,
    fit_of_order,
    held_out_share,
    scores_of,
)
from procedures.samples.sample_phases import Phase

ORDERS = (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128)  # where a table is as good
FEW = 32  # harmonics, that most errors have not: more are looked at where so many are likeliest
SAMPLES_PER_COLUMN = 32  # of all samples, at least
DECAYS = (0.0, 1.0)  # powers of the harmonic by which amplitudes fall
BINS = 256  # of a table, at most
SAMPLES_PER_BIN = 256  # at least: of fewer the mean is worth less than it costs
MIN_TABLE_SHARE = 0.02  # of the residual's variance, held out, from which on a table says that structure is left


def with_order(blocks: SampleBlocks, phase: Phase, sensors: Sequence[int]) -> tuple[bool, dict[int, Fitted]]:
    """Return whether the channel's linear term is likelier in, and each sensor's fit at its likeliest order."""
    most = _most(blocks, phase)
    for order in (min(most, FEW), most):
        scores = scores_of(blocks, with_linear(phase, order))
        plain = Scores(scores.gram[:, 1:, 1:], scores.score[:, 1:], scores.squares)
        found = [
            {i: likeliest(one, i, blocks.rates[:, :, 0].size, linear) for i in sensors}
            for linear, one in enumerate((plain, scores))
        ]
        without, with_it = (sum(gain for _, gain in each.values()) for each in found)
        is_linear = bool(np.log(priors.ODDS_ANOTHER) + with_it > without)
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


def likeliest(scores: Scores, sensor: int, samples: int, linear: int = 0) -> tuple[Fitted | None, float]:
    """Return a sensor's fit at its likeliest order, and the gain there.

    Its own gain is averaged over the orders, and over two models of the noise: how the blocks scatter, and white
    noise as much wider. ``scores`` are of ``samples`` samples, with ``linear`` columns before the two of each
    harmonic.
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
    gains = np.array([_gain(whole[:k, :k] / variance, total[:k] / variance, linear) for k in ends])
    at = int(np.argmax(gains))
    order, k, most = orders[at], ends[at], float(gains[at])
    share = held_out_share(G[:, :k, :k], g[:, :k], e2) if most > 0 else None
    if share is None:
        return None, 0.0
    fit = fit_of_order(G[:, :k, :k], g[:, :k], order, share)
    return replace(fit, gain=float(log_mean(np.array([fit.gain, log_mean(gains)])))), most


def _gain(G: FloatArray, g: FloatArray, linear: int) -> float:
    """Return the gain of harmonics by their whitened G (k, k) and g (k,), averaged over how they fall."""
    harmonic: FloatArray = np.concatenate(
        (np.ones(linear), np.repeat(np.arange(1.0, (len(g) - linear) // 2 + 1), 2))
    )
    shapes: list[FloatArray] = [harmonic**-decay for decay in DECAYS]
    return float(log_mean(np.array([odds.gain(shape[:, None] * G * shape, shape * g) for shape in shapes])))


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
