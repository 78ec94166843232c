"""A log's columns as those of a step's file: times, outputs, temperature, auxiliary channels; rate tables."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray, finite_rows
from procedures.counts.encoder_angle import (
    LEAST_ROWS,
    SURE,
    lateness,
    mean_rates,
    slope_and_correlation,
    unwrapped,
)
from procedures.counts.missing_rows import (
    INTERPOLATED,
    MAX_BRIDGED,
    TRIAD_BITS,
    bridged,
    rows_lost,
    rows_of_slower,
)
from procedures.counts.sample_times import SAME_WRAP_STEPS, StampsGoBack, log_times
from procedures.counts.sentinels import sentinel_cells
from procedures.errors import ErrorCode
from procedures.units import S_PER_H
from station.errors import DataRefused
from station.files.logs.log_columns import LogColumns, outputs
from station.files.logs.time_units import contradiction_of_rate
from station.files.output_units import GYRO_UNITS, outputs_per_unit
from station.files.tables.strict_csv import RATE_TABLE_COLUMNS, TRIADS
from station.files.tables.table import Table

MAX_OFF = 0.02  # of 1, by which a stated unit and the angle may differ before a note says so
STEADY = 0.1  # of the mean rate: one that spans less is held against the whole angle, a line has no slope there


def angle_at_ends(found: LogColumns) -> tuple[float, bool] | None:
    """Return by how much an angle grew [deg] that was read at both ends of a log alone; None of any other log.

    With it, whether the readings may begin again at each turn.
    """
    if found.reference is None or found.degrees_per_angle is None:
        return None
    angle = found.table.column(found.reference) * found.degrees_per_angle
    read = np.flatnonzero(np.isfinite(angle))
    if len(read) < 2 or read[0] >= len(angle) / 4 or read[-1] < len(angle) * 3 / 4:
        return None
    gap = int(np.argmax(np.diff(read)))
    if read[gap + 1] - read[gap] < len(angle) / 2:
        return None
    first, last = (float(np.median(angle[part])) for part in (read[: gap + 1], read[gap + 1 :]))
    return last - first, bool(min(first, last) >= 0 and max(first, last) <= 360)


def rates_of_angle(
    found: LogColumns, columns: Mapping[str, FloatArray], angle: FloatArray, notes: list[str]
) -> dict[str, FloatArray]:
    """Return a rate table's columns, a row a block, of a log with an ``angle`` (n,) [deg] alongside it.

    Raise `DataRefused` if there are too few rows, or the angle does not move.
    """
    if len(angle) < LEAST_ROWS or not np.ptp(angle):
        what = f"{len(angle)} rows" if np.ptp(angle) else f"{found.reference} that never changes"
        raise DataRefused(found.table.file, None, what, f"at least {LEAST_ROWS} rows of an angle that turns")
    t, angle = columns["t_s"], unwrapped(angle)
    names = [name for name in RATE_TABLE_COLUMNS[2:] if name in columns]
    values = np.stack([columns[name] for name in names], axis=1)
    gyro = [i for i, name in enumerate(names) if name in TRIADS["gyro"]]
    turned = mean_rates(t, angle, values)
    correlations = [slope_and_correlation(turned.reference, turned.values[:, i])[1] for i in gyro]
    own = gyro[int(np.argmax(np.abs(correlations)))] if gyro else 0
    late, std = lateness(t, angle, values[:, own])
    if abs(late) > SURE * std:
        word = "late" if late > 0 else "early"
        notes.append(f"{found.reference} is {1e3 * abs(late):.1f} +- {1e3 * std:.2g} ms {word}: corrected")
        turned = mean_rates(t, angle, values, late)
    _say_scale(found, turned.reference, turned.values[:, own], notes)
    notes.append(
        f"{found.reference} turned by {angle[-1] - angle[0]:.6g} deg: {len(turned.t)} points of a rate table"
    )
    return {"rate_ref_deg_s": turned.reference, "t_s": turned.t, **dict(zip(names, turned.values.T, strict=True))}


def _say_scale(found: LogColumns, reference: FloatArray, output: FloatArray, notes: list[str]) -> None:
    """Say where the angle and the stated unit do not agree: the scale factor, or the time, is another."""
    stated = outputs_per_unit(found.unit_gyro or "raw", GYRO_UNITS)
    if stated is None:
        return
    is_steady = np.ptp(reference) < STEADY * abs(np.mean(reference))
    slope = reference @ output / (reference @ reference) if is_steady else np.polyfit(reference, output, 1)[0]
    times = abs(float(slope) / stated)
    if abs(times - 1) > MAX_OFF:
        more = f"the outputs turn {times:.4g} times as far as {found.reference}"
        why = "their unit is another, their bias is large," if is_steady else "their unit is another,"
        notes.append(f"{more}: {why} or the log's second is (--unit-time, --rate; --utc checks it)")


MIN_ROWS = 16
LARGEST = 1e30  # that any output is, in whatever unit


def log_data(found: LogColumns, rate_hz: float | None, name: str) -> tuple[Table, float | None, list[str]]:
    """Return a log as the columns of a step's file called ``name``, and what had to be done, as text.

    Between them is the time [s] at which ``t_s`` is 0 by the log's own clock, None where that is not known.

    Rows whose outputs or time are empty or no number are lost samples: a few in sequence are interpolated and
    marked. A channel that never changes is no channel. Raise `DataRefused` if time goes back, a cell of a column
    that is used is no number, fewer than `MIN_ROWS` rows are left, or many rows hold one triad alone.
    """
    table, notes = found.table, list(found.table.notes)
    found = _without_empty(found, notes)
    triads = {"gyro": outputs(found, found.gyro), "accel": outputs(found, found.accel)}
    _refuse_beyond_numbers(found)
    if text := contradiction_of_rate(table, found.time, found.unit_time, rate_hz):
        notes.append(text)
    if found.reference is None:
        triads = _without_sentinels(found, triads, notes)
    stamps = None if found.time is None else found.unit_time.linear(table.column(found.time))
    reference = None if found.reference is None else table.column(found.reference) / found.reference_unit
    there = {triad: finite_rows(values) for triad, values in triads.items() if values is not None}
    in_use = there if reference is not None else _at_own_rates(found, there, notes)
    keep = np.ones(table.rows, dtype=np.bool_)
    for usable in (*in_use.values(), *(np.isfinite(one) for one in (stamps, reference) if one is not None)):
        keep &= usable
    lost = ~keep
    lost[list(table.damaged)] = False  # the reader reported so
    empty = ""
    if lost.any():
        empty = f"{int(lost.sum())} rows without a number in time or outputs, first in {_place(found, lost)}"
    if stamps is not None and (again := _repeated(stamps, list(triads.values())) & keep).any():
        notes.append(f"{int(again.sum())} rows that repeat the one before: not used")
        keep &= ~again
    if keep.sum() < MIN_ROWS:
        few = f"{int(keep.sum())} rows with a number in all of time and outputs"
        remedy = "name fewer columns, or correct the file"
        raise DataRefused(table.file, None, few, f"at least {MIN_ROWS}", remedy, code=ErrorCode.TOO_SHORT)
    columns, origin = _times(found, stamps, keep, rate_hz, notes)
    for triad, names in TRIADS.items():
        if (values := triads[triad]) is not None:
            columns |= {each: np.ascontiguousarray(values[keep, i]) for i, each in enumerate(names)}
            _say_constant(values[keep], getattr(found, triad), notes)
    columns |= _auxiliary_columns(found, keep, notes)
    if found.utc is not None:
        columns["utc_s"] = found.unit_utc.linear(table.column(found.utc)[keep]) * found.unit_utc.seconds
    lines = table.lines if keep.all() else [table.line(row) for row in np.flatnonzero(keep).tolist()]
    if reference is not None and found.degrees_per_angle is not None:
        columns, lines = rates_of_angle(found, columns, reference[keep] * found.degrees_per_angle, notes), None
    elif reference is not None:
        columns = {"rate_ref_deg_s": reference[keep], **columns}
        columns = {each: values for each, values in columns.items() if each in RATE_TABLE_COLUMNS}
    read = Table(Path(name), columns, table.sha256, lines)
    if reference is None:
        read, text = _bridged(read, {triad: known[keep] for triad, known in there.items()})
        notes += [f"{empty}; {text}" if empty and text else text or f"{empty}: not used"] if empty or text else []
    elif empty:
        notes.append(f"{empty}: not used")
    return read, origin, [f"{table.file.name}: {note}" for note in notes]


KINDS = {"gyro": "gyroscope", "accel": "accelerometer"}


def _without_sentinels(
    found: LogColumns, triads: Mapping[str, FloatArray | None], notes: list[str]
) -> dict[str, FloatArray | None]:
    """Return the outputs, nan where they hold a number that stands for no sample."""
    there = [triad for triad, values in triads.items() if values is not None]
    values = np.hstack([part for triad in there if (part := triads[triad]) is not None])
    marked = sentinel_cells(values)
    if not marked.any():
        return dict(triads)
    names = [name for triad in there for name in getattr(found, triad)]
    shown = ", ".join(dict.fromkeys(f"{number:g}" for number in values[marked].tolist()))
    of = ", ".join(str(names[i]) for i in np.flatnonzero(marked.any(axis=0)).tolist())
    rows: BoolArray = np.logical_or.reduce(marked, axis=1)
    notes.append(
        f"{shown} in {int(rows.sum())} rows of {of}, a number that stands for no sample, first in "
        f"{_place(found, rows)}: missing samples"
    )
    values = np.where(marked, np.nan, values)
    return {**triads, **{triad: values[:, 3 * i : 3 * i + 3] for i, triad in enumerate(there)}}


def _at_own_rates(found: LogColumns, there: Mapping[str, BoolArray], notes: list[str]) -> Mapping[str, BoolArray]:
    """Return the rows (n,) in which each triad is known: of one in every k-th row of the other also in between.

    Raise `DataRefused` if many rows hold one triad alone, in no such order.
    """
    if len(there) < 2 or (there["gyro"] == there["accel"]).all():
        return there
    slow, fast = sorted(there, key=lambda triad: int(there[triad].sum()))
    common = np.flatnonzero(there[fast])
    if (known := rows_of_slower(there[slow][common])) is not None:
        every = int(np.median(np.diff(np.flatnonzero(there[slow][common]))))
        notes.append(
            f"{KINDS[slow]}s stand in one of {every} rows of the {KINDS[fast]}s: on straight lines in between"
        )
        rows = np.zeros(len(there[slow]), dtype=np.bool_)
        rows[common[known]] = True
        return {fast: there[fast], slow: rows}
    share = float(np.mean(there[fast] != there[slow]))
    if share > MAX_BRIDGED:
        what = f"{share:.0%} of the rows with {KINDS[fast]}s or {KINDS[slow]}s alone"
        remedy = f"state --{slow} -,-,- to use the {KINDS[fast]}s alone, or --{fast} -,-,- for the {KINDS[slow]}s"
        expected = "both in each row, or the slower ones in every k-th"
        raise DataRefused(found.table.file, None, what, expected, remedy, ErrorCode.COLUMNS)
    return there


def _bridged(read: Table, there: Mapping[str, BoolArray]) -> tuple[Table, str]:
    """Return a log with short gaps of time, and the slower triad between its samples, on straight lines; as text.

    The column `INTERPOLATED` marks these values. ``there`` (n,) is where each triad was measured.
    """
    t, text = read.columns.get("t_s"), ""
    if t is None:
        return read, text
    lost, rows = rows_lost(t), len(t)
    share = lost.sum() / (rows + lost.sum())
    if share > MAX_BRIDGED:
        lost, text = np.zeros_like(lost), f"{share:.0%} of the samples are missing: each gap ends a recording"
    elif share:
        text = (
            f"{int(lost.sum())} samples missing in short gaps ({share:.2%}) are on straight lines, without noise"
        )
    if not lost.any() and all(known.all() for known in there.values()):
        return read, text
    own = np.arange(rows) + np.cumsum(lost)  # where the rows that were read stand
    every = np.arange(int(own[-1]) + 1)
    source = np.searchsorted(own, every)
    is_own = own[source] == every
    columns = {name: np.where(is_own, values[source], np.nan) for name, values in read.columns.items()}
    columns["t_s"] = np.interp(every, own, t)
    columns[INTERPOLATED] = np.zeros(len(every))
    for triad, known in there.items():
        columns[INTERPOLATED] += TRIAD_BITS[KINDS[triad]] * ~(is_own & known[source])
        for name in TRIADS[triad]:
            columns[name] = bridged(columns["t_s"], t[known], read.columns[name][known])
    lines = [read.line(row) for row in source.tolist()] if read.lines is not None else None
    return replace(read, columns=columns, lines=lines), text


def _without_empty(found: LogColumns, notes: list[str]) -> LogColumns:
    """Return a log's columns without the outputs that hold no number at all, which are named in ``notes``."""
    named = [name for name in (*found.gyro, *found.accel) if name]
    empty = [name for name in named if not np.isfinite(found.table.column(name)).any()]
    if empty == named:
        return found
    notes += [f"{name} is empty: not used" for name in empty]
    gyro, accel = (tuple(None if each in empty else each for each in part) for part in (found.gyro, found.accel))
    return replace(found, gyro=gyro, accel=accel)


