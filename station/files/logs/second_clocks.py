"""Two clocks of one file that contradict each other: which of them is right the user says by ``--time``."""

from collections.abc import Iterator, Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.recordings.time_decision import EVIDENCE_RISES, LIE_ODDS
from procedures.recordings.time_unit import TIME_UNITS, TimeUnit
from station.errors import ClocksContradict
from station.files.logs.header_guesses import guessed_time, guessed_utc, time_units_in_name
from station.files.logs.log_table import LogTable

CLOCKS_AGREE = 0.01  # relative: clocks that work agree to 1e-3; the rest is for late read-outs
CLOCK_ROWS = 2**17  # rows that are compared, so that a streamed log is read as a whole one is
JUMPS = 3  # steps in which a clock may be set, or wait for its first fix


def other_clocks(table: LogTable, time: str, names: Sequence[str]) -> list[str]:
    """Return which of the columns ``names`` are clocks beside ``time`` by name, or hold dates."""
    return [
        name for name in names
        if name != time and name not in table.unreadable
        and (name in table.moments or guessed_time([name]) or guessed_utc([name]))
    ]  # fmt: skip


def compare_clocks(
    table: LogTable, time: str, unit: TimeUnit, others: Sequence[str], is_told: bool
) -> Iterator[str]:
    """Yield in words which of the clocks ``others`` contradict ``time``, which the user told.

    Raises
    ------
    ClocksContradict
        If one does, and nobody told which of them is the time.
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
        if not is_told:
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


def seconds_of_clock(table: LogTable, name: str, values: FloatArray) -> float | None:
    """Return the unit [s] of another clock's ``values`` (n,), which its name or its range of dates states."""
    if name in table.moments:
        return 1.0
    if stated := [unit for unit, odds in time_units_in_name(name).items() if odds >= LIE_ODDS]:
        return None if stated[0].digits else stated[0].seconds
    middle = float(np.nanmedian(values)) if np.isfinite(values).any() else 0.0
    dated = [u for u in TIME_UNITS if u.name.startswith("unix") and u.dates and u.dates[0] < middle < u.dates[1]]
    return dated[0].seconds if dated else None
