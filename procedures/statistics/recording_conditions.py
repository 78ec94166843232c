"""Examine a recording at rest: its conditions, repeated values, and the samples from which noise is estimated.

In noise, even through a quantiser, the distribution of the first and second differences of samples is log-concave:
``p_0 <= p_1 (p_1 / p_2)``, of neighbouring bins of equal width. Samples that a logger wrote several times have
more first differences of zero than that, samples on straight lines between two others more second ones. Where the
sensor's samples lie at a regular rate under those of the logger they are taken out and analysed by themselves.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import rfft

from procedures.arrays import BoolArray, FloatArray, IntArray, true_runs
from procedures.statistics.noise_conditions import (
    ALL,
    COARSE_STD,
    FINE_STD,
    MAX_LOG_P,
    Condition,
    NoiseOfLevels,
    noise_of_levels,
    short_std,
)
from procedures.statistics.row_patterns import (
    MAX_OUTLIER_SHARE,
    BadRows,
    clipped_rows,
    copied_rows,
    interleaved_rows,
    outlying_rows,
    two_ranges,
)
from procedures.statistics.spectrum import MIN_SAMPLES

MIN_ZEROS = 10
EXCESS = 2.0  # times as many zeros as log-concavity allows: drift mixes distributions
OUTLIER_SIGMAS = 4.0
BIN_SHARE = 1 / 16  # of the differences that are not zero, in each of the two bins next to zero
MIN_FROZEN = 20  # samples
REGULAR_STD = 0.45  # samples, of a change about its regular place: 0.29 of one that waits for the next row
REGULAR_RUNS = 256  # runs over which a regular rate must hold
MIN_CHANGES, MIN_REGULAR = 30, 0.85  # whose mean phasor is so long: 1 of changes at one phase, 0.2 by chance
MIN_PERIOD_ROWS, MAX_PERIOD_ROWS, MAX_CHANGING = 1.9, 100, 0.6  # looked at; of the rows, that may change
MIN_HOLD = 1.1  # rows of a sensor's sample, below which rows were repeated now and then
HARMLESS_SHARE = 0.01  # of rows repeated now and then: as much of the variance, which is half in N


@dataclass(frozen=True, slots=True, eq=False)
class SensorSamples:
    """The sensor's own samples ``rate`` (m,), in its unit, each ``rows`` of the recording long on average."""

    rate: FloatArray
    rows: float
    condition: Condition


def level_step(rate: FloatArray) -> float:
    """Return the smallest difference of two values of ``rate`` (n,) in its unit; 0 of a constant."""
    levels = np.unique(rate)
    if len(levels) < 2:
        return 0.0
    steps = np.diff(levels)
    tiny = 1e-12 * float(np.abs(levels).max())  # two sums of the same number
    return float(steps[steps > tiny].min()) if (steps > tiny).any() else 0.0


def has_excess_zeros(differences: FloatArray, step: float, halo: int) -> bool:
    """Say whether ``differences`` (n,) are 0 +- ``halo`` units of ``step`` more often than is log-concave."""
    size = np.abs(differences) / step
    zeros = int(np.sum(size <= halo + 0.5))
    other = np.sort(size[size > halo + 0.5]) - halo
    if zeros < MIN_ZEROS or len(other) < MIN_ZEROS:
        return False
    width = max(np.ceil(other[min(int(max(BIN_SHARE * len(other), 30)), len(other) - 1)]), 1.0)
    first, second = (
        int(np.searchsorted(other, (k + 1) * width + 0.5) - np.searchsorted(other, k * width + 0.5))
        for k in (0, 1)
    )
    if not first or not second:
        return not second and not first
    power = (halo + (width + 1) / 2) / width
    rise = power * max(np.log(first / second), 0.0)  # of sines the second bin holds more
    # a converter may miss every other code
    most = float(np.unique(np.round(other), return_counts=True)[1].max()) / 2
    allowed = max(np.log(first / (2 * width)) + rise, np.log(most)) + np.log(2 * halo + 1)
    std = np.sqrt(1 / zeros + (1 + power) ** 2 / first + power**2 / second)
    return bool(np.log(zeros) > allowed + np.log(EXCESS) + OUTLIER_SIGMAS * std)


