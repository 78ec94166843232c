"""One sample period for all files of a campaign whose stamps are no times of samples.

A device has one clock: what each file's stamps say of its period is averaged, and what is left open is common to
all rates: it does not average out over dwells.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.counts.sample_records import Series
from station.files.campaign_folder.loaded_campaign import LoadedStep
from station.files.campaign_folder.sample_series import WARN_PERIOD_DEVIATION, StepData

MIN_DIFFERENCE_SIGMAS = 4.0  # by which a file's period must differ


@dataclass(frozen=True, slots=True)
class CommonPeriod:
    """The sample period and its 1 sigma [s], from the stamps of so many files."""

    value: float
    std: float
    files: int


def with_one_period(steps: Sequence[LoadedStep]) -> tuple[list[LoadedStep], CommonPeriod | None]:
    """Return the steps, those of uneven stamps on a grid of their common period; None where none is uneven."""
    data = [step.data for step in steps if step.data is not None and step.data.times.is_uneven]
    if not data:
        return list(steps), None
    middle = float(np.median([each.times.period for each in data]))
    alike = [each for each in data if _is_near(each, middle)] or data
    value = np.array([each.times.period for each in alike])
    weight = np.array([each.times.period_std for each in alike]) ** -2.0
    mean = float(weight @ value / weight.sum())
    spread = float(weight @ (value - mean) ** 2) / max(len(value) - 1, 1)  # more than their sigmas: widens it
    period = CommonPeriod(mean, float(np.sqrt(max(spread, 1.0) / weight.sum())), len(alike))
    return [_at(step, mean) if step.data in alike else step for step in steps], period


def _is_near(data: StepData, period: float) -> bool:
    """Say whether a file may be of this period: of one that is quite another its own warning or refusal tells."""
    off = abs(data.times.period - period)
    return off <= max(WARN_PERIOD_DEVIATION * period, MIN_DIFFERENCE_SIGMAS * data.times.period_std)


def said_of_period(period: CommonPeriod | None) -> list[str]:
    """Say which period was taken and how well it is known."""
    if period is None:
        return []
    return [
        f"sample period of the {period.files} file(s) with uneven t_s: {period.value:.9g} s "
        f"+- {1e6 * period.std / period.value:.2g} ppm (1 sigma), common to all of them; the sigmas hold it"
    ]


def _at(step: LoadedStep, period: float) -> LoadedStep:
    assert step.data is not None
    return replace(step, data=replace(step.data, series=_paced(step.data.series, period)))


def _paced(series: Series, period: float) -> Series:
    middle = (series.t[0] + series.t[-1]) / 2
    return replace(series, t=middle + (series.t - middle) * (period / series.period), period=period)
