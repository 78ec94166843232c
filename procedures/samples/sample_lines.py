"""Lines that come again in every recording, or whose frequency drifts, as that of a dither driven with noise.

Such a line has no phase to fit, but a power. So recordings are cut into pieces, first as long as a recording, then
ever shorter ones, in which a drifting line still stands; the periodograms of all pieces, each over its own
background, are summed, of one sensor or of a triad's together. Under noise of any colour and variance a sum of B
over its neighbours' is that of 2 B squares, which a line makes larger. A resonance that noise drives stands out as
well. But its power in a piece is exponentially distributed, that of a line, rho times the noise, by the noncentral
chi-square of 2 degrees of freedom. Both share what is there: before the data a resonance is
`RESONANCES` times as likely in shorter pieces, in whole recordings, which resolve most resonances, as many times
less.

Of a line slower than a block of samples the block's own straight line takes most, so the whole recording shows it:
frequency and sine are those of the recording's spectrum. A slow line that is a cycle of the bias, or of a
temperature that the bias follows, has its name already.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.optimize import minimize_scalar
from scipy.special import ive

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.effects import CATALOGUE
from procedures.effects.excitation import PERIOD
from procedures.frames import AXES, TRIADS
from procedures.inference import odds
from procedures.inference.priors import PRESENT
from procedures.inference.result import Finding, FoldedResidual
from procedures.samples.sample_blocks import Fitted, SampleBlocks, Scores, fit_scores, scores_of
from procedures.samples.sample_findings import (
    MIN_LINE_SHARE,
    SEPARATE_LINE,
    SampleFinding,
    folded_by_phase,
    line_in_time,
    with_std,
    without_finding,
)
from procedures.samples.sample_phases import Phase
from procedures.statistics.spectrum import (
    BACKGROUND_DOF,
    MEDIAN_OF_EXPONENTIAL,
    MIN_PERIODS,
    WINDOW_BINS,
    Line,
    background_of,
    has_line,
    lines_of,
    sine_at,
    without_straight_line,
)
from procedures.units import DEG_H_PER_DEG_S

EFFECT = "disturbance.line"
MIN_PIECE, SHORTER, MIN_PIECES = 512, 4, 6  # samples; times, from one length to the next; pieces
WHOLE = 0.98  # of a part, so that parts of nearly one length give a piece each
NEAR = 12  # neighbours on either side that tell what noise has
NEIGHBOURS_DOF = 10.0  # of their median, for each piece: 18 values that hang together under Hann's window
RESONANCES = 20.0  # as likely as a line at a peak of short pieces, which do not resolve them
MIN_SHARE = 1e-3  # of a sensor's variance


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """A sensor's pieces: ``power`` (b, m), what noise has there (b, m), and the variance within pieces."""

    power: FloatArray
    background: FloatArray
    variance: float

    def square(self, at: int) -> FloatArray:
        """Return the square of a line's amplitude at a bin, in each piece (b,)."""
        near, length = slice(at - 2, at + 3), 2 * (self.power.shape[1] - 1)
        found: FloatArray = 4 / length * np.sum(self.power[:, near] - self.background[:, near], axis=1)
        return found


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """A line at a bin of pieces of ``length`` samples of some sensors: ln odds over noise, and probability."""

    sensors: tuple[int, ...]
    length: int
    pieces: int
    at: int
    log_odds: float
    probability: float


def repeated_lines(blocks: SampleBlocks, is_usable: Sequence[bool], names: list[str]) -> Iterator[Finding]:
    """Yield the strongest such line of each triad."""
    parts = np.array([part.stop - part.start for channels in blocks.channels for part in channels[0].parts])
    lengths = _lengths(parts)
    for triad in TRIADS:
        sensors = [i for i, each in enumerate(blocks.sensors) if each.triad == triad and is_usable[i]]
        groups = {(s,) for s in sensors} | {tuple(sensors)} if sensors else set[tuple[int, ...]]()
        found = list[tuple[_Line, dict[int, _Pieces]]]()
        for length in lengths:
            pieces = {s: _pieces(blocks, s, length) for s in sensors}
            resonances = 1 / RESONANCES if length > 0.9 * np.median(parts) else RESONANCES
            lines = [
                _line(pieces, group, length, len(groups) * len(lengths), resonances) for group in sorted(groups)
            ]
            found += [(line, pieces) for line in lines if line.probability >= PRESENT]
        if found:
            yield from _findings(blocks, triad, *max(found, key=lambda each: each[0].log_odds), names)


