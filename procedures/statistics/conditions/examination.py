"""What the samples of a recording at rest are: their conditions, and the samples that the noise is taken from."""

from dataclasses import dataclass, field, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.statistics.conditions.condition import ALL, Condition
from procedures.statistics.conditions.levels import (
    COARSE_STD,
    FINE_STD,
    NoiseOfLevels,
    noise_of_levels,
    short_std,
)
from procedures.statistics.conditions.repeated_values import (
    frozen_rows,
    held_samples,
    interpolated_samples,
    level_step,
)
from procedures.statistics.conditions.row_patterns import (
    MAX_OUTLIER_SHARE,
    BadRows,
    clipped_rows,
    copied_rows,
    interleaved_rows,
    outlying_rows,
    two_ranges,
)
from procedures.statistics.spectrum import MIN_SAMPLES

MIN_CLEAN_SHARE = 0.1  # of the rows, in the longest part without bad ones
LONE_ROWS = 3  # bad in sequence, which are replaced; more are cut
AROUND = 2  # rows cut on either side of bad ones


@dataclass(frozen=True, slots=True, eq=False)
class Examined:
    """Samples ``rate`` (n,) in the unit of the recording, ``period`` [s] apart, and what is wrong with the rows.

    ``rounding`` is the variance that rounding adds, ``white`` the noise of a sample where the levels tell it and
    the Allan deviation does not; both in the unit of the recording, ``step`` one of its steps.
    """

    rate: FloatArray
    period: float
    conditions: tuple[Condition, ...] = ()
    rounding: float = 0.0
    step: float = 0.0
    white: NoiseOfLevels | None = None
    replaced: float = field(default=0.0)

    @property
    def is_usable(self) -> bool:
        """Say whether any term can be determined."""
        return not any(set(each.undetermined) == set(ALL) for each in self.conditions)


def examine(rate: FloatArray, period: float, is_counted: bool) -> Examined:
    """Return what a gap-free record ``rate`` (n,) in any unit, samples ``period`` [s] apart, is.

    ``is_counted``: samples are counts whose remainder is carried on; they are whole for another reason.
    """
    step = level_step(rate)
    if step == 0:
        return Examined(rate, period)
    found = Examined(rate, period, step=step)
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
    for look in (_ranges, _outliers, _copies):
        if is_counted and look is _copies:
            continue
        if len(found.rate) >= MIN_SAMPLES and (bad := look(found)) is not None:
            found = _with(found, bad.condition) if bad.condition.undetermined else _cut(found, bad)
        if not found.is_usable:
            return found
    return found


def _ranges(found: Examined) -> BadRows | None:
    return two_ranges(found.rate, found.step)


def _outliers(found: Examined) -> BadRows | None:
    return outlying_rows(found.rate, found.step)


def _copies(found: Examined) -> BadRows | None:
    return copied_rows(found.rate)


def _cut(found: Examined, bad: BadRows) -> Examined:
    """Replace few lone rows by their neighbours' mean; else take the longest part without bad rows."""
    rate, mask = found.rate, bad.mask
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(np.int8), [0]))))
    runs = edges[1::2] - edges[::2]
    if runs.max() <= LONE_ROWS and mask.mean() <= MAX_OUTLIER_SHARE:
        rows = np.arange(len(rate))
        mended = np.interp(rows, rows[~mask], rate[~mask])
        condition = replace(bad.condition, text=f"{bad.condition.text} They are replaced by their neighbours.")
        return replace(_with(found, condition), rate=mended, replaced=found.replaced + float(mask.mean()))
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
    edges = np.flatnonzero(np.diff(np.concatenate(([0], (~wide).astype(np.int8), [0]))))
    begins, ends = edges[::2], edges[1::2]
    if not len(begins):
        return slice(0, 0)
    k = int(np.argmax(ends - begins))
    return slice(int(begins[k]), int(ends[k]))


def _through_the_quantiser(found: Examined) -> Examined:
    """Tell the noise from the levels where it is below a step; else what rounding adds, and a clipped end."""
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
