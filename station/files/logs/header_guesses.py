"""What a log's header says of its columns: time, triads, temperature, and the unit in a name.

A guess is made for what nobody told, and is always shown. Names are compared in lower case, without blanks.
"""

import re
from collections.abc import Iterator, Sequence

from procedures.frames import AXES
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, SPELLED, TIME_UNITS, unit_named

_GYRO = r"(?:gyroscope|gyros?|gyr|ang(?:ular)?_?(?:vel(?:ocity)?|rate)|omega|w|g)"
_ACCEL = r"(?:accelerometer|accel(?:eration)?|acc|lin(?:ear)?_?acc(?:eration)?|specific_?force|a|f)"
_TIME = re.compile(r"(?:t|time|.*time_?stamp|.*(?:^|_)time)(?:_?(?:s|ms|us|µs|ns|sec|seconds|usec|msec|nsec))?")  # noqa: RUF001
_TEMPERATURE = re.compile(r"(?:.*_)?temp(?:erature)?(?:_.*)?|t_?degc|t_?c")


def split_unit(name: str) -> tuple[str, str]:
    """Return a column's name in lower case without its unit, and the unit in its brackets or behind ``_``."""
    plain = re.sub(r"\s+", "_", name.strip().lower())
    if bracket := re.fullmatch(r"(.*?)_?[\[(](.*)[\])]", plain):
        return bracket[1], unit_named(bracket[2])
    units = [*SPELLED, *GYRO_UNITS, *ACCEL_UNITS, *TIME_UNITS]
    for unit in sorted(units, key=len, reverse=True):
        if plain.endswith(f"_{unit}") and len(plain) > len(unit) + 1:
            return plain.removesuffix(f"_{unit}"), unit_named(unit)
    return plain, ""


def guessed_time(names: Sequence[str]) -> str | None:
    """Return the column that holds the time, None where none does by its name."""
    return next((name for name in names if _TIME.fullmatch(split_unit(name)[0])), None)


def guessed_temperature(names: Sequence[str]) -> str | None:
    """Return the column that holds a temperature, None where none does by its name."""
    return next((name for name in names if _TEMPERATURE.fullmatch(re.sub(r"\s+", "_", name.lower()))), None)


def guessed_triad(names: Sequence[str], triad: str) -> list[str | None]:
    """Return the columns of x, y, z of a ``triad``, gyroscope or accelerometer; None of one that is not there."""
    word = _GYRO if triad == "gyroscope" else _ACCEL
    return [next(_of_axis(names, word, axis), None) for axis in AXES]


def _of_axis(names: Sequence[str], word: str, axis: str) -> Iterator[str]:
    pattern = re.compile(rf"(?:.*[_./])?(?:{word}[_.]?{axis}|{axis}[_.]?{word})(?:_?raw)?")
    for name in names:
        if pattern.fullmatch(split_unit(name)[0].replace("-", "_")):
            yield name