def held_samples(rate: FloatArray, step: float) -> SensorSamples | None:
    """Return the sensor's samples where the rows of ``rate`` (n,) repeat them, None where none is repeated.

    ``step`` is the `level_step`, in the unit of ``rate``. Without a regular sensor all terms stay undetermined.
    """
    change = np.diff(rate)
    regular = _regular_changes(change)
    if not regular and not has_excess_zeros(change, step, 0):
        return None
    edges = np.concatenate(([0], np.flatnonzero(np.diff(rate)) + 1, [len(rate)]))
    lengths = np.diff(edges)[1:-1]  # the first and the last are cut
    hold = _regular_hold(lengths, regular or float(lengths.mean())) if len(lengths) >= 4 else None
    if hold is None:
        share = 1 - (len(edges) - 1) / len(rate)
        text = f"{100 * share:.3g} % of the rows repeat the row before, at irregular places."
        if share > HARMLESS_SHARE:
            text += " The rate of the sensor is not known."
        lost = ALL if share > HARMLESS_SHARE else ()
        return SensorSamples(rate, 1.0, Condition("repeated_rows", text, lost, {"share": share}))
    counts = np.maximum(np.round(lengths / hold), 1).astype(np.int64)
    values = np.repeat(rate[edges[1:-2]], counts)
    text = (
        f"Each sample is held for {hold:.4g} rows on average: the logger is faster than the sensor. "
        "The analysis uses one row of each sample."
    )
    return SensorSamples(values, hold, Condition("held_samples", text, (), {"rows": hold}))


def _regular_changes(change: FloatArray) -> float:
    """Return the period [rows] at which alone ``change`` (n,) is not zero, up and down; 0 where there is none."""
    at = change != 0
    if not MIN_CHANGES <= at.sum() < MAX_CHANGING * len(at) or not (change > 0).any() or not (change < 0).any():
        return 0.0
    size = np.abs(rfft(at.astype(np.float64))) / at.sum()
    first, last = len(change) // MAX_PERIOD_ROWS + 1, int(len(change) / MIN_PERIOD_ROWS)
    peaks = np.flatnonzero(size[first : last + 1] > MIN_REGULAR) + first
    return len(change) / float(peaks[0]) if len(peaks) else 0.0