def _refuse_beyond_numbers(found: LogColumns) -> None:
    named = (found.time, *found.gyro, *found.accel, found.reference, *found.auxiliary)
    for name in filter(None, named):
        values = found.table.column(name)
        beyond = np.flatnonzero(np.isfinite(values) & (np.abs(values) > LARGEST))
        if len(beyond):
            text = f"{values[beyond[0]]:.3g} in column {name}"
            raise DataRefused(found.table.file, found.table.line(int(beyond[0])), text, f"at most {LARGEST:g}")


def _repeated(stamps: FloatArray, outputs: Sequence[FloatArray | None]) -> BoolArray:
    """Mark rows that were written twice: of the stamp and outputs of the row before, as all of one stamp are.

    Where others of one stamp differ they are samples of one read, some of which may be alike by chance.
    """
    shared = np.concatenate(([False], np.diff(stamps) == 0))
    same = shared.copy()
    for part in outputs:
        if part is not None:
            same[1:] &= (part[1:] == part[:-1]).all(axis=1)
    return same if np.array_equal(same, shared) else np.zeros(len(same), dtype=bool)


def _place(found: LogColumns, rows: BoolArray) -> str:
    word = "row" if found.table.lines is None else "line"
    return f"{word} {found.table.line(int(np.flatnonzero(rows)[0]))}"


