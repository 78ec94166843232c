"""Samples of any table and of a step's CSV file; units and time must agree with the calibration and --rate."""

from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.missing_rows import INTERPOLATED, TRIAD_BITS
from procedures.counts.time_decision import evidence_rows, may_be_clock
from procedures.effects.term.inputs import AUXILIARY
from procedures.errors import ErrorCode
from station.applying.source import Samples, Stated, channels_by_column
from station.errors import DataRefused
from station.files.logs.header_guesses import guessed_time, split_unit
from station.files.logs.log_columns import ColumnOptions, LogColumns, choose_columns
from station.files.logs.time_units import CLOCK_ROWS, compare_clocks, stamps_with_outputs, unit_of_time
from station.files.logs.triad_guesses import unit_of_triad
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, RAW, outputs_per_unit
from station.files.tables.reader import open_table
from station.files.tables.table import Block, TableReader

MAX_TIMES_OFF = 1.25  # of a scale factor from what a unit makes it: two units differ by more
MAX_RATE_OFF = 1e-2  # relative
KNOWN = {"gyroscope": (GYRO_UNITS, "deg/s", "--unit-gyro"), "accelerometer": (ACCEL_UNITS, "g", "--unit-accel")}


def refuse_other_units(stated: Stated, document: Mapping[str, Any]) -> None:
    """Refuse rates whose columns are in a unit other than the calibration's outputs were.

    Raises
    ------
    DataRefused
        Naming the unit, and how many outputs 1 deg/s or 1 g is in the calibration.
    """
    for triad, unit in stated.units:
        known, per, option = KNOWN[triad]
        outputs = outputs_per_unit(unit, known)
        if triad not in document or outputs is None:
            continue
        k = float(np.mean(np.abs(document[triad]["scale_factor"]["value"])))
        if not 1 / MAX_TIMES_OFF < k / outputs < MAX_TIMES_OFF:
            raise DataRefused(
                stated.name, None, f"{triad} in {unit}, {outputs:.4g} outputs in 1 {per}",
                f"{k:.4g} outputs in 1 {per}, as in the calibration",
                f"convert the columns, or state {option} raw if their names are wrong",
            )  # fmt: skip


