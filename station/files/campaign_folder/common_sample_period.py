"""One sample period for all files of a campaign whose stamps are no times of samples.

A device has one clock: what each file's stamps say of its period is averaged, and what is left open is common to
all rates: it does not average out over dwells.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from procedures.counts.sample_times import NEAR_PERIOD_TOLERANCE
from station.files.campaign_folder.loaded_campaign import LoadedStep
from station.files.campaign_folder.sample_series import WARN_PERIOD_DEVIATION, StepData

MIN_DIFFERENCE_SIGMAS = 4.0  # by which a file's period must differ


def with_one_period(steps: Sequence[LoadedStep]) -> tuple[list[LoadedStep], float, list[str]]:
    """Return the steps, those of uneven stamps on a grid of their common period.

    Beside them its 1 sigma, relative, and words for both; 0 and none where no stamps are uneven.
    """
    data = [step.data for step in steps if step.data is not None and step.data.times.is_uneven]
    if not data:
        return list(steps), 0.0, []
    periods = sorted(each.times.period for each in data)
    middle = float(np.median(periods))
    if periods[-1] > periods[0] * (1 + NEAR_PERIOD_TOLERANCE):  # logs of several rates: between two is none
        middle = periods[len(periods) // 2]
    alike = [each for each in data if _is_near(each, middle)] or data
    value = np.array([each.times.period for each in alike])
    weight = np.array([each.times.period_std for each in alike]) ** -2.0
    mean = float(weight @ value / weight.sum())
    spread = float(weight @ (value - mean) ** 2) / max(len(value) - 1, 1)  # more than their sigmas: widens it
    std = float(np.sqrt(max(spread, 1.0) / weight.sum()))
    said = (
        f"sample period of the {len(alike)} file(s) with uneven t_s: {mean:.9g} s "
        f"+- {1e6 * std / mean:.2g} ppm (u), common to all of them; the uncertainties include it"
    )
    return [_at(step, mean) if step.data in alike else step for step in steps], std / mean, [said]


def _is_near(data: StepData, period: float) -> bool:
    """Say whether a file may be of this period: of one that is quite another its own warning or refusal tells."""
    off = abs(data.times.period - period)
    return off <= max(WARN_PERIOD_DEVIATION * period, MIN_DIFFERENCE_SIGMAS * data.times.period_std)


def _at(step: LoadedStep, period: float) -> LoadedStep:
    assert step.data is not None
    series = step.data.series
    middle = (series.t[0] + series.t[-1]) / 2
    paced = replace(series, t=middle + (series.t - middle) * (period / series.period), period=period)
    return replace(step, data=replace(step.data, series=paced))
