"""Which columns of a log hold what: as stated, else as its header says, and their units."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from shlex import quote

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.time_unit import SECOND, TimeUnit
from procedures.errors import ErrorCode
from procedures.frames import AXES
from station.errors import DataRefused
from station.files.logs.header_guesses import (
    degrees_per_angle,
    guessed_temperature,
    guessed_time,
    guessed_utc,
    split_unit,
)
from station.files.logs.temperature import temperature_column
from station.files.logs.time_units import compare_clocks, other_clocks, unit_of_points, unit_of_time
from station.files.logs.triad_guesses import (
    bare_axes,
    guessed_reference,
    guessed_triad,
    is_by_letter_g,
    is_called_as_other,
    sensors_without_axis,
    unit_by_logger,
    unit_of_triad,
)
from station.files.output_units import ACCEL_UNITS, DEGC, GYRO_UNITS, RAW, TemperatureUnit
from station.files.tables.dates import readings
from station.files.tables.table import MAX_NAMES_SHOWN, Table

_SAY_Z = "(state -,-,COL for z)"
ABSENT = "-"  # of a channel that the log does not have
GUESSED_GRAVITY = 0.1  # relative: how near 1 g at rest an output must be for its unit to be guessed
FEWEST_COUNTS = 64  # in 1 g, of accelerometers of 8 bits
STEADY_LENGTH = 0.5  # relative interquartile range: gravity's length varies less in motion, that of a rate more


@dataclass(frozen=True, slots=True)
class ColumnOptions:
    """What the user stated of a log: columns by name or number; None is guessed, empty there is none."""

    time: str | None = None
    gyro: tuple[str, ...] | None = None
    accel: tuple[str, ...] | None = None
    temperature: str | None = None
    auxiliary: tuple[str, ...] = ()
    reference: str | None = None
    utc: str | None = None
    unit_time: str | None = None
    unit_gyro: str | None = None
    unit_accel: str | None = None
    unit_temperature: str | None = None
    rate_hz: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LogColumns:
    """A log's columns by what they hold: names, None of a channel that is not there; ``guesses`` as text.

    ``reference_unit`` is how many of the reference are 1 deg/s.
    ``degrees_per_angle`` is how many degrees a unit of the reference is, where it is an angle.
    ``utc`` is another clock's time of the same rows; ``clocks`` are all others alongside ``time``.
    """

    table: Table
    time: str | None
    gyro: tuple[str | None, ...]
    accel: tuple[str | None, ...]
    temperature: str | None
    auxiliary: tuple[str, ...]
    reference: str | None
    unit_time: TimeUnit
    unit_gyro: str | None
    unit_accel: str | None
    temperature_unit: TemperatureUnit = DEGC
    reference_unit: float = 1.0
    degrees_per_angle: float | None = None
    utc: str | None = None
    unit_utc: TimeUnit = SECOND
    clocks: tuple[str, ...] = ()
    guesses: list[str] = field(default_factory=list)


def choose_columns(
    table: Table,
    stated: ColumnOptions,
    stamps_of: Callable[[Sequence[str], bool], FloatArray] | None = None,
    column_of: Callable[[str], FloatArray] | None = None,
) -> LogColumns:
    """Return what a log's columns hold.

    Of a log that is streamed, ``stamps_of`` returns the first stamps (n,), as of `unit_of_time`, and ``column_of``
    a whole column. Raise `DataRefused` if a column that was stated is not there, none is an output, or there is
    neither time nor rate.
    """
    names, guesses = list(table.columns), list[str]()
    free = not_stated(table, stated)
    gyro, accel = (triad_columns(table, stated, triad, free, guesses) for triad in ("gyro", "accel"))
    gyro = gyro if any(gyro) or stated.gyro is not None else single_sensor(free, "gyroscope", guesses)
    accel = (
        accel
        if any((*gyro, *accel)) or stated.accel is not None
        else single_sensor(free, "accelerometer", guesses)
    )
    if not any((*gyro, *accel)):
        raise DataRefused(
            table.file, None, f"columns {', '.join(names[:30])}", "outputs",
            f"name them: {_named_as('--gyro', free, 'gyroscope')} or {_named_as('--accel', free, 'accelerometer')}"
            f"{_or_a_table(free, stated)}",
            ErrorCode.COLUMNS,
        )  # fmt: skip
    time = None if stated.time is None else table.name_of(stated.time)
    reference = None if stated.reference is None else table.name_of(stated.reference)
    angle = None if reference is None else degrees_per_angle(reference)
    is_table = reference is not None and angle is None
    unit_time = stated.unit_time or (unit_of_points(table, time) if is_table else None)
    if time is None and stated.rate_hz is None and (time := time_column(table, free)) is not None:
        unit_time = stated.unit_time or (unit_of_points(table, time) if is_table else None)
        time = time if unit_time or not is_table else None  # points say nothing of a unit that is not named
        guesses += [] if time is None else [f"time is {time}{f', in {unit_time}' if is_table else ''}"]
    if time is None and stated.rate_hz is None and not is_table:
        raise DataRefused(
            table.file, None, "no time column", "--time COL or --rate HZ, or --reference COL of a rate table",
            f"name one of them{_or_a_table(free, stated)}", code=ErrorCode.COLUMNS,
        )  # fmt: skip
    _refuse_unreadable_time(table, time)
    temperature, temperature_unit = temperature_column(
        table, stated.temperature, stated.unit_temperature, free, guesses, column_of
    )
    unit_gyro = stated.unit_gyro or _unit(names, gyro, guesses, "gyroscopes", GYRO_UNITS)
    unit_gyro = unit_gyro or unit_by_logger(names, gyro, "gyro", guesses)
    if unit_gyro is None and any(gyro):
        guesses.append("gyroscopes have no unit: their values are outputs. Name it with --unit-gyro.")
    unit_accel = stated.unit_accel or _unit(names, accel, guesses, "accelerometers", ACCEL_UNITS)
    unit_accel = unit_accel or unit_by_logger(names, accel, "accel", guesses)
    if angle is not None:
        guesses.append(f"{reference} is an angle, {angle:.6g} deg a unit")
    utc = _utc(table, stated, time, free, guesses)
    found = LogColumns(
        table=table, time=time, gyro=gyro, accel=accel, temperature=temperature,
        auxiliary=tuple(table.name_of(key) for key in stated.auxiliary), reference=reference,
        utc=utc, unit_utc=unit_of_time(table, utc, None, stated.rate_hz, guesses) if utc else SECOND,
        temperature_unit=temperature_unit, reference_unit=_reference_unit(reference, guesses),
        degrees_per_angle=angle, clocks=() if time is None else tuple(other_clocks(table, time, free)),
        unit_time=unit_of_time(
            table, time, unit_time, stated.rate_hz, guesses, stamps_of,
            [name for name in (*gyro, *accel) if name],
        ),
        unit_gyro=unit_gyro, unit_accel=unit_accel or _by_gravity(table, accel, guesses), guesses=guesses,
    )  # fmt: skip
    used = _refuse_twice(found)
    if stamps_of is None and time is not None:
        guesses += compare_clocks(table, time, found.unit_time, found.clocks, stated.time is not None)
    _refuse_ambiguous_kinds(found, stated, free)
    if found.temperature is None and stated.temperature is None:
        used.append(guessed_temperature(free) or "")  # a guess says why it is not
    if unused := [name for name in names if name not in used and name]:
        shown = ", ".join(unused[:MAX_NAMES_SHOWN]) + (", ..." if len(unused) > MAX_NAMES_SHOWN else "")
        hint = _unused_hint(unused, found, stated)
        guesses.append(f"not used: {shown}{f' ({hint})' if hint else ''}")
    return found


def _or_a_table(free: Sequence[str], stated: ColumnOptions) -> str:
    """Return the option of a rate table, where a column is called as its rate and nobody named it.

    Another column must be left for its outputs.
    """
    called = None if stated.reference is not None else guessed_reference(free)
    others = {called, guessed_time(free), guessed_temperature(free)}
    is_stated = stated.gyro is not None or stated.accel is not None
    if not is_stated and others.issuperset(free):
        return ""
    return "" if called is None else f"; if this is a rate table, type --reference {quote(called)}"


def _unused_hint(unused: Sequence[str], found: LogColumns, stated: ColumnOptions) -> str:
    """Return the options that name what a log's unused columns may hold."""
    options = (
        list[str]() if stated.temperature == "" else ["--temperature names a temperature", "--aux other channels"]
    )
    for triad, what in (("gyro", "gyroscopes"), ("accel", "accelerometers")):
        if len(unused) >= len(AXES) and getattr(stated, triad) is None and not any(getattr(found, triad)):
            options.insert(0, f"--{triad} A,B,C the {what}")
    if found.reference is None and guessed_reference(unused):
        options.insert(0, "--reference the rate of a rate table")
    if found.time is None and time_column(found.table, unused):
        options.insert(0, "--time the time")
    return ", ".join(options)


