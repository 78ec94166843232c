"""A line of one phase in all recordings of a campaign, such as a dither that sampling has brought down.

The recordings have one clock, so their samples are laid where they were taken, nought between, and one spectrum
resolves the whole campaign: a line that stays below noise in every dwell stands out of all of them together. Under
noise the power over that of the frequencies about it, those left out that the gaps spread a line to, is F
distributed; every frequency, sensor and triad together is counted. What stands out must also hold block by block
(`procedures.diagnosis.sample_blocks`), whatever the noise's correlation is, and be of one phase: what
recordings have one by one is for `procedures.diagnosis.sample_lines`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.optimize import minimize_scalar

from procedures.arrays import BoolArray, FloatArray
from procedures.diagnosis.sample_blocks import Fitted, SampleBlocks, Scores, fit_scores, scores_of
from procedures.diagnosis.sample_phases import Phase
from procedures.frames import TRIADS
from procedures.statistics.significance import log_chi2_sf, log_f_sf
from procedures.statistics.spectrum import MEDIAN_OF_EXPONENTIAL, MIN_PERIODS

MAX_LOG_P = np.log(1e-3)
MAX_LOG_P_OF_BLOCKS = np.log(1e-4)  # of this frequency alone, by what the blocks say of it
MAX_SPAN = 2**22  # samples from the first to the last
PARTS_OF_A_SAMPLE = 16  # to which recordings must stand on one grid, to be transformed together
PADDING = 2  # times as many frequencies as samples
SPREAD, ABOUT = 1.5, 24.0  # over a recording's length: left out about a line, and the noise about it, either way
PERIODS_OF_A_BLOCK = 3.0  # that a block holds of a line at the least: of a slower one its own line takes much
OVERSAMPLED = 1.5  # by which finer frequencies find more than independent ones


@dataclass(frozen=True, slots=True, eq=False)
class CoherentLine:
    """A line as a phase of time, and what it does to each sensor that it is of, by number."""

    phase: Phase
    hertz: float
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
    tried = np.log(len(groups) * OVERSAMPLED * span / 2)
    found = [
        (*_stands_out(blocks, np.sum([power[i] for i in group], axis=0), len(group)), group) for group in groups
    ]
    log_p, at, group = min(found, key=lambda each: each[0])
    if log_p + tried > MAX_LOG_P:
        return None
    hertz = _refined(blocks, group, at / (2 * (len(power[group[0]]) - 1) * blocks.period), span)
    phase = Phase("time", 1 / hertz, tuple(hertz * channels[0].series.t for channels in blocks.channels))
    scores = scores_of(blocks, lambda number, part: phase.columns(number, part, 1))
    fits = {i: fit for i in group if (fit := fit_scores(scores, i)) is not None and fit.share > 0}
    held = min((fit.log_p for fit in fits.values()), default=0.0)
    if held + np.log(len(group)) > MAX_LOG_P_OF_BLOCKS or not _is_of_one_phase(blocks, scores, list(fits)):
        return None
    return CoherentLine(phase, hertz, {i: replace(fit, log_p=float(log_p + tried)) for i, fit in fits.items()})


def _is_of_one_phase(blocks: SampleBlocks, scores: Scores, sensors: Sequence[int]) -> bool:
    """Say whether recordings by themselves, each with a phase of its own, explain no more than noise would."""
    numbers = np.array([which for which, _ in blocks.blocks])
    for sensor in sensors:
        variance = float(scores.squares[:, sensor].sum()) / blocks.rates[:, :, 0].size
        parts = [numbers == which for which in np.unique(numbers)]
        own = [_explained(scores, sensor, here) for here in parts]
        more = (sum(own) - _explained(scores, sensor, np.ones(len(numbers), dtype=bool))) / variance
        if log_chi2_sf(more, 2 * (len(parts) - 1)) < MAX_LOG_P:
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
    """Return ln p of the frequency that stands out most of ``power`` (m,), and its number."""
    per_hertz = 2 * (len(power) - 1) * blocks.period
    longest = max(len(channels[0].rate) for channels in blocks.channels) * blocks.period
    about, spread = (max(int(per_hertz * size / longest), 2) for size in (ABOUT, SPREAD))
    chunks = np.array_split(power, max(len(power) // (2 * about), 1))
    coarse = np.concatenate([np.full(len(each), np.median(each)) for each in chunks])
    over = power / np.maximum(coarse, np.finfo(float).tiny)
    slowest = max(MIN_PERIODS / longest, PERIODS_OF_A_BLOCK / (blocks.rates.shape[1] * blocks.period))
    over[: int(per_hertz * slowest)] = 0.0  # what is slower was taken off with each block's line
    at = int(np.argmax(over))
    near = np.concatenate((power[max(at - about, 0) : max(at - spread, 0)], power[at + spread : at + about]))
    if not len(near):
        return 0.0, at
    median = MEDIAN_OF_EXPONENTIAL if sensors == 1 else sensors - 1 / 3  # of a gamma distribution
    recorded = sum(len(channels[0].rate) for channels in blocks.channels) * blocks.period
    independent = len(near) / per_hertz * recorded
    ratio = float(power[at] / np.median(near)) * median / sensors
    return log_f_sf(ratio, 2 * sensors, max(sensors * independent, 2.0)), at


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
