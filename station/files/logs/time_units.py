"""The unit of a log's time: stated, or decided by all evidence at once (`procedures.counts.time_decision`).

Other clocks of the same rows are evidence too; where one contradicts the time, it is reported.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from shlex import quote

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.time_decision import (
    EVIDENCE_RISES,
    EVIDENCE_ROWS,
    LIE_ODDS,
    OFFERED_HZ,
    POSSIBLE_HZ,
    TimeDecision,
    TimeEvidence,
    decide,
    evidence_rows,
    usual_step,
)
from procedures.counts.time_unit import BY_NAME, SECOND, TIME_UNITS, TimeUnit
from procedures.errors import ErrorCode
from station.errors import ClocksContradict, DataRefused, TimeUnitAsked
from station.files.logs.header_guesses import guessed_time, guessed_utc, time_unit_in_name, time_units_in_name
from station.files.output_units import time_unit
from station.files.tables.table import Table

CLOCKS_AGREE = 0.01  # relative: clocks that work agree to 1e-3; the rest is for late read-outs
CLOCK_ROWS = 2**17  # rows that are compared, so that a streamed log is read as a whole one is
JUMPS = 3  # steps in which a clock may be set, or wait for its first fix


def other_clocks(table: Table, time: str, names: Sequence[str]) -> list[str]:
    """Return which of the columns ``names`` are clocks alongside ``time`` by name, or hold dates."""
    return [
        name for name in names
        if name != time and name not in table.unreadable
        and (name in table.moments or guessed_time([name]) or guessed_utc([name]))
    ]  # fmt: skip


def compare_clocks(
    table: Table, time: str, unit: TimeUnit, others: Sequence[str], is_stated: bool
) -> Iterator[str]:
    """Yield in words which of the clocks ``others`` contradict ``time``, which the user stated.

    Raise `ClocksContradict` if one does, and nobody stated which of them is the time.
    """
    for name in others:
        seconds = seconds_of_clock(table, name, table.columns[name][:CLOCK_ROWS])
        if seconds is None:
            continue
        stamps, other = table.columns[time][:CLOCK_ROWS], table.columns[name][:CLOCK_ROWS]
        both = np.isfinite(stamps) & np.isfinite(other)
        found = disagreement(unit.linear(stamps[both]) * unit.seconds, other[both] * seconds)
        if found is None:
            continue
        rows, own_s, other_s = found
        clocks = [(time, rows / own_s, own_s), (name, rows / other_s, other_s)]
        if not is_stated:
            raise ClocksContradict(table.file, clocks)
        yield (
            f"{name} contradicts the specified {time}: {clocks[0][1]:.5g} Hz by {time}, "
            f"{clocks[1][1]:.5g} Hz by {name}"
        )


def disagreement(a: FloatArray, b: FloatArray) -> tuple[int, float, float] | None:
    """Return over how many rows two clocks differ, and the duration [s] by each; None where they agree.

    The clocks ``a`` (n,) and ``b`` (n,) are in seconds. Both are read where both of them moved on, so that a clock
    of few digits, or one that is written seldom, is compared between its own steps. Clocks that fall, or rise too
    seldom, are not compared.
    """
    if len(a) < 2 or (np.diff(a) < 0).any() or (np.diff(b) < 0).any():
        return None
    coarse = a if (np.diff(a) > 0).sum() < (np.diff(b) > 0).sum() else b
    rows = np.flatnonzero(np.diff(coarse) > 0) + 1
    if len(rows) < EVIDENCE_RISES:
        return None
    step_a, step_b = np.diff(a[rows]), np.diff(b[rows])
    kept = np.sort(np.argsort(np.abs(step_a - step_b), kind="stable")[:-JUMPS])
    own, other, run = float(step_a[kept].sum()), float(step_b[kept].sum()), int(np.diff(rows)[kept].sum())
    if own <= 0 or other <= 0:
        return None
    resolution = max(float(np.median(step_a)), float(np.median(step_b)))
    return (run, own, other) if abs(own - other) > CLOCKS_AGREE * max(own, other) + resolution else None


def seconds_of_clock(table: Table, name: str, values: FloatArray) -> float | None:
    """Return the unit [s] of another clock's ``values`` (n,), which its name or its range of dates states."""
    if name in table.moments:
        return 1.0
    if stated := [unit for unit, odds in time_units_in_name(name).items() if odds >= LIE_ODDS]:
        return None if stated[0].digits else stated[0].seconds
    middle = float(np.nanmedian(values)) if np.isfinite(values).any() else 0.0
    dated = [u for u in TIME_UNITS if u.name.startswith("unix") and u.dates and u.dates[0] < middle < u.dates[1]]
    return dated[0].seconds if dated else None