def _lengths(parts: IntArray) -> list[int]:
    """Return the even lengths [samples] of pieces: of parts (p,), the long ones and all, and shorter."""
    typical = {float(np.median(parts[parts >= parts.max() / 2])), float(np.median(parts))}
    found = sorted((int(WHOLE * n) for n in typical), reverse=True)
    while found[-1] // SHORTER >= MIN_PIECE:
        found.append(found[-1] // SHORTER)
    return [n // 2 * 2 for n in found if n >= MIN_PIECE and np.sum(parts // n) >= MIN_PIECES]


def _line(
    pieces: dict[int, _Pieces], sensors: tuple[int, ...], length: int, tried: int, resonances: float
) -> _Line:
    """Return the strongest line of some sensors together; a resonance is ``resonances`` times as likely."""
    ratio = np.concatenate([pieces[s].power / pieces[s].background for s in sensors])
    begin = int(MIN_PERIODS)
    total = ratio.sum(axis=0)
    over = total / _neighbours(total)
    over[:begin], over[-WINDOW_BINS:] = 0.0, 0.0
    at, count = int(np.argmax(over)), len(ratio)
    gain = float(odds.gain_of_squares(2 * count * over[at], 2 * count, NEIGHBOURS_DOF * count))
    of_line = odds.log_odds(gain, (len(over) - begin) * tried)
    noise = total[at] / over[at] / count
    over_resonance = sum(
        _over_resonance(pieces[s].power[:, at] / pieces[s].background[:, at] / noise) for s in sensors
    )
    found = odds.shares({EFFECT: of_line, "resonance": of_line + np.log(resonances) - over_resonance})
    return _Line(sensors, length, count // len(sensors), at, of_line, found[EFFECT])


def _pieces(blocks: SampleBlocks, sensor: int, length: int) -> _Pieces:
    window = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(length) + 0.5) / length)
    parts = [(channels[sensor].rate, part) for channels in blocks.channels for part in channels[sensor].parts]
    level = without_straight_line(np.concatenate([_cut(rate[part], length) for rate, part in parts]))
    power = np.abs(np.fft.rfft(level * window)) ** 2 / float(window @ window)
    return _Pieces(power, background_of(power, int(MIN_PERIODS)), float(np.mean(level**2)))


def _cut(rate: FloatArray, length: int) -> FloatArray:
    """Return the pieces (b, length) of a part (n,), in its unit, but for what is left at its end."""
    return rate[: len(rate) // length * length].reshape(-1, length)


def _neighbours(total: FloatArray) -> FloatArray:
    """Return the median (m,) of what stands about each value (m,), but for those that its own line reaches."""
    padded = np.pad(total, NEAR, mode="reflect")
    steps: IntArray = np.array([k for k in range(-NEAR, NEAR + 1) if abs(k) > WINDOW_BINS])
    found: FloatArray = np.median(padded[NEAR + np.arange(len(total))[:, None] + steps], axis=1)
    return np.maximum(found, np.finfo(float).tiny)


def _over_resonance(power: FloatArray) -> float:
    """Return ln of how much likelier one amplitude is than a resonance, by powers (b,) of which noise has 1."""
    rho = float(power.mean()) - 1
    if rho <= 0:
        return 0.0
    of_line = -((np.sqrt(power) - np.sqrt(rho)) ** 2) + np.log(ive(0, 2 * np.sqrt(rho * power)))  # I0 e^-x
    of_resonance = -power / (1 + rho) - np.log(1 + rho)
    return float(np.sum(of_line - of_resonance))


def _findings(
    blocks: SampleBlocks, triad: str, line: _Line, pieces: dict[int, _Pieces], names: list[str]
) -> Iterator[Finding]:
    """Yield the finding of a line that is a large enough share of a sensor's variance."""
    squares = {s: pieces[s].square(line.at) for s in line.sensors}
    shares = {s: float(each.mean()) / 2 / pieces[s].variance for s, each in squares.items()}
    shown = [s for s, share in shares.items() if share > MIN_SHARE]
    if not shown:
        return
    factor, unit = (DEG_H_PER_DEG_S, "deg/h") if triad == "gyroscope" else (1.0, "g")
    amplitude = np.array([np.sqrt(squares[s].mean()) for s in shown])
    std = np.array([squares[s].std() for s in shown]) / np.sqrt(line.pieces) / (2 * amplitude)
    seconds = line.length * blocks.period
    stretches = f"{with_std(line.at / seconds, 0.5 / seconds)} Hz in {line.pieces} stretches of {seconds:.4g} s"
    yield Finding(
        EFFECT, "procedure", tuple(triad[0] + AXES[blocks.sensors[s].axis] for s in shown), factor * amplitude,
        factor * std, unit, {"file": names}, line.probability,
        SEPARATE_LINE, f"{stretches}; it may be any multiple of {1 / blocks.period:.5g} Hz away",
        share=min(max(shares.values()), 1.0),
    )  # fmt: skip


MAX_SPAN = 2**22  # samples from the first to the last
PARTS_OF_A_SAMPLE = 16  # to which recordings must stand on one grid, to be transformed together
PADDING = 2  # times as many frequencies as samples
SPREAD, ABOUT = 1.5, 24.0  # over a recording's length: left out about a line, and the noise about it, either way
PERIODS_OF_A_BLOCK = 3.0  # that a block holds of a line at the least: of a slower one its own line takes much


@dataclass(frozen=True, slots=True, eq=False)
class CoherentLine:
    """A line as a phase of time, and what it does to each sensor that it is of, by number.

    ``tried`` is how many frequencies and groups of sensors were looked at.
    """

    phase: Phase
    hertz: float
    tried: int
    fitted: dict[int, Fitted]


def coherent_line(blocks: SampleBlocks, is_usable: Sequence[bool]) -> CoherentLine | None:
    """Return the likeliest line of recordings with one clock; None where none stands out, or there is but one."""
    if len(blocks.channels) < 2:
        return None
    triads = [[i for i, s in enumerate(blocks.sensors) if s.triad == triad and is_usable[i]] for triad in TRIADS]
    groups = [group for group in triads if group] + [[i] for group in triads for i in group if len(group) > 1]
    spectra = _spectra(blocks, [i for group in triads for i in group])
    if spectra is None or not groups:
        return None
    power, span = spectra
    tried = len(groups) * span // 2
    found = [
        (*_stands_out(blocks, np.sum([power[i] for i in group], axis=0), len(group)), group) for group in groups
    ]
    gain, at, group = max(found, key=lambda each: each[0])
    if odds.log_odds(gain, tried) < 0:
        return None
    hertz = _refined(blocks, group, at / (2 * (len(power[group[0]]) - 1) * blocks.period), span)
    phase = Phase("time", 1 / hertz, tuple(hertz * channels[0].series.t for channels in blocks.channels))
    scores = scores_of(blocks, lambda number, part: phase.columns(number, part, 1))
    fits = {i: fit for i in group if (fit := fit_scores(scores, i)) is not None and fit.share > 0}
    # the blocks must show it as well, at this frequency: one loud block has lines of its own
    by_blocks = max((fit.gain for fit in fits.values()), default=-np.inf)
    if odds.log_odds(by_blocks, len(group)) < 0 or not _is_of_one_phase(blocks, scores, list(fits)):
        return None
    return CoherentLine(phase, hertz, tried, {i: replace(fit, gain=gain) for i, fit in fits.items()})


def _is_of_one_phase(blocks: SampleBlocks, scores: Scores, sensors: Sequence[int]) -> bool:
    """Say whether one phase is likelier than another one in each recording."""
    numbers = np.array([which for which, _ in blocks.blocks])
    for sensor in sensors:
        variance = float(scores.squares[:, sensor].sum()) / blocks.rates[:, :, 0].size
        parts = [numbers == which for which in np.unique(numbers)]
        own = [_explained(scores, sensor, here) for here in parts]
        more = (sum(own) - _explained(scores, sensor, np.ones(len(numbers), dtype=bool))) / variance
        if odds.gain_of_squares(np.array(more), 2 * (len(parts) - 1)) > 0:
            return False
    return True


def _explained(scores: Scores, sensor: int, here: BoolArray) -> float:
    """Return the squares that cosine and sine explain of a sensor in some blocks, marked (b,)."""
    gram, score = scores.gram[here].sum(axis=0)[:2, :2], scores.score[here].sum(axis=0)[:2, sensor]
    return float(score @ np.linalg.solve(gram, score))


def _spectra(blocks: SampleBlocks, sensors: Sequence[int]) -> tuple[dict[int, FloatArray], int] | None:
    """Return each sensor's power over its noise, and the samples from first to last; None without one clock."""
    times = [channels[0].series.t for channels in blocks.channels]
    order = sorted(range(len(times)), key=lambda i: times[i][0])
    if any(times[j][0] <= times[i][-1] for i, j in pairwise(order)):
        return None
    first, period = times[order[0]][0], blocks.period
    span = round((times[order[-1]][-1] - first) / period) + 1
    if span > MAX_SPAN:
        return None
    length = next_fast_len(PADDING * span, real=True)
    length += length % 2
    turns = np.arange(length // 2 + 1) / length
    groups = dict[int, list[tuple[int, slice, int]]]()
    for number, (which, part) in enumerate(blocks.blocks):
        begin = (times[which][part.start] - first) / period
        fine = round(begin * PARTS_OF_A_SAMPLE)
        groups.setdefault(fine % PARTS_OF_A_SAMPLE, []).append((number, part, fine // PARTS_OF_A_SAMPLE))
    found = dict[int, FloatArray]()
    for sensor in sensors:
        total = np.zeros(len(turns), dtype=complex)
        for fine, pieces in groups.items():
            laid = np.zeros(length)
            for number, part, at in pieces:
                laid[at : at + part.stop - part.start] = blocks.rates[number, :, sensor]
            total += rfft(laid) * np.exp(-2j * np.pi * turns * fine / PARTS_OF_A_SAMPLE)
        power = np.abs(total) ** 2
        found[sensor] = power / float(np.median(power))
    return found, span


def _stands_out(blocks: SampleBlocks, power: FloatArray, sensors: int) -> tuple[float, int]:
    """Return the gain of the frequency that stands out most of ``power`` (m,), and its number."""
    per_hertz = 2 * (len(power) - 1) * blocks.period
    longest = max(len(channels[0].rate) for channels in blocks.channels) * blocks.period
    about, spread = (max(int(per_hertz * size / longest), 2) for size in (ABOUT, SPREAD))
    chunks = np.array_split(power, max(len(power) // (2 * about), 1))
    coarse = np.concatenate([np.full(len(each), np.median(each)) for each in chunks])
    over = power / np.maximum(coarse, np.finfo(float).tiny)
    slowest = max(MIN_PERIODS / longest, PERIODS_OF_A_BLOCK / (blocks.rates.shape[1] * blocks.period))
    over[: int(per_hertz * slowest)] = 0.0  # what is slower was subtracted with each block's line
    at = int(np.argmax(over))
    near = np.concatenate((power[max(at - about, 0) : max(at - spread, 0)], power[at + spread : at + about]))
    if not len(near):
        return 0.0, at
    median = MEDIAN_OF_EXPONENTIAL if sensors == 1 else sensors - 1 / 3  # of a gamma distribution
    recorded = sum(len(channels[0].rate) for channels in blocks.channels) * blocks.period
    independent = len(near) / per_hertz * recorded
    ratio = float(power[at] / np.median(near)) * median / sensors
    squares = np.array(2 * sensors * ratio)
    return float(odds.gain_of_squares(squares, 2 * sensors, max(sensors * independent, 2.0))), at


def _refined(blocks: SampleBlocks, sensors: Sequence[int], hertz: float, span: int) -> float:
    """Return the frequency [Hz] near one at which the sensors' power is largest."""
    middles = [blocks.channels[which][0].series.t[part] for which, part in blocks.blocks]

    def less(at: float) -> float:
        turning = [np.exp(-2j * np.pi * at * t) for t in middles]
        total = sum(wave @ e for wave, e in zip(turning, blocks.rates[:, :, list(sensors)], strict=True))
        return -float(np.sum(np.abs(total) ** 2))

    step = 1 / (PADDING * span * blocks.period)
    found = minimize_scalar(less, bounds=(hertz - step, hertz + step), method="bounded", options={"maxiter": 15})
    return float(found.x)


def without_slow_lines(
    blocks: SampleBlocks, is_usable: Sequence[bool], named: Sequence[Finding], known: Sequence[SampleFinding]
) -> tuple[SampleBlocks, list[SampleFinding], list[FoldedResidual]]:
    """Return blocks less the lines that are slower than they are, and those that no finding in ``named`` is.

    What is ``known`` of the samples is subtracted first: it may be slower than a block as well.

    The last are the means of the recording by the phase of each.
    """
    found, folded = list[SampleFinding](), list[FoldedResidual]()
    if len(blocks.channels) > 1 or len(blocks.sensors[0].parts) > 1:
        return blocks, found, folded
    level = np.stack([without_straight_line(each.rate) for each in blocks.sensors], axis=1)
    whole = replace(blocks, blocks=((0, slice(0, len(level))),), rates=level[None])
    for one in known:
        whole = without_finding(whole, one)
    for one in list(_slow_lines(blocks, whole, is_usable)):
        before, blocks, whole = whole, without_finding(blocks, one), without_finding(whole, one)
        if not all(_has_name(one, whole, sensor, named) for sensor in one.fitted):
            found.append(one)
            folded += folded_by_phase(one, before, whole)
    return blocks, found, folded


def _slow_lines(blocks: SampleBlocks, whole: SampleBlocks, is_usable: Sequence[bool]) -> Iterator[SampleFinding]:
    """Yield the lines of a ``whole`` recording that are slower than one of its blocks, the strongest first."""
    n, period = whole.rates.shape[1], whole.period
    tried, found = n // 2 * sum(is_usable), list[tuple[float, int, Line]]()
    for sensor in np.flatnonzero(is_usable).tolist():
        noise = float(np.mean(blocks.rates[:, :, sensor] ** 2))
        for line in lines_of(whole.rates[0, :, sensor], period):
            share = line.amplitude**2 / 2 / (line.amplitude**2 / 2 + noise)
            is_slow = line.hertz * period * blocks.rates.shape[1] < 1
            if is_slow and share > MIN_LINE_SHARE and odds.log_odds(_gain(line), tried) > 0:
                found.append((share, sensor, line))
    found.sort(key=lambda each: -each[0])
    while found:
        line = found[0][2]
        same = [each for each in found if abs(each[2].hertz - line.hertz) * n * period < 1]
        found = [each for each in found if each not in same]
        rates, turns = whole.rates[0], line.hertz * period
        fits = {sensor: _fitted(each, share, rates[:, sensor], turns) for share, sensor, each in same}
        yield SampleFinding(replace(line_in_time(line, period, n), tried=tried), fits)


def _gain(line: Line) -> float:
    return float(odds.gain_of_squares(np.array((line.amplitude / line.amplitude_std) ** 2), 2, BACKGROUND_DOF))


def _fitted(line: Line, share: float, rate: FloatArray, turns: float) -> Fitted:
    sine = sine_at(rate, turns)
    value: FloatArray = np.array([sine.real, -sine.imag])
    return Fitted(1, value, line.amplitude_std**2 * np.eye(2), _gain(line), share)


def _has_name(one: SampleFinding, whole: SampleBlocks, sensor: int, named: Sequence[Finding]) -> bool:
    """Say whether a finding of the sensor's triad is a cycle of the line's period, or what a temperature does."""
    channel, phase = whole.sensors[sensor], one.candidate.phase
    assert phase is not None
    seconds = len(channel.rate) * channel.period
    of_triad = [each for each in named if each.effect.partition(".")[0] == channel.triad]
    periods = [each.value[each.coefficients.index(PERIOD)] for each in of_triad if PERIOD in each.coefficients]
    if any(abs(1 / phase.period - 1 / period) * seconds < 1 for period in periods):
        return True
    drivers = {CATALOGUE[each.effect].driver for each in of_triad if each.effect in CATALOGUE}
    return "temperature" in drivers and has_line(channel.series.temperature, channel.period, 1 / phase.period)