def _times(
    found: LogColumns, stamps: FloatArray | None, keep: BoolArray, rate_hz: float | None, notes: list[str]
) -> tuple[dict[str, FloatArray], float | None]:
    """Return ``t_s``, from the stamps or the rate, and its origin; none of a rate table."""
    if stamps is None:
        t = np.flatnonzero(keep) / rate_hz if rate_hz else None
        return ({} if t is None else {"t_s": t}), None
    if not np.ptp(stamps[keep]) > 0:
        frozen = f"{found.time} that never changes"
        raise DataRefused(found.table.file, None, frozen, "times that rise",
                          "state --rate HZ instead of --time", ErrorCode.TIME_ORDER)  # fmt: skip
    try:
        times = log_times(stamps[keep], found.unit_time.seconds)
    except StampsGoBack as error:
        raise _set_back(found, error, np.flatnonzero(keep)) from None
    notes += times.notes()
    return {"t_s": times.t}, None if times.wraps else times.origin


def _set_back(found: LogColumns, error: StampsGoBack, kept: IntArray) -> DataRefused:
    """Return the refusal of a time that goes back, in the words of the file."""
    assert found.time is not None
    before, row = (int(each) for each in kept[error.row - 1 : error.row + 1])
    stamp = f"{found.time} {found.table.cell(row, found.time)} after {found.table.cell(before, found.time)}"
    remedy = "cut the log in two there, or name another column"
    fall_s = (error.before - error.after + error.usual) * found.unit_time.seconds
    if abs(fall_s - S_PER_H) <= SAME_WRAP_STEPS * error.usual * found.unit_time.seconds:
        stamp += ", a clock set back by 3600 s as at the end of summer time"
        remedy = "add one hour from there on (UTC has no such step), or state --rate HZ in place of a time column"
    expected = "times that rise, or wrap at one number"
    line = found.table.line(row)
    return DataRefused(found.table.file, line, stamp, expected, remedy, ErrorCode.TIME_ORDER)