FEW_DIGITS = 0.1  # share of the rows that have the stamp of the row before, from which it is reported
MOST_OFFERED = 6  # readings in a question


def unit_of_time(
    table: Table,
    time: str | None,
    stated: str | None,
    rate_hz: float | None,
    guesses: list[str],
    stamps_of: Callable[[Sequence[str], bool], FloatArray] | None = None,
    outputs: Sequence[str] = (),
) -> TimeUnit:
    """Return the unit of a log's column ``time``; what nobody stated is added to ``guesses`` as text.

    Rows without a number in the fullest of the columns ``outputs`` do not count. ``table`` may be the first rows
    alone; then ``stamps_of((time, *outputs), whole)`` returns as many stamps (n,) as the decision needs, or these
    and the last one of the log.

    Raises
    ------
    TimeUnitAsked
        If the evidence leaves more than one unit: carries them, with the rate and duration of each.
    DataRefused
        If a unit that was stated makes no possible sample rate.
    """
    if time is None:
        return SECOND
    if time in table.moments:
        guesses.append(f"time in s, of the moments in {time}")
        return SECOND
    names = (time, *outputs)
    if stamps_of is None:
        stamps = stamps_with_outputs([table.column(time), *(table.columns[name] for name in outputs)])
    else:
        stamps = stamps_of(names, False)
    if stated is not None:
        return _stated(table, time, stated, stamps)
    evidence = TimeEvidence(
        stamps, time_units_in_name(time), table.time_scale_s, _second_clock(table, time), rate_hz
    )
    found = decide(evidence)
    if not found.readings:  # nothing rises: what reads the stamps says so
        return SECOND
    if found.winner is None and rate_hz is not None and not evidence.named and evidence.scale_s is None:
        step = usual_step(stamps[: evidence_rows(stamps)])[0]
        unit = time_unit(f"tick:{1 / (rate_hz * step):.10g}")
        guesses.append(f"time in {unit.name}, by --rate: {rate_hz:.5g} Hz")
        return unit
    if found.winner is None:
        if stamps_of is not None:
            found = decide(replace(evidence, stamps=stamps_of(names, True)))
        raise TimeUnitAsked(
            table.file, time, [(r.unit.name, r.rate_hz, r.duration_s) for r in found.readings[:MOST_OFFERED]]
        )
    unit = found.winner.unit
    duration = "" if stamps_of is not None else f", {duration_in_words(found.winner.duration_s)}"
    guesses.append(f"time in {unit.name}, {_reason(evidence, found)}: {found.winner.rate_hz:.5g} Hz{duration}")
    shared = np.diff(stamps[: evidence_rows(stamps)]) == 0
    if shared.mean() > FEW_DIGITS:
        guesses.append(f"{shared.mean():.0%} of the rows share a time stamp in {time}: they are spaced evenly")
    return unit


def contradiction_of_rate(table: Table, time: str | None, unit: TimeUnit, rate_hz: float | None) -> str:
    """Return in words that ``rate_hz`` [Hz], which was stated, and a column of times contradict each other.

    ``unit`` is that of ``time``; without one the column is guessed, and of an unknown unit it contradicts nothing.
    """
    column = time or guessed_time([name for name in table.columns if name not in table.unreadable])
    if column is None or rate_hz is None:
        return ""
    try:
        unit = unit if time else unit_of_time(table, column, None, rate_hz, [])
    except TimeUnitAsked:
        return ""
    stamps = table.column(column)
    stamps = stamps[np.isfinite(stamps)]
    step = usual_step(unit.linear(stamps[: evidence_rows(stamps)]))[0] * unit.seconds
    if step <= 0 or abs(step * rate_hz - 1) <= CLOCKS_AGREE:
        return ""
    used = f"{column} is used (omit --rate)" if time else f"--rate is used (or --time {quote(column)})"
    return f"--rate {rate_hz:g} contradicts {column}, which makes {1 / step:.5g} Hz: {used}"