def _regular_hold(lengths: IntArray, hold: float) -> float | None:
    """Return how many rows, about ``hold``, a sample is held; None where the runs (k,) [rows] are irregular."""
    for _ in range(4):  # a run may hold several samples alike
        counts = np.maximum(np.round(lengths / hold), 1)
        hold = float(lengths.sum() / counts.sum())
    late = np.cumsum(lengths) - hold * np.cumsum(counts)
    blocks = max(len(late) // REGULAR_RUNS, 1)
    off = np.concatenate([part - part.mean() for part in np.array_split(late, blocks)])
    return hold if hold >= MIN_HOLD and off.std() < REGULAR_STD else None


def interpolated_samples(rate: FloatArray, step: float) -> SensorSamples | None:
    """Return the samples between which rows of ``rate`` (n,) lie on straight lines, None where they do not.

    Without a whole number of rows between samples these are not among the rows, and all terms undetermined.
    """
    second = np.diff(rate, 2)
    scale = float(np.abs(rate).max())
    step = max(step, 1e-11 * scale)
    if not has_excess_zeros(second, step, 2):
        return None
    knots = np.flatnonzero(np.abs(second) > 2.5 * step) + 1
    rows = np.diff(knots)
    apart = float(np.median(rows))
    if apart >= 2 and np.mean(rows % apart == 0) > 1 - HARMLESS_SHARE:
        text = (
            f"Rows lie on straight lines between every {apart:.0f}th one: the recording was interpolated. "
            "The analysis uses the samples in between which it was."
        )
        own = rate[int(np.bincount(knots % int(apart)).argmax()) :: int(apart)]
        return SensorSamples(own, apart, Condition("interpolated", text, (), {"rows": apart}))
    share = 1 - len(knots) / len(second)
    text = (
        f"{100 * share:.3g} % of the rows lie on a straight line between their neighbours: the recording was "
        "interpolated from samples at another rate."
    )
    return SensorSamples(rate, 1.0, Condition("interpolated", text, ALL, {"share": share}))


def frozen_rows(rate: FloatArray) -> BoolArray:
    """Mark rows of ``rate`` (n,), any unit, within runs of one value that are too long for its repeats."""
    edges = np.concatenate(([0], np.flatnonzero(np.diff(rate)) + 1, [len(rate)]))
    lengths = np.diff(edges)
    usual = lengths[lengths <= max(float(np.quantile(lengths, 0.99)), 1.0)]
    repeats = max(1 - 1 / float(np.median(lengths)), 1 - len(usual) / float(usual.sum()), 1e-3)
    longest = max(MIN_FROZEN, (MAX_LOG_P - np.log(len(rate))) / np.log(repeats))
    return np.repeat(lengths > longest, lengths)


MIN_CLEAN_SHARE = 0.1  # of the rows, in the longest part without bad ones
LONE_ROWS = 3  # bad in sequence, which are replaced; more are cut
AROUND = 2  # rows cut on either side of bad ones


@dataclass(frozen=True, slots=True, eq=False)
class Examined:
    """Samples ``rate`` (n,) in the unit of the recording, ``period`` [s] apart, and what is wrong with the rows.

    ``rounding`` is the variance that rounding adds, ``white`` the noise of a sample where the levels determine it
    and the Allan deviation does not; both in the unit of the recording, ``step`` one of its steps. ``replaced`` is
    the share of the rows that have their neighbours' mean, ``missing`` of those over which the others close up.
    """

    rate: FloatArray
    period: float
    conditions: tuple[Condition, ...] = ()
    rounding: float = 0.0
    step: float = 0.0
    white: NoiseOfLevels | None = None
    replaced: float = 0.0
    missing: float = 0.0

    @property
    def is_usable(self) -> bool:
        """Say whether any term can be determined."""
        return not any(set(each.undetermined) == set(ALL) for each in self.conditions)


@dataclass(frozen=True, slots=True)
class MeasuredRows:
    """Which rows of a recording were measured: each ``every``-th one, but for a share ``missing`` of them."""

    every: int = 1
    missing: float = 0.0
    condition: Condition | None = None


def measured_rows(measured: BoolArray) -> MeasuredRows:
    """Return what the rows (n,) (numbers) that were ``measured``, not interpolated, are."""
    count, rows = int(measured.sum()), len(measured)
    if count == rows or count < 2:
        return MeasuredRows()
    every = int(np.median(np.diff(np.flatnonzero(measured))))
    missing = max(1 - every * count / rows, 0.0)
    text = f"{rows - count} of {rows} rows were not measured: the analysis uses the others."
    if every > 1:
        text = f"Each sample is {every} rows long: the analysis uses one row of each sample."
    values = {"rows": float(rows - count), "every": float(every)}
    return MeasuredRows(every, missing, Condition("interpolated_rows", text, (), values))


def on_the_grid(rate: FloatArray, measured: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Return samples (n,), any unit, those not ``measured`` on straight lines, and the mask.

    ``rate`` (m,), in the same unit, holds the others. Where some of them were cut since, it is returned as it is.
    """
    if len(rate) != int(measured.sum()):
        return rate, np.ones(len(rate), dtype=np.bool_)
    return np.interp(np.arange(len(measured)), np.flatnonzero(measured), rate), measured


def examine(rate: FloatArray, period: float, is_counted: bool, own: MeasuredRows = MeasuredRows()) -> Examined:
    """Return what a gap-free record ``rate`` (n,) in any unit, samples ``period`` [s] apart, is.

    ``is_counted``: samples are counts whose remainder is carried on; they are whole for another reason. ``own``:
    which rows of the recording ``rate`` holds.
    """
    step = level_step(rate)
    if step == 0:
        return Examined(rate, period)
    found = _with(Examined(rate, period, step=step, missing=own.missing), own.condition)
    if not is_counted:
        found = _at_the_sensors_rate(found)
    found = _without_bad_rows(found, is_counted) if found.is_usable else found
    if is_counted or not found.is_usable:
        return found
    return _through_the_quantiser(found)


def _with(found: Examined, *conditions: Condition | None) -> Examined:
    named = tuple(each for each in conditions if each is not None)
    return replace(found, conditions=(*found.conditions, *named))


def _is_coarse(found: Examined) -> bool:
    return short_std(found.rate, found.step) < COARSE_STD


def _at_the_sensors_rate(found: Examined) -> Examined:
    """Cut frozen rows, then take the sensor's samples out of rows that repeat or interpolate them."""
    if not _is_coarse(found) and (frozen := frozen_rows(found.rate)).any():
        begin = int(np.argmax(frozen))
        text = (
            f"{int(frozen.sum())} rows are constant, the first of them row {begin + 1}, at "
            f"{found.rate[begin]:.6g}."
        )
        values = {"rows": float(frozen.sum()), "first": float(begin), "value": float(found.rate[begin])}
        found = _cut(found, BadRows(frozen, Condition("frozen_rows", text, (), values)))
    for look in (held_samples, interpolated_samples):
        if not found.is_usable:
            break
        if (own := look(found.rate, found.step)) is not None:
            period, condition = found.period * own.rows, own.condition
            if own.rows > 1:
                text = f"{condition.text} The sensor's own rate is {1 / period:.5g} Hz."
                values = {**condition.values, "sensor_hz": 1 / period}
                condition = replace(condition, text=text, values=values)
            found = replace(_with(found, condition), rate=own.rate, period=period)
    return found


def _without_bad_rows(found: Examined, is_counted: bool) -> Examined:
    """Cut or replace rows that are not the sensor's noise; leave all undetermined where little is left."""
    if not is_counted and not _is_coarse(found) and (mixed := interleaved_rows(found.rate)) is not None:
        return _with(found, mixed)
    looks: list[Callable[[Examined], BadRows | None]] = [
        lambda seen: two_ranges(seen.rate, seen.step),
        lambda seen: outlying_rows(seen.rate, seen.step),
    ]
    if not is_counted:
        looks.append(lambda seen: copied_rows(seen.rate))
    for look in looks:
        if len(found.rate) >= MIN_SAMPLES and (bad := look(found)) is not None:
            found = _with(found, bad.condition) if bad.condition.undetermined else _cut(found, bad)
        if not found.is_usable:
            break
    return found


def _cut(found: Examined, bad: BadRows) -> Examined:
    """Replace few lone rows by their neighbours' mean; else take the longest part without bad rows."""
    rate, mask = found.rate, bad.mask
    if np.ptp(true_runs(mask), axis=1).max() <= LONE_ROWS and mask.mean() <= MAX_OUTLIER_SHARE:
        rows = np.arange(len(rate))
        filled = np.interp(rows, rows[~mask], rate[~mask])
        condition = replace(bad.condition, text=f"{bad.condition.text} They are replaced by their neighbours.")
        return replace(_with(found, condition), rate=filled, replaced=found.replaced + float(mask.mean()))
    part = _longest_clean(mask)
    kept = part.stop - part.start
    if kept < max(MIN_SAMPLES, MIN_CLEAN_SHARE * len(rate)):
        text = f"{bad.condition.text} No part without them is long enough."
        return _with(found, replace(bad.condition, text=text, undetermined=ALL))
    text = f"{bad.condition.text} The noise is that of rows {part.start + 1} to {part.stop}."
    return replace(_with(found, replace(bad.condition, text=text)), rate=rate[part])


def _longest_clean(mask: BoolArray) -> slice:
    """Return the longest part of rows (n,) that ``mask`` leaves, a few rows away from bad ones."""
    wide = np.convolve(mask, np.ones(2 * AROUND + 1), mode="same") > 0
    runs = true_runs(~wide)
    return slice(*runs[np.argmax(np.ptp(runs, axis=1))].tolist()) if len(runs) else slice(0, 0)


def _through_the_quantiser(found: Examined) -> Examined:
    """Determine the noise from the levels where it is below a step; else what rounding adds, and a clipped end."""
    std = short_std(found.rate, found.step) if np.ptp(found.rate) > 0 else 0.0
    if std >= COARSE_STD:
        rounding = found.step**2 / 12 if std < FINE_STD else 0.0
        return replace(_with(found, clipped_rows(found.rate, found.step)), rounding=rounding)
    white = noise_of_levels(found.rate, found.step)
    text = f"The noise is below one step of the output ({found.step:.4g}), which shows {white.levels} levels: "
    if white.value is not None:
        text += "the random walk is from the shares of the levels, the other terms are hidden."
    elif np.isfinite(white.high):
        text += "the steps hide the noise, and only a bound of the random walk is known."
    else:
        text += "the steps hide the noise, and rows are not independent: no term is known."
    values = {"step": found.step, "levels": float(white.levels)}
    hidden = tuple(name for name in ALL if name != "random_walk") if np.isfinite(white.high) else ALL
    return replace(_with(found, Condition("coarse_levels", text, hidden, values)), white=white)