def time_column(table: Table, free: Sequence[str]) -> str | None:
    """Return the column of time by its name, else the first of moments, else UTC, which is a time as well.

    A column of text is one where no other is, so that it can be named.
    """
    moments = (name for name in free if name in table.moments)
    numbers = [name for name in free if name not in table.unreadable]
    return guessed_time(numbers) or next(moments, None) or guessed_utc(numbers) or guessed_time(free)


def _refuse_unreadable_time(table: Table, time: str | None) -> None:
    """Refuse a column of time that holds text, or dates whose day and month may be in either order."""
    if time is None or time not in table.unreadable:
        return
    row, text = table.unreadable[time]
    expected, remedy = "a number, a clock or a date", "write it as ISO 8601 (2026-03-12T09:14:03.000)"
    if len(dates := readings(text)) > 1:
        expected = f"a date that can be read in one way, not as {' and as '.join(dates)}"
        remedy = f"write it as ISO 8601, {' or '.join(dates)}"
    raise DataRefused(
        table.file, table.line(row), f"{text[:40]!a} in column {time}", expected,
        f"{remedy}, or state --rate HZ in place of a time column", ErrorCode.COLUMNS,
    )  # fmt: skip


def _utc(
    table: Table, stated: ColumnOptions, time: str | None, free: Sequence[str], guesses: list[str]
) -> str | None:
    if stated.utc is not None:
        return table.name_of(stated.utc)
    found = None if stated.reference is not None else guessed_utc([name for name in free if name != time])
    if found is not None:
        guesses.append(f"UTC is {found}")
    return found