def are_points(table: Table, time: str) -> bool:
    """Say whether rows by a column ``time`` are farther apart than samples of an inertial sensor."""
    if (name := unit_of_points(table, time)) is None:
        return False
    unit = BY_NAME[name]
    return bool(np.median(np.diff(unit.linear(table.columns[time]))) * unit.seconds * OFFERED_HZ[0] > 1)


def unit_of_points(table: Table, time: str | None) -> str | None:
    """Return the unit that a column's name states, where it rises from row to row; else None.

    Unlike samples, points of a rate table are as far apart as they were measured: that says nothing of a unit.
    """
    if time is None or time in table.unreadable or not np.all(np.diff(table.columns[time]) > 0):
        return None
    unit = SECOND if time in table.moments else time_unit_in_name(time)
    return unit.name if unit is not None and unit.name in BY_NAME else None


def duration_in_words(seconds: float) -> str:
    """Return a duration in the unit in which it is read best, as ``48.3 min``."""
    for name, limit in (("days", 2.0), ("h", 2.0), ("min", 2.0)):
        if seconds >= limit * BY_NAME[name].seconds:
            return f"{seconds / BY_NAME[name].seconds:.3g} {name}"
    return f"{seconds:.3g} s"


def stamps_with_outputs(columns: Sequence[FloatArray]) -> FloatArray:
    """Return the finite stamps (n,), the first of ``columns``, of rows with a number in the fullest of the others.

    A triad may be slower than the other one: its rows are fewer. Where no row is left all stamps are returned.
    """
    stamps, *outputs = columns
    finite = np.isfinite(stamps)
    known = max((finite & np.isfinite(values) for values in outputs), key=np.sum, default=finite)
    return stamps[known if known.any() else finite]


def _stated(table: Table, time: str, stated: str, stamps: FloatArray) -> TimeUnit:
    unit = time_unit(stated)
    step = usual_step(unit.linear(stamps[: evidence_rows(stamps)]))[0] * unit.seconds
    if step > 0 and not POSSIBLE_HZ[0] <= (rate := 1 / step) <= POSSIBLE_HZ[1]:
        raise DataRefused(
            table.file, None, f"--unit-time {stated}, which makes {rate:.4g} Hz of column {time}",
            f"{POSSIBLE_HZ[0]:g} to {POSSIBLE_HZ[1]:g} Hz", "state another unit", ErrorCode.TIME_UNIT,
        )  # fmt: skip
    return unit


def _reason(evidence: TimeEvidence, found: TimeDecision) -> str:
    """Return in words which evidence the winner rests on most."""
    assert found.winner is not None
    unit = found.winner.unit
    if any(odds >= LIE_ODDS for odds in evidence.named.values()):
        return "by its name"
    if evidence.scale_s is not None:
        return f"by the scale in the header ({unit.seconds:g} s)"
    if unit.dates is not None and not unit.digits:
        if unit.name.startswith("unix"):
            moment = datetime.fromtimestamp(float(np.median(evidence.stamps)) * unit.seconds, UTC)
            return f"since 1970, being {moment:%Y-%m-%d}"
        return "being dates from 1990 to 2100"
    if evidence.rate_hz is not None:
        return "by --rate"
    return "by another clock" if evidence.second_clock_s is not None else "by the sample rate"


def _second_clock(table: Table, time: str) -> float | None:
    """Return how long one unit of a column ``time`` is [s] by another clock in the file; None without one."""
    stamps = table.column(time)[:EVIDENCE_ROWS]
    for name in other_clocks(table, time, list(table.columns)):
        other = table.columns[name][:EVIDENCE_ROWS]
        both = np.isfinite(stamps) & np.isfinite(other)
        if (seconds := seconds_of_clock(table, name, other[both])) is None:
            continue
        rise, run = np.diff(other[both]), np.diff(stamps[both])
        if (rise > 0).sum() >= EVIDENCE_RISES and (rise >= 0).all() and (run >= 0).all() and run.sum() > 0:
            return float(rise.sum() / run.sum()) * seconds
    return None
