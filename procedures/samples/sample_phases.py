"""Phases in which a sensor's samples may err periodically: of a channel that wraps, of any channel, of the count.

A phase is in turns. A channel that falls by nearly its whole range again and again, as a ramp or an angle does,
wraps there. In any other the period is looked for: the samples are gathered by the channel's value, and a line in
the spectrum of what they gather is a candidate. The count's own phase is what it had summed up before the sample,
modulo some whole numbers: a converter that is not straight errs by it.

How many harmonics an error has is the order of largest marginal likelihood (`procedures.inference.odds`): an error
is ``H c + e``, e of variance v; of harmonic h a coefficient is N(0, (s h^-a)^2), and s and a are averaged over a
grid (MacKay, Neural Computation 4, 1992). v is widened by how much more the scores of whole blocks scatter than
those of white noise. A channel's own linear term is one column more, kept where it is likelier.

A table is no model: it is the mean of the samples in bins of the phase. What it explains of the residual, on
blocks held out, no number of harmonics has explained.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.counts.sample_records import CountSeries
from procedures.inference import odds, priors
from procedures.inference.marginal import log_mean
from procedures.samples.held_samples import HeldChannel
from procedures.samples.sample_blocks import (
    COUNTED_STD,
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

MIN_WRAPS = 8  # of a channel, in all
WRAP_SHARE = 0.5  # of the range that a wrap falls by, at least
NATURAL = (1.0, 2 * np.pi, 360.0, *(2.0**k for k in range(3, 33)), 100.0, 1000.0, 10000.0)
NEAR_NATURAL = 0.004  # relative: a period so near is that
BINS, MIN_POWER = 8192, 12.0  # of a scan; times the background's mean
SCANNED = 2048  # periods in a scan
MODULI = (*range(2, 33), 48, 64, 100, 128, 256, 512, 1000, 1024, 2048, 4096, 8192, 16384, 32768, 65536)
SCREENED = 2  # of the moduli, for each sensor
MIN_TURNS = 1.0  # of a phase in a block: what is slower is a function of time, which a drift is as well
TIME_LIKE = 1e-9  # of a channel's variance that a line in time leaves, below which it is a clock


@dataclass(frozen=True, slots=True, eq=False)
class Phase:
    """A candidate: ``turns`` (n,) of every recording; ``channel``, ``period`` in its unit.

    ``tried`` is how many were looked at to find it; ``sensor`` the only one that it is of, -1 of any. ``wraps``
    says that the channel itself falls by a period at each turn.
    """

    channel: str
    period: float
    turns: tuple[FloatArray, ...]
    tried: int = 1
    sensor: int = -1
    wraps: bool = False

    def columns(self, number: int, part: slice, harmonics: int) -> FloatArray:
        """Return a part's columns (m, k), without unit: cosine and sine of each of k / 2 ``harmonics``."""
        turning = np.exp(2j * np.pi * (self.turns[number][part] % 1.0))
        powers = np.cumprod(np.broadcast_to(turning[:, None], (len(turning), harmonics)), axis=1)
        return np.stack((powers.real, powers.imag), axis=2).reshape(len(turning), -1)

    @property
    def step(self) -> float:
        """How many turns it goes on from a sample to the next, usually, at most half a turn."""
        step = np.diff(self.turns[0])
        return float(np.median(np.abs(step - np.round(step))))


def channel_phases(blocks: SampleBlocks) -> Iterator[Phase]:
    """Yield the phases of every auxiliary channel."""
    yield from (phase for phase in _channel_phases(blocks) if _turns_in_a_block(blocks, phase) >= MIN_TURNS)


def _turns_in_a_block(blocks: SampleBlocks, phase: Phase) -> float:
    return float(phase.step * blocks.rates.shape[1])


def _channel_phases(blocks: SampleBlocks) -> Iterator[Phase]:
    for name, values in blocks.auxiliary.items():
        period = _wrap(values)
        if period is not None:
            yield Phase(name, period, tuple(value / period for value in values), wraps=True)
        elif not all(_is_clock(value) for value in values):
            yield from _scanned(blocks, name, values)


def _wrap(values: tuple[FloatArray, ...]) -> float | None:
    """Return the period of a channel that wraps, None of one that does not."""
    low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    steps = np.concatenate([np.diff(v) for v in values])
    wraps = np.abs(steps) > WRAP_SHARE * (high - low)
    small = np.abs(steps[~wraps])
    # a ramp goes one way between its wraps; noise or a sine as large as its range does not
    if wraps.sum() < MIN_WRAPS or not len(small) or wraps.mean() > 0.6:
        return None
    signs = np.sign(steps[wraps])
    if abs(signs.mean()) < 0.9 or np.mean(np.sign(steps[~wraps]) == signs[0]) > 0.2:
        return None
    modulus = float(np.median(np.abs(steps[wraps]))) + float(np.median(small))
    modulus = max(modulus, high - low)
    return next((one for one in NATURAL if abs(modulus / one - 1) < NEAR_NATURAL), modulus)