def not_stated(table: Table, stated: ColumnOptions) -> list[str]:
    """Return the columns that nobody stated anything of: of these what they hold may be guessed."""
    keys = [
        stated.time,
        stated.temperature,
        stated.reference,
        stated.utc,
        *stated.auxiliary,
        *(stated.gyro or ()),
        *(stated.accel or ()),
    ]
    named = {table.name_of(key) for key in keys if key and key != ABSENT}
    return [name for name in table.columns if name not in named]


def triad_columns(
    table: Table, stated: ColumnOptions, triad: str, free: Sequence[str], guesses: list[str]
) -> tuple[str | None, ...]:
    """Return the columns of x, y, z of a ``triad``, gyro or accel: as stated, else found among those ``free``."""
    keys: tuple[str, ...] | None = getattr(stated, triad)
    if keys is None:
        found = tuple(guessed_triad(free, "gyroscope" if triad == "gyro" else "accelerometer"))
        if any(found):
            guesses.append(f"{triad} is {','.join(name or ABSENT for name in found)}")
        elif (bare := bare_axes(free, table.file)) is not None and bare[0] == triad:
            found = bare[1]
            guesses += bare[2]
        return found
    names = [None if key in {ABSENT, ""} else table.name_of(key) for key in keys]
    if len(names) > len(AXES):
        raise DataRefused(
            table.file,
            None,
            f"{len(names)} columns for {triad}",
            "x,y,z, with - for one not there",
            code=ErrorCode.COLUMNS,
        )
    if len(names) == 1 and names[0] is not None:  # a one-axis sensor: its name may say which
        last = split_unit(names[0])[0][-1:]
        axis = AXES.index(last) if last in AXES else 0
        guesses.append(f"{names[0]} is the sensor {AXES[axis]} {_SAY_Z}")
        names = [names[0] if i == axis else None for i in range(3)]
    return (*names, *(None,) * (3 - len(names)))


def single_sensor(free: Sequence[str], triad: str, guesses: list[str]) -> tuple[str | None, ...]:
    """Return the only sensor in a unit of a ``triad`` as its x, by the unit alone."""
    if len(found := sensors_without_axis(free, triad)) != 1:
        return (None, None, None)
    guesses.append(f"{found[0]} is used as {triad} x, its name states no axis {_SAY_Z}")
    return (found[0], None, None)


def _named_as(option: str, free: Sequence[str], triad: str) -> str:
    """Return the option that names a triad, with the columns in a unit of it where these are as many."""
    found = sensors_without_axis(free, triad)
    is_short = 2 <= len(found) <= len(AXES) and not any("," in name for name in found)
    shown = ",".join(found) if is_short else "A,B,C"
    return f"{option} {quote(shown)}"


def _reference_unit(reference: str | None, guesses: list[str]) -> float:
    unit = "" if reference is None else split_unit(reference)[1]
    if unit not in GYRO_UNITS:
        return 1.0
    guesses.append(f"{reference} is in {unit}")
    return GYRO_UNITS[unit]