def refuse_other_rate(t: FloatArray, column: str, rate_hz: float, name: str) -> None:
    """Refuse ``--rate`` [1/s] where a column of times ``t`` (n,) [s] says otherwise by more than 1 %."""
    step = float(np.nanmedian(np.diff(t))) if len(t) > 1 else 0.0
    if step > 0 and abs(step * rate_hz - 1) > MAX_RATE_OFF:
        raise DataRefused(
            name, None, f"{1 / step:.6g} rows a second by column {column}", f"--rate {rate_hz:g} within 1 %",
            "omit --rate, or remove the column",
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class LogSource:
    """A log whose columns are known; ``rate_hz`` where it has no time."""

    blocks_of: TableReader
    found: LogColumns
    auxiliary: dict[str, str]
    rate_hz: float | None
    stated: Stated

    @classmethod
    def open(cls, file: Path, stated: ColumnOptions) -> "LogSource":
        """Open a log.

        Raise `DataRefused` if the file or a column that was stated is not there, there are no outputs or no time,
        or two channels would be one column.
        """
        table = open_table(file)
        names = [name for name in table.head.columns if name.startswith(AUXILIARY)]
        asked = dict.fromkeys(table.head.name_of(key) for key in stated.auxiliary)
        raw = replace(stated, unit_gyro=stated.unit_gyro or RAW, unit_accel=stated.unit_accel or RAW,
                      auxiliary=tuple(asked | dict.fromkeys(names)))  # fmt: skip
        found = choose_columns(table.head, raw, partial(_stamps, table), partial(_whole, table))
        _compare_clocks(table, found, stated.time is not None)
        header = list(table.head.columns)
        units = {
            "gyroscope": stated.unit_gyro or unit_of_triad(header, found.gyro, GYRO_UNITS),
            "accelerometer": stated.unit_accel or unit_of_triad(header, found.accel, ACCEL_UNITS),
        }
        own_units = tuple((triad, unit) for triad, unit in units.items() if unit and unit != RAW)
        named = [split_unit(name)[1] for name in (*found.gyro, *found.accel) if name]
        rates = [unit for unit in (stated.unit_gyro, stated.unit_accel, *named)
                 if unit in {*GYRO_UNITS, *ACCEL_UNITS} or (unit and "/" in unit)]  # fmt: skip
        auxiliary = channels_by_column(found.auxiliary, str(file))
        notes = tuple(guess for guess in found.guesses if "reference" not in guess)
        period = 1 / stated.rate_hz if stated.rate_hz else None
        has_temperature = found.temperature is not None
        text = Stated(
            str(file), rates_in=rates[0] if rates else "", period=period, temperature=has_temperature,
            auxiliary=tuple(auxiliary), notes=notes, units=own_units,
            triads=tuple(n for n, own in (("accelerometer", found.accel), ("gyroscope", found.gyro)) if any(own)),
            accelerometers=tuple(name is not None for name in found.accel),
        )  # fmt: skip
        numbers = [name for name in table.head.columns if name not in table.head.unreadable]
        if stated.rate_hz and stated.time is None and (column := guessed_time(numbers)):
            with closing(table.read([column])) as read:
                block = next(read)
            unit = unit_of_time(table.head, column, stated.unit_time, stated.rate_hz, [], partial(_stamps, table))
            refuse_other_rate(unit.linear(block.columns[column]) * unit.seconds, column, stated.rate_hz, str(file))
        return cls(table, found, auxiliary, stated.rate_hz, text)

    def blocks(self) -> Generator[Samples]:
        """Yield all rows, as `Source`; a channel of a triad that the log lacks is 0, what was interpolated nan."""
        row, found, head = 0, self.found, self.blocks_of.head
        marks = INTERPOLATED if INTERPOLATED in head.columns and INTERPOLATED not in head.unreadable else None
        named = [name for name in (found.time, *found.gyro, *found.accel, found.temperature, marks) if name]
        wanted = list(dict.fromkeys([*named, *self.auxiliary.values()]))
        for block in self.blocks_of.read(wanted):
            n = len(next(iter(block.columns.values())))
            t = self._times(block, row)
            values = np.full((n, 6), np.nan)
            for first, names in ((0, found.gyro), (3, found.accel)):
                for i, name in enumerate(names if any(names) else ()):
                    values[:, first + i] = 0.0 if name is None else block.columns[name]
            if marks:
                bits = np.nan_to_num(block.columns[marks]).astype(np.int64)
                values[(bits & TRIAD_BITS["gyroscope"]) != 0, :3] = np.nan
                values[(bits & TRIAD_BITS["accelerometer"]) != 0, 3:] = np.nan
            temperature = None
            if found.temperature is not None:
                temperature = found.temperature_unit.celsius(block.columns[found.temperature])
            auxiliary = {key: block.columns[name] for key, name in self.auxiliary.items()}
            row += n
            yield Samples(t, values, temperature, auxiliary, block.done, self.stated.name, block.lines)

    def _times(self, block: Block, row: int) -> FloatArray:
        if self.found.time is None:
            assert self.rate_hz is not None
            n = len(next(iter(block.columns.values())))
            counted: FloatArray = (row + np.arange(1.0, n + 1)) / self.rate_hz
            return counted
        unit = self.found.unit_time
        return unit.linear(block.columns[self.found.time]) * unit.seconds


def _stamps(blocks: TableReader, columns: Sequence[str], whole: bool) -> FloatArray:
    """Return as many stamps (n,) as a decision about their unit needs; of the whole log, also the last.

    Of ``columns`` the first is the time, the others are outputs.
    """
    first, last, is_enough = np.empty(0), np.empty(0), False
    with closing(blocks.read(columns)) as read:
        for block in read:
            stamps = stamps_with_outputs([block.columns[name] for name in columns])
            last = stamps[-1:] if len(stamps) else last
            if not is_enough:
                first = np.concatenate((first, stamps))
                is_enough = evidence_rows(first) <= len(first) and not may_be_clock(first)
            if is_enough and not whole:
                break
    return np.concatenate((first, last[last > first[-1:]])) if whole else first


def _whole(blocks: TableReader, column: str) -> FloatArray:
    """Return all rows (n,) of a column."""
    with closing(blocks.read([column])) as read:
        return np.concatenate([block.columns[column] for block in read])


def _compare_clocks(blocks: TableReader, found: LogColumns, is_stated: bool) -> None:
    """Compare the clocks of as many rows as of a log that is read whole."""
    if found.time is None or not found.clocks:
        return
    names, read = (found.time, *found.clocks), list[Block]()
    rows = 0
    try:
        with closing(blocks.read(names)) as each:
            for block in each:
                read.append(block)
                rows += len(block.columns[found.time])
                if rows >= CLOCK_ROWS:
                    break
    except DataRefused:  # text in a clock that is not needed; a wrong time is reported when it is read
        return
    columns = {name: np.concatenate([block.columns[name] for block in read]) for name in names}
    found.guesses.extend(
        compare_clocks(replace(blocks.head, columns=columns), found.time, found.unit_time, found.clocks, is_stated)
    )


def step_source(file: Path, stated: Stated) -> LogSource:
    """Open a step's CSV file of campaign/1; ``stated`` is what the campaign says."""
    columns = ColumnOptions(time="t_s", gyro=None, accel=None, unit_time="s")
    found = LogSource.open(file, columns)
    if not any(found.found.gyro) and not any(found.found.accel):
        raise DataRefused(file, 1, "no outputs", "gx, gy, gz or ax, ay, az", code=ErrorCode.COLUMNS)
    own = found.stated
    text = replace(
        stated, name=own.name, temperature=own.temperature, auxiliary=own.auxiliary, triads=own.triads,
        accelerometers=own.accelerometers,
    )  # fmt: skip
    return replace(found, stated=text)