def _is_clock(values: FloatArray) -> bool:
    t = np.linspace(-1, 1, len(values))
    level = values - values.mean()
    left = level - t * np.dot(t, level) / np.dot(t, t)
    return bool(np.dot(left, left) <= TIME_LIKE * np.dot(level, level))


def _scanned(blocks: SampleBlocks, name: str, values: tuple[FloatArray, ...]) -> Iterator[Phase]:
    """Yield the periods, the double of each too, at which samples gathered by a channel's value have a line."""
    low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    gathered = np.zeros((BINS, len(blocks.sensors)))
    for number, part, e in blocks.each():
        at = np.minimum(((values[number][part] - low) / (high - low) * BINS).astype(np.int64), BINS - 1)
        for sensor in range(e.shape[1]):
            gathered[:, sensor] += np.bincount(at, e[:, sensor], BINS)
    power = np.abs(np.fft.rfft(gathered, 2 * BINS, axis=0)[2 : 2 + SCANNED]) ** 2
    background = np.maximum(np.median(power, axis=0) / np.log(2), np.finfo(float).tiny)
    found = set[int]()
    for sensor in range(power.shape[1]):
        best = int(np.argmax(power[:, sensor]))
        if power[best, sensor] > MIN_POWER * background[sensor]:
            found.add(best)
    for best in sorted(found)[:3]:
        shortest = _refined(gathered, (high - low), best + 2)
        for period in (shortest, 2 * shortest):
            yield Phase(name, period, tuple(value / period for value in values), SCANNED)


def _refined(gathered: FloatArray, span: float, best: int) -> float:
    """Return the period near the line number ``best`` of a scan that samples gathered (bins, s) go with most.

    It is a natural one if that is hardly worse.
    """
    at = (np.arange(BINS) + 0.5) / BINS * span

    def power(period: float) -> float:
        return float(np.max(np.abs(np.exp(-2j * np.pi * at / period) @ gathered)))

    near = max((2 * span / (best + step) for step in np.linspace(-1, 1, 81)), key=power)
    natural = [
        one / k for one in NATURAL for k in (1, 2, 3, 4, 6, 8, 12) if abs(near * k / one - 1) < NEAR_NATURAL
    ]
    return next((one for one in natural if power(one) > 0.95 * power(near)), near)


def count_phases(blocks: SampleBlocks) -> Iterator[Phase]:
    """Yield, for each sensor that counts, the moduli of its sum by which its samples differ most."""
    for sensor, channel in enumerate(blocks.sensors):
        if not isinstance(channel.series, CountSeries):
            continue
        sums = [_sum_before(found[sensor]) for found in blocks.channels]
        if is_rounded(blocks, sensor):
            continue
        by_sample = float(np.median(np.abs(np.diff(sums[0]))))
        moduli = [n for n in MODULI if by_sample * blocks.rates.shape[1] >= MIN_TURNS * n]
        before = np.concatenate([np.floor(sums[number][part]) for number, part in blocks.blocks]).astype(np.int64)
        samples = blocks.rates[:, :, sensor].ravel()
        screened = sorted(moduli, key=lambda n: -_between(samples, before, n))[:SCREENED]
        for n in sorted({*screened, *(n // 2 for n in screened if n % 2 == 0 and n > 2)}):
            yield Phase(f"sum of {channel.name}", float(n), tuple(s / n for s in sums), len(MODULI), sensor)


def _sum_before(channel: HeldChannel) -> FloatArray:
    """Return what a channel had counted before each sample (n,), and what it would count by its mean."""
    counts = channel.rate / channel.quantum * channel.period
    total = np.cumsum(counts) - counts
    return np.asarray(np.round(total) + counts.mean())


def _between(samples: FloatArray, before: IntArray, n: int) -> float:
    """Return by how much samples (m,) differ between residues modulo n of counts, over what noise makes of it."""
    residue = before % n
    total, count = np.bincount(residue, samples, n), np.bincount(residue, minlength=n)
    seen = count > 0
    dof = max(int(seen.sum()) - 1, 1)
    between = float(np.sum(total[seen] ** 2 / count[seen])) / float(np.mean(samples**2))
    return float((between - dof) / np.sqrt(2 * dof))


def is_rounded(blocks: SampleBlocks, sensor: int) -> bool:
    """Say whether a sensor's samples scatter by less than its counts: what they do then is their own rounding."""
    channel = blocks.sensors[sensor]
    squares = np.mean(blocks.rates[:, :, sensor] ** 2, axis=1)
    return bool(np.sqrt(np.median(squares)) < COUNTED_STD * channel.step)


ORDERS = (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128)  # where a table is as good
FEW = 32  # harmonics, that most errors have not: more are looked at where so many are likeliest
SAMPLES_PER_COLUMN = 32  # of all samples, at least
DECAYS = (0.0, 1.0)  # powers of the harmonic by which amplitudes fall
TABLE_BINS = 256  # of a table, at most
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
        bins = int(np.clip(len(at) // SAMPLES_PER_BIN, 2, TABLE_BINS))
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