def _unit(
    names: Sequence[str], columns: Sequence[str | None], guesses: list[str], what: str, known: Mapping[str, float]
) -> str | None:
    if unit := unit_of_triad(names, columns, known):
        guesses.append(f"{what} in {unit}")
    return unit


def _by_gravity(table: Table, accel: Sequence[str | None], guesses: list[str]) -> str | None:
    """Return the only unit in which a whole triad's median length is about 1 g, None where it may be another."""
    usual, _ = _length(table, accel)
    readings = _readings_of_gravity(usual, 2 * GUESSED_GRAVITY)  # motion moves the length towards another's
    if len(readings) > 1:
        guesses.append(
            f"accelerometers in no unit: their length {usual:.4g} may be 1 g in {' or '.join(readings)} "
            "(--unit-accel)"
        )
    if len(readings) != 1 or readings[0] not in ACCEL_UNITS or not _readings_of_gravity(usual):
        return None
    guesses.append(f"accelerometers in {readings[0]}, their length being {usual:.4g}")
    return readings[0]


def _length(table: Table, triad: Sequence[str | None]) -> tuple[float, float]:
    """Return the median length of a whole triad, and its interquartile range relative to it; 0 of another."""
    if not all(triad):
        return 0.0, 0.0
    x, y, z = (table.column(name) for name in triad if name)
    length = np.hypot(np.hypot(x, y), z)
    length = length[np.isfinite(length)]
    first, usual, third = np.percentile(length, (25, 50, 75)) if len(length) else (0.0, 0.0, 0.0)
    return float(usual), float((third - first) / usual) if usual else 0.0


def _readings_of_gravity(length: float, tolerance: float = GUESSED_GRAVITY) -> list[str]:
    """Return the units in which a length is about 1 g, among them counts: full scales are powers of two."""
    counts = 2 ** round(np.log2(length)) if length > 0 else 0
    known = {**ACCEL_UNITS, **({f"{counts}/g": counts} if counts >= FEWEST_COUNTS else {})}
    return [unit for unit, per_g in known.items() if abs(length / per_g - 1) < tolerance]


def _refuse_ambiguous_kinds(found: LogColumns, stated: ColumnOptions, free: Sequence[str]) -> None:
    """Refuse triads that may be of either kind by what their names and lengths say."""
    for triad in ("gyro", "accel"):
        columns = getattr(found, triad)
        if getattr(stated, triad) is None and is_called_as_other(free, columns):
            raise _ask_kind(found, columns, "named like columns of another unit")
    is_stated = stated.gyro is not None or stated.unit_gyro is not None
    if is_stated or any(found.accel) or found.unit_gyro not in {None, RAW} or not all(found.gyro):
        return
    usual, spread = _length(found.table, found.gyro)
    is_by_letter = all(is_by_letter_g(name) for name in found.gyro if name)  # of gx, which may be in g
    if is_by_letter and spread < STEADY_LENGTH and (readings := _readings_of_gravity(usual, 2 * GUESSED_GRAVITY)):
        raise _ask_kind(
            found, found.gyro, f"gyroscopes by their letter, and the length of gravity in {' or '.join(readings)}"
        )


def _ask_kind(found: LogColumns, columns: Sequence[str | None], what: str) -> DataRefused:
    names = ",".join(name or ABSENT for name in columns)
    return DataRefused(
        found.table.file, None, f"{names} {what}", "gyroscopes or accelerometers",
        f"state --gyro {names} or --accel {names}", ErrorCode.COLUMNS,
    )  # fmt: skip


def _refuse_twice(found: LogColumns) -> list[str]:
    """Return the columns that are used, each of which is for one thing."""
    others = found.reference, found.utc, found.temperature
    names = [found.time, *found.gyro, *found.accel, *others, *found.auxiliary]
    used = [name for name in names if name]
    if again := [name for name in used if used.count(name) > 1]:
        raise DataRefused(
            found.table.file,
            None,
            f"column {again[0]} for two things",
            "each column once",
            "name another column",
            code=ErrorCode.COLUMNS,
        )
    return used


def outputs(found: LogColumns, columns: Sequence[str | None]) -> FloatArray | None:
    """Return a triad's outputs (n, 3) in the log's unit, 0 of a channel that is not there; None without any."""
    if not any(columns):
        return None
    nothing = np.zeros(found.table.rows)
    return np.stack([found.table.column(name) if name else nothing for name in columns], axis=1)
