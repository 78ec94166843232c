"""The unit of a log's time: told, or decided by all evidence at once (`procedures.recordings.time_decision`).

Every command that reads a log asks here, whether it has the whole log or streams it.
"""

from collections.abc import Callable
from datetime import UTC, datetime

import numpy as np

from procedures.arrays import FloatArray
from procedures.error_codes import ErrorCode
from procedures.recordings.time_decision import (
    EVIDENCE_RISES,
    EVIDENCE_ROWS,
    LIE_ODDS,
    POSSIBLE_HZ,
    TimeDecision,
    TimeEvidence,
    decide,
    evidence_rows,
    usual_step,
)
from procedures.recordings.time_unit import BY_NAME, SECOND, TimeUnit
from station.errors import DataRefused, TimeUnitAsked
from station.files.logs.header_guesses import time_units_in_name
from station.files.logs.log_table import LogTable
from station.files.logs.second_clocks import other_clocks, seconds_of_clock
from station.files.output_units import time_unit

FEW_DIGITS = 0.1  # share of the rows that have the stamp of the row before, from which it is said
MOST_OFFERED = 6  # readings in a question


def unit_of_time(
    table: LogTable,
    time: str | None,
    told: str | None,
    rate_hz: float | None,
    guesses: list[str],
    stamps_of: Callable[[str, bool], FloatArray] | None = None,
) -> TimeUnit:
    """Return the unit of a log's column ``time``; what nobody told is added to ``guesses`` in words.

    ``table`` may be the first rows alone; then ``stamps_of(time, whole)`` returns as many stamps as the decision
    needs, or these and the last one of the log.

    Raises
    ------
    TimeUnitAsked
        If the evidence leaves more than one unit: carries them, with the rate and duration of each.
    DataRefused
        If a unit that was told makes no possible sample rate.
    """
    if time is None:
        return SECOND
    if time in table.moments:
        guesses.append(f"time in s, of the moments in {time}")
        return SECOND
    stamps = _finite(table.column(time) if stamps_of is None else stamps_of(time, False))
    if told is not None:
        return _told(table, time, told, stamps)
    evidence = TimeEvidence(
        stamps, time_units_in_name(time), table.time_scale_s, _second_clock(table, time), rate_hz
    )
    found = decide(evidence)
    if not found.readings:  # nothing rises: what reads the stamps says so
        return SECOND
    if found.winner is None:
        if stamps_of is not None:
            found = decide(_with_stamps(evidence, _finite(stamps_of(time, True))))
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


def duration_in_words(seconds: float) -> str:
    """Return a duration in the unit in which it is read best, as ``48.3 min``."""
    for name, limit in (("days", 2.0), ("h", 2.0), ("min", 2.0)):
        if seconds >= limit * BY_NAME[name].seconds:
            return f"{seconds / BY_NAME[name].seconds:.3g} {name}"
    return f"{seconds:.3g} s"


def _finite(stamps: FloatArray) -> FloatArray:
    return stamps[np.isfinite(stamps)]


def _with_stamps(evidence: TimeEvidence, stamps: FloatArray) -> TimeEvidence:
    return TimeEvidence(stamps, evidence.named, evidence.scale_s, evidence.second_clock_s, evidence.rate_hz)


def _told(table: LogTable, time: str, told: str, stamps: FloatArray) -> TimeUnit:
    unit = time_unit(told)
    step = usual_step(unit.linear(stamps[: evidence_rows(stamps)]))[0] * unit.seconds
    if step > 0 and not POSSIBLE_HZ[0] <= (rate := 1 / step) <= POSSIBLE_HZ[1]:
        raise DataRefused(
            table.file, None, f"--unit-time {told}, which makes {rate:.4g} Hz of column {time}",
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


def _second_clock(table: LogTable, time: str) -> float | None:
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
