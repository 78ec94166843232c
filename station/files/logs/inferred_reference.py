"""The reference of a rate table that nobody named, where the columns of a log leave no other reading."""

import numpy as np

from procedures.counts.encoder_angle import slope_and_correlation
from station.files.logs.header_guesses import degrees_per_angle
from station.files.logs.log_columns import (
    ColumnOptions,
    not_stated,
    single_sensor,
    time_column,
    triad_columns,
)
from station.files.logs.time_units import are_points
from station.files.logs.triad_guesses import guessed_reference
from station.files.tables.table import Table

MIN_CORRELATION = 0.7  # of a gyroscope with the reference that turns it


def inferred_reference(table: Table, stated: ColumnOptions) -> str | None:
    """Return the column that must be a rate table's reference, where nobody named one; None where none must be.

    One column alone is called so, it is a rate, another is an output that follows it, and there is no time, or its
    rows are farther apart than samples are.
    """
    free = not_stated(table, stated)
    called = [name for name in free if guessed_reference([name]) and name not in table.unreadable]
    if stated.reference is not None or stated.rate_hz is not None or len(called) != 1:
        return None
    (reference,) = called
    time = time_column(table, free) if stated.time is None else table.name_of(stated.time)
    if degrees_per_angle(reference) is not None or (time is not None and not are_points(table, time)):
        return None
    others = [name for name in free if name != reference]
    gyro = triad_columns(table, stated, "gyro", others, [])
    gyro = gyro if any(gyro) else single_sensor(others, "gyroscope", [])
    rate, outputs = table.columns[reference], [table.columns[n] for n in gyro if n and n not in table.unreadable]
    known = [np.isfinite(rate) & np.isfinite(each) for each in outputs]
    correlations = [
        slope_and_correlation(rate[rows], each[rows])[1] if rows.any() else 0.0
        for each, rows in zip(outputs, known, strict=True)
    ]
    is_output = reference in triad_columns(table, stated, "gyro", free, [])
    follows = any(abs(each) >= MIN_CORRELATION for each in correlations)
    return reference if follows and not is_output else None
