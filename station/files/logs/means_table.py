"""``--as means``: a table with a row a pose, mean outputs and perhaps their standard deviations.

A column is a mean where it is called as an output is, with or without ``mean`` or ``avg``. One with ``std``,
``sigma`` or ``sd`` with the output's name is a standard deviation of samples, of which ``n`` or ``count`` says
how many there were.
"""

import re
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.errors import ErrorCode
from procedures.free_positions.pose_means import MAX_POSES, differ_like_poses
from station.errors import DataRefused
from station.files.logs.header_guesses import guessed_time
from station.files.logs.log_columns import ColumnOptions, LogColumns, choose_columns, outputs
from station.files.tables.table import Table

KIND = "means"
_PART = r"(?:(?<=^)|(?<=[_ .]))(?:{})(?:[_ .]|(?=[\[(]|$))"
_MEAN = re.compile(_PART.format("mean|means|avg|average|mittel"), re.IGNORECASE)
_OF_MEAN = re.compile(_PART.format("sem|std_?err|stderr|se"), re.IGNORECASE)
_OF_SAMPLES = re.compile(_PART.format("std|stdev|stddev|sd|sigma|rms"), re.IGNORECASE)
_COUNT = re.compile(r"n|count|counts|samples|n_?samples|num_?samples", re.IGNORECASE)


@dataclass(frozen=True, slots=True, eq=False)
class MeansTable:
    """Means of n poses: ``accel`` and ``gyro`` (n, 3), None of a triad that is not there, each with its std.

    A std is None where the table has none; ``found`` says which columns they are and in which units, ``rows`` (n,)
    which rows of the table they are.
    """

    found: LogColumns
    accel: FloatArray | None
    gyro: FloatArray | None
    accel_std: FloatArray | None
    gyro_std: FloatArray | None
    notes: tuple[str, ...]
    rows: IntArray


def is_means_table(table: Table, stated: ColumnOptions) -> bool:
    """Return whether a log is a table of means by itself: few rows that differ like poses, at no regular time."""
    if table.rows > MAX_POSES or stated.rate_hz is not None or stated.reference is not None:
        return False
    try:
        found = _columns(table, stated)[0]
    except (DataRefused, ValueError):
        return False
    accel = outputs(found, found.accel)
    if accel is None or not all(found.accel):
        return False
    time = guessed_time(list(table.columns)) if stated.time is None else table.name_of(stated.time)
    return differ_like_poses(accel, None if time is None else table.columns[time])


def means_of(table: Table, stated: ColumnOptions) -> MeansTable:
    """Return a log as a table of means.

    Raise `DataRefused` if no column is an output, a cell of one is no number, or there is a single row; if a row
    that is used has no number of samples, or no standard deviation, where there is a column of them.
    """
    found, stds, count = _columns(table, stated)
    triads = {"accel": outputs(found, found.accel), "gyro": outputs(found, found.gyro)}
    usable = np.ones(table.rows, dtype=bool)
    for values in triads.values():
        usable &= True if values is None else np.isfinite(values).all(axis=1)
    notes = list(table.notes)
    if not usable.all():
        notes.append(f"{int(np.sum(~usable))} rows without a number in an output: not used")
    if usable.sum() < 2:
        found_rows = f"{int(usable.sum())} row with a number in every output"
        raise DataRefused(table.file, None, found_rows, "a row a pose", "name another file", ErrorCode.TOO_SHORT)
    n = None if count is None else _checked(table, count, usable, 1.0)
    std = dict[str, FloatArray | None]()
    for triad, names in (("accel", found.accel), ("gyro", found.gyro)):
        its = [stds.get(name or "") for name in names]
        std[triad] = None
        if all(its) and triads[triad] is not None:
            columns = [
                _checked(table, column, usable, 0.0) / _root(n, is_of_mean)
                for column, is_of_mean in filter(None, its)
            ]
            std[triad] = np.stack(columns, axis=1)
            if n is None and not all(is_of_mean for _, is_of_mean in filter(None, its)):
                notes.append(
                    f"no number of samples (n): the standard deviations of {triad} are used as those of the means"
                )
    kept = {name: None if values is None else values[usable] for name, values in triads.items()}
    return MeansTable(
        found, kept["accel"], kept["gyro"], std["accel"], std["gyro"], tuple(notes),
        np.flatnonzero(usable),
    )  # fmt: skip


def _checked(table: Table, name: str, usable: BoolArray, least: float) -> FloatArray:
    """Return the rows of a column that are ``usable``; refuse the first that is no number of ``least`` or more."""
    values = table.column(name)
    bad = np.flatnonzero(usable & ~(np.isfinite(values) & (values >= least)))
    if len(bad):
        cell = values[bad[0]]
        found = f"{'no number' if np.isnan(cell) else f'{cell:g}'} in column {name}, pose {bad[0] + 1}"
        raise DataRefused(
            table.file, table.line(int(bad[0])), found, f"a number of at least {least:g}",
            "correct the cell, or delete the column", ErrorCode.COLUMNS,
        )  # fmt: skip
    return values[usable]


def _root(n: FloatArray | None, is_of_mean: bool) -> FloatArray | float:
    return 1.0 if n is None or is_of_mean else np.sqrt(n)


def _columns(table: Table, stated: ColumnOptions) -> tuple[LogColumns, dict[str, tuple[str, bool]], str | None]:
    """Return what the columns hold, each mean's std and whether it is the mean's own, and the count."""
    spread = {name: bool(_OF_MEAN.search(name)) for name in table.columns if _is_spread(name)}
    count = next((name for name in table.columns if _COUNT.fullmatch(name.strip())), None)
    named = {
        _MEAN.sub("", name).strip("_ ."): name for name in table.columns if name not in spread and name != count
    }
    view = replace(
        table, columns={plain: table.columns[name] for plain, name in named.items()},
        unreadable={plain: table.unreadable[name] for plain, name in named.items() if name in table.unreadable},
    )  # fmt: skip
    found = choose_columns(view, replace(stated, time=None, rate_hz=stated.rate_hz or 1.0))
    by_base = {_base(_OF_SAMPLES.sub("", _OF_MEAN.sub("", name))): (name, own) for name, own in spread.items()}
    stds = {name: by_base[_base(plain)] for plain, name in named.items() if _base(plain) in by_base}
    gyro, accel = (tuple(name and named[name] for name in triad) for triad in (found.gyro, found.accel))
    return replace(found, table=table, gyro=gyro, accel=accel), stds, count


def _is_spread(name: str) -> bool:
    return bool(_OF_SAMPLES.search(name) or _OF_MEAN.search(name))


def _base(name: str) -> str:
    """Return a column's name without its unit, for comparison."""
    return re.sub(r"[\[(].*?[\])]|[_ .]", "", name).lower()