def _say_constant(values: FloatArray, names: Sequence[str | None], notes: list[str]) -> None:
    for i, name in enumerate(names):
        if name and not np.ptp(values[:, i]):
            notes.append(f"{name} is a constant {values[0, i]:g}: not used")


def _auxiliary_names(names: Sequence[str]) -> list[str]:
    """Return a name for each auxiliary column of a step's file, numbered where several would be alike."""
    plain = [f"aux_{re.sub(r'[^A-Za-z0-9_]+', '_', name)}" for name in names]
    used = list[str]()
    for name in plain:
        alike = (name if i == 1 else f"{name}_{i}" for i in range(1, len(names) + 2))
        used.append(next(each for each in alike if each not in used and (each == name or each not in plain)))
    return used


def _auxiliary_columns(found: LogColumns, keep: BoolArray, notes: list[str]) -> dict[str, FloatArray]:
    """Return temperature and auxiliary channels, but for those that never change or are empty."""
    named: Mapping[str, str] = dict(zip(_auxiliary_names(found.auxiliary), found.auxiliary, strict=True))
    named = named if found.temperature is None else {"temp_c": found.temperature, **named}
    columns = dict[str, FloatArray]()
    for column, name in named.items():
        values = np.where(np.isfinite(values := found.table.column(name)[keep]), values, np.nan)
        values = found.temperature_unit.celsius(values) if column == "temp_c" else values
        known = values[np.isfinite(values)]
        if len(known) and np.ptp(known) > 0:
            columns[column] = values
        else:
            notes.append(f"{name} is {'empty' if not len(known) else f'a constant {known[0]:g}'}: not used")
    return columns
