"""What the steps of a campaign must agree on: ends of transfers, no overlap in time, one sample period.

A move's rows begin where one step ends and end where the next begins. ``t_s`` says when each step happened. Files
whose stamps are no times of samples have one sample period in common.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from procedures.counts.sample_times import NEAR_PERIOD_TOLERANCE
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, DwellTable, MoveTable, TurnTable
from station.files.campaign_folder.loaded_campaign import LoadedStep
from station.files.campaign_folder.sample_series import WARN_PERIOD_DEVIATION, StepData
from station.files.toml_file import Key, line_of
from station.text import plural

MOST_NAMED = 3  # steps in a refusal
MEETING_PERIODS = 0.5  # of a sample, by which a move's rows may begin early or late


def refuse_loose_moves(folder: Path, steps: Sequence[LoadedStep], lines: dict[Key, int] | None = None) -> None:
    """Refuse moves from or to what is no dwell or turn of the folder, and those that do not meet these.

    ``lines`` has the line of each key of ``campaign.toml``, where there is one.
    Between a step's last row and a move's first the cube may have been turned, and nobody would know.
    """
    rests = {step.table.file: step for step in steps if isinstance(step.table, DwellTable | TurnTable)}
    moves = [step for step in steps if isinstance(step.table, MoveTable)]
    for i, step in enumerate(moves):
        assert isinstance(step.table, MoveTable)
        if step.data is None:
            continue
        for key, name in (("from", step.table.before), ("to", step.table.after)):
            if name not in rests:
                line = line_of(("move", i, key), lines) if lines else None
                raise DataRefused(
                    folder / CAMPAIGN_TOML, line, f"[[move]] {step.table.file}: {key} = {ascii(name)[:80]}",
                    "the file of a [[dwell]] or [[turn]] of this folder",
                    f"name the step that it joins, one of {_some(rests)}, or remove the transfer",
                )  # fmt: skip
        period, (first, last) = step.data.series.period, step.data.span
        begin, end = rests[step.table.before].data, rests[step.table.after].data
        assert begin is not None
        assert end is not None
        gaps = (first - begin.span[1] - period, end.span[0] - last - period)
        worst = max(gaps, key=abs)
        if abs(worst) > MEETING_PERIODS * period:
            raise DataRefused(
                folder / step.table.file, None, f"rows {worst:+.4g} s off where its steps end and begin",
                f"the first {period:.4g} s after {step.table.before}, the last as long before {step.table.after}",
                "cut the rows there, or remove the transfer",
            )  # fmt: skip


def _some(names: Iterable[str]) -> str:
    """Return the first few names."""
    first = list(names)
    return ", ".join([*first[:MOST_NAMED], *(["..."] if len(first) > MOST_NAMED else [])])


def refuse_overlap(folder: Path, steps: Sequence[LoadedStep]) -> list[str]:
    """Refuse steps that overlap in ``t_s``; return one remark if only the device's clock was reset between them.

    A recording that carries the station's own time proves by it that two steps were apart although the
    device's time, which a loss of power resets, says otherwise; so does a step of another ``turn_on``.
    """
    reset = list[LoadedStep]()  # since the step before, in order of the device's time
    timed = [(getattr(step.table, "turn_on", None) or 1, step.data.span, step) for step in steps if step.data]
    timed.sort(key=lambda item: item[:2])
    for (on, span, first), (next_on, next_span, second) in pairwise(timed):
        if on != next_on or next_span[0] > span[1]:
            continue
        if not _apart_by_host(first, second):
            raise DataRefused(
                folder / second.table.file,
                None,
                f"t_s {next_span[0]:.9g} to {next_span[1]:.9g}",
                f"no overlap with {first.table.file} ({span[0]:.9g} to {span[1]:.9g})",
                "correct t_s or leave one of the two steps out",
            )
        reset.append(second)
    if not reset:
        return []
    files = ", ".join(each.table.file for each in reset)
    return [f"the device's clock was reset during the campaign: {plural(len(reset), 'step')} affected ({files})"]


def _apart_by_host(first: LoadedStep, second: LoadedStep) -> bool:
    spans = [step.data.host_span for step in (first, second) if step.data and step.data.host_span]
    return len(spans) == 2 and (spans[0][1] < spans[1][0] or spans[1][1] < spans[0][0])


MIN_DIFFERENCE_SIGMAS = 4.0  # by which a file's period must differ


def with_one_period(steps: Sequence[LoadedStep]) -> tuple[list[LoadedStep], float, list[str]]:
    """Return the steps, those of uneven stamps on a grid of their common period.

    Next to them its 1 sigma, relative, and words for both; 0 and none where no stamps are uneven.
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
    text = (
        f"sample period of the {len(alike)} file(s) with uneven t_s: {mean:.9g} s "
        f"+- {1e6 * std / mean:.2g} ppm (u), common to all of them; the uncertainties include it"
    )
    return [_at(step, mean) if step.data in alike else step for step in steps], std / mean, [text]


def _is_near(data: StepData, period: float) -> bool:
    """Return whether a file may be of this period; a quite different one has its own warning or refusal."""
    off = abs(data.times.period - period)
    return off <= max(WARN_PERIOD_DEVIATION * period, MIN_DIFFERENCE_SIGMAS * data.times.period_std)


def _at(step: LoadedStep, period: float) -> LoadedStep:
    assert step.data is not None
    series = step.data.series
    middle = (series.t[0] + series.t[-1]) / 2
    paced = replace(series, t=middle + (series.t - middle) * (period / series.period), period=period)
    return replace(step, data=replace(step.data, series=paced))
