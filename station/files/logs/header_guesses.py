"""What a log's header says of its columns: time, temperature, the triads, and the unit in a name.

A guess is made for what nobody stated, and is always shown. Names are compared in lower case, without blanks.

Gyroscopes and accelerometers x, y, z are found by the unit that a name states, else by its words. A unit of rate
or acceleration decides the kind of sensor, whatever the letters before it: ``Gx (g)`` is an accelerometer, ``ax
[deg/s]`` a gyroscope. A unit of another quantity, as ``uT`` or ``deg``, is of neither.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

from procedures.counts.time_decision import LIE_ODDS
from procedures.counts.time_unit import BY_NAME, TimeUnit, unit_called
from procedures.frames import AXES
from procedures.units import RAD_PER_DEG
from station.files.output_units import (
    ACCEL_UNITS,
    GYRO_UNITS,
    NOT_BEHIND_A_NAME,
    OTHER_QUANTITIES,
    RAW,
    TIME_UNITS,
    is_quotient,
    is_unit,
    temperature_unit,
    unit_behind_name,
    unit_named,
)

_UNIT_OF_TIME = r"(?:s|ms|us|µs|ns|min|h|sec|seconds|usec|msec|nsec|minutes|hours|days?)"  # noqa: RUF001
_TIME_WORD = (
    r"(?:t|time|.*time_?stamp|.*(?:^|_)time|millis|micros|nanos|zeit(?:stempel)?|seconds_elapsed|date|"
    r"sample_?time_?fine|datenum|(?:time_)?hhmmss|(?:time_)?(?:unix|epoch)|elapsed|uptime|i?tow)"
)
_TIME = re.compile(rf"(?:.*[./])?{_TIME_WORD}(?:_?{_UNIT_OF_TIME})?")
_BY_LAST_WORD = re.compile(r"(?:.*_)?(datenum|hhmmss|excel|filetime|julian)(?:_(?:time|date))?")
_TIME_WITH_UNIT = re.compile(rf"(?:.*time_?stamp|.*time|t)_?({_UNIT_OF_TIME})|(millis|micros|nanos)")
_TIME_OF_DEVICE = re.compile(  # VectorNav, ROS, SensorLog, Shimmer, NovAtel
    r"time_?startup|(?:.*[_./])?header[_./]stamp|.*time_?stamp_?(?:since_?reboot|unix(?:_cal)?|sample)|g(?:ns|p)s_?time"
)
_AXIS = r"[xyz](?:_?axis)?"
_OPENS = re.compile(r"[\[({]")
_CAPITAL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[XYZ])(?=[A-Z][a-z])")  # GyroXDegPerSec
_BRACKET = re.compile(r"_?[\[(].*[\])]$")
_STEP_IN_BRACKETS = re.compile(r"([0-9.]+(?:e[+-]?[0-9]+)?)_?(.+)")  # as in [0.1 ms]
_HINT_ODDS = 30.0  # such words are seldom used for another unit
_HINTS: tuple[tuple[str, tuple[str, ...], float], ...] = (  # words, units that they leave, odds for these
    (r".*sample_?time_?fine", ("tick:1e-4",), LIE_ODDS),  # Xsens MTi counts 0.1 ms
    (r".*sample_?time_?fine", ("us",), LIE_ODDS / 3),  # Xsens DOT counts 1 us
    (r".*(?:^|_)i?tow", ("s", "ms"), _HINT_ODDS),  # GPS time of week, u-blox in ms
    (r".*ticks?", ("tick:1e-4",), _HINT_ODDS),
    (r".*(?:unix|epoch|posix).*", ("unix-s", "unix-ms", "unix-us", "unix-ns"), _HINT_ODDS),
)
_TEMPERATURE = re.compile(r"(?:.*[_./])?temp(?:erature?|eratur)?(?:_.*)?|t_?degc|t_?c")


@lru_cache(maxsize=1024)  # each name is asked for some twenty times
def split_unit(name: str) -> tuple[str, str]:
    """Return a column's name in lower case without its unit, and the unit in its brackets or behind its words."""
    name = _INDEX.sub(_axis_of_index, name)
    plain = re.sub(rf"_?[\[({{]({_AXIS})[\])}}]", r"_\1", _lower(name))  # acceleration (x)
    opens = [found.start() for found in _OPENS.finditer(plain)]
    brackets = [re.fullmatch(rf"(.{{{at}}}).(.*)[\])}}](_?{_AXIS})?", plain) for at in opens]
    if inside := [found for found in brackets if found]:
        found = next((each for each in inside if is_unit(each[2])), inside[0])
        return found[1].rstrip("_/,:") + (found[3] or ""), unit_named(found[2])
    if quotient := re.fullmatch(r"(.+?)_/_(.+)", plain):  # ISO 80000: a_x / g
        if (unit := unit_named(quotient[2])) in {*GYRO_UNITS, *ACCEL_UNITS, *TIME_UNITS}:
            return quotient[1], unit
    return _unit_behind(plain) or _unit_behind(_lower(_CAPITAL.sub("_", name)), is_quotient) or (plain, "")


def _unit_behind(plain: str, may_be: Callable[[str], bool] = bool) -> tuple[str, str] | None:
    """Return a name without the longest unit behind its words, or before its axis, and the unit; None of none."""
    words = re.split(r"[_,:]+", plain)
    axis = words.pop() if len(words) > 2 and words[-1] in AXES else ""
    for i in range(len(words)):
        unit = unit_behind_name("_".join(words[i:]))
        is_sensors = is_quotient(unit) or (unit in ACCEL_UNITS and len(unit) > 1)  # not g of imu_g_x
        if may_be(unit) and (is_sensors if axis or not i else True):
            return "_".join([*words[:i], *([axis] if axis else [])]), unit
    return None


def guessed_time(names: Sequence[str]) -> str | None:
    """Return the column that holds the time, None where none does by its name.

    Where none is called so, one that is called as a unit of time is, but ``min`` and ``h``.
    """
    named = (name for name in names if _is_time(split_unit(name)[0]))
    as_unit = (name for name in names if _bare_unit_of_time(name))
    return next(named, None) or next(as_unit, None)


def _is_time(plain: str) -> bool:
    return bool(_TIME.fullmatch(plain) or _TIME_OF_DEVICE.fullmatch(plain))


def _bare_unit_of_time(name: str) -> str:
    unit = unit_named(re.sub(r"[\[\]()]", "", name))
    return unit if unit in TIME_UNITS and unit not in NOT_BEHIND_A_NAME else ""


def time_unit_in_name(name: str) -> TimeUnit | None:
    """Return the unit of time that a column's name states, None where it states none."""
    plain = _lower(name)
    if bracket := re.fullmatch(r".*?_?[\[(](.*)[\])]", plain):
        if step := _STEP_IN_BRACKETS.fullmatch(bracket[1]):
            unit = unit_called(unit_named(step[2]))
            return unit_called(f"tick:{float(step[1]) * unit.seconds:.10g}") if unit else None
        return unit_called(unit_named(bracket[1].replace(":", "").replace("tick1e", "tick:1e")))
    if found := _TIME_WITH_UNIT.fullmatch(plain):
        return unit_called(unit_named(found[1] or found[2]))
    last = _BY_LAST_WORD.fullmatch(plain)
    return unit_called(last[1]) if last else unit_called(split_unit(name)[1] or _bare_unit_of_time(name))


def time_units_in_name(name: str) -> dict[TimeUnit, float]:
    """Return the units of time that a column's name states or hints at, with the odds for each."""
    if unit := time_unit_in_name(name):
        return {unit: LIE_ODDS}
    plain = _BRACKET.sub("", _lower(name))
    hinted = [(units, odds) for words, units, odds in _HINTS if re.fullmatch(words, plain)]
    return {BY_NAME[each]: odds for units, odds in hinted for each in units}


def guessed_temperature(names: Sequence[str]) -> str | None:
    """Return the column that holds a temperature, None where none does by its name."""
    named = (name for name in names if _TEMPERATURE.fullmatch(_BRACKET.sub("", _lower(name))))
    in_unit = (name for name in names if name.endswith(("]", ")")) and temperature_unit_in_name(name)[0])
    capital = (name for name in names if name.strip() == "T" and name != guessed_time(names))  # alongside t
    return next(named, None) or next(in_unit, None) or next(capital, None)


def guessed_utc(names: Sequence[str]) -> str | None:
    """Return the column that holds UTC alongside the log's own time, None where none does by its name."""
    return next((name for name in names if split_unit(name)[0] == "utc"), None)


def temperature_unit_in_name(name: str) -> tuple[str | None, str]:
    """Return the unit of temperature that a name says, None where it says none; and what its brackets hold."""
    plain = _lower(name)
    if bracket := re.fullmatch(r".*?_?[\[(](.*)[\])]", plain):
        return temperature_unit(bracket[1]), bracket[1]
    return temperature_unit(plain.rpartition("_")[2]) or (temperature_unit(plain[1:])), ""


def _lower(name: str) -> str:
    return re.sub(r"\s+", "_", name.strip().lower())


_ANGLE_UNITS = {
    "deg": 1.0, "degree": 1.0, "degrees": 1.0,
    "rad": 1 / RAD_PER_DEG, "radian": 1 / RAD_PER_DEG, "radians": 1 / RAD_PER_DEG,
    "mrad": 1e-3 / RAD_PER_DEG, "rev": 360.0, "revs": 360.0, "turns": 360.0, "revolutions": 360.0,
    "arcsec": 1 / 3600, "arcmin": 1 / 60,
}  # fmt: skip
_IN_UNIT = re.compile(rf"(?:.*[_\s(\[])?({'|'.join(_ANGLE_UNITS)})[)\]]?")
_ANGLE_WORDS = re.compile(r".*(?:angle|theta|phi|encoder|(?:^|_)enc|winkel|motor_?pos|position)(?:_.*|[\d(\[].*)?")
_RATES = {"rate", "rates", "vel", "velocity", "speed", "omega", "dot", "dt", "angvel", "angrate"}  # dot: thetaDot
_PARTS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+")  # between _, blanks and digits; of ThetaDot both words


def degrees_per_angle(name: str) -> float | None:
    """Return how many degrees a unit of a reference is by its name; None of a rate, as of what does not say."""
    plain = name.strip().lower()
    if split_unit(name)[1] in GYRO_UNITS or is_rate(name):
        return None
    if unit := _IN_UNIT.fullmatch(plain):
        return _ANGLE_UNITS[unit[1]]
    return 1.0 if _ANGLE_WORDS.fullmatch(plain) else None


def is_rate(name: str) -> bool:
    """Return whether a whole part of a name says that it is a rate, as in ``theta_dot``; not in ``integrated``."""
    return any(part.lower() in _RATES for part in _PARTS.findall(name))


_KINDS = {
    "gyro": re.compile(r"gyro(?:scope)?|angular_?(?:rate|velocity)|rotation_?rate", re.IGNORECASE),
    "accel": re.compile(r"accel(?:eration|erometer)?|specific_?force", re.IGNORECASE),
}
_MARK = "seconds_elapsed"  # a column of Sensor Logger
_SENSOR_LOGGER_UNITS = {"gyro": "rad/s", "accel": "m/s2"}
_NO_GRAVITY = re.compile(r"Accelerometer|.*(?:lin(?:ear)?|user)_?acc.*", re.IGNORECASE)


def bare_axes(names: Sequence[str], file: Path) -> tuple[str, tuple[str | None, ...], list[str]] | None:
    """Return the triad, ``gyro`` or ``accel``, whose x, y, z bare columns are, their names, and remarks.

    None where a column is missing, or the file's name says no sensor or several.
    """
    by_name = {name.strip().lower(): name for name in names}
    kinds = [kind for kind, words in _KINDS.items() if words.search(file.stem)]
    if len(kinds) != 1 or not all(axis in by_name for axis in AXES):
        return None
    text = [f"{','.join(by_name[axis] for axis in AXES)} are the {kinds[0]} x,y,z, by the name of the file"]
    if kinds[0] == "accel" and _MARK in by_name and _NO_GRAVITY.fullmatch(file.stem):
        text.append("Sensor Logger's Accelerometer has no gravity in it; TotalAcceleration.csv has")
    return kinds[0], tuple(by_name[axis] for axis in AXES), text


def unit_by_logger(
    names: Sequence[str], triad_names: Sequence[str | None], triad: str, guesses: list[str]
) -> str | None:
    """Return the unit of bare columns where the header shows which program wrote them, else None; adds a guess."""
    is_bare = [(name or "").strip().lower() for name in triad_names] == list(AXES)
    if not is_bare or _MARK not in (name.strip().lower() for name in names):
        return None
    guesses.append(f"{triad} in {_SENSOR_LOGGER_UNITS[triad]}, as Sensor Logger writes it")
    return _SENSOR_LOGGER_UNITS[triad]


_GYRO = (
    r"(?:(?:scaled|uncomp)?_?(?:gyroscope|gyros?|gyr)(?:_?adc|_rad)?|pqr|motion_?rotation_?rate|ang(?:ular)?_?(?:vel(?:ocity)?|rate|speed)|omega|gyro_?rotation|"
    r"(?:rotation|dreh|turn)?_?rate|w|g)"
)
_ACCEL = (
    r"(?:accelerometer|(?:scaled|uncomp)?_?accel(?:eration)?(?:_[lw][nr])?|accl|accelerometer_?acceleration|acc|"
    r"acc_?smooth|total_?acceleration|lin(?:ear)?_?acc(?:el(?:eration)?)?|"
    r"specific_?force|g_?force|g?f|a)"
)
_WORDS = MappingProxyType({"gyroscope": _GYRO, "accelerometer": _ACCEL})
_UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {"gyroscope": GYRO_UNITS, "accelerometer": ACCEL_UNITS}
)
_TURNS = MappingProxyType({"x": r"p|roll(?:_?rate)?", "y": r"q|pitch(?:_?rate)?", "z": r"r|yaw(?:_?rate)?"})
_OF_A_TABLE = r"ref|cmd|command|table|target|set_?point|enc|soll|input|applied|nominal"
_REFERENCE = re.compile(rf"(?!sampl)(?:.*_)?(?:(?:{_OF_A_TABLE})[a-z]*|rate)(?:_.*)?")
_NO_SENSOR = re.compile(rf"{_OF_A_TABLE}|true|gravity|heading|course")
_MAGNETIC = re.compile(r"(?:^|_)(?:mag|compass|field|[mbh]_?[xyz]$)")
_GRAVITY_REMOVED = re.compile(r"(?:lin(?:ear)?|user|free)_?acc")
_BARE = r"(?:.*_)?"
_FILLER_WORD = r"(?:raw|data|out|cal)"
_INDEX = re.compile(r"\[([0-2])\]")


def sensor_of_unit(name: str) -> str | None:
    """Return the kind of sensor that a column's unit decides, "" of another quantity; None of none."""
    unit = split_unit(name)[1]
    if unit in OTHER_QUANTITIES:
        return ""
    return next((triad for triad, known in _UNITS.items() if unit in known), None)


def guessed_triad(names: Sequence[str], triad: str) -> list[str | None]:
    """Return the columns of x, y, z of a ``triad``, gyroscope or accelerometer; None of one that is not there.

    Columns of a matrix are x, y, z in their order, where it has three.
    """
    word = _WORDS[triad]
    written = _written_out(names)
    names = sorted(names, key=lambda name: bool(_GRAVITY_REMOVED.search(_plain(name))))  # the last to be taken
    written = {name: written[name] for name in names}
    found = [_of_axis(written, triad, i) for i in range(len(AXES))]
    if any(found):
        return found
    matrix = re.compile(rf"((?:.*[_./])?{word}(?:_?raw)?):[0-9]+", re.IGNORECASE)
    bases = [match[1] for name in names if (match := matrix.fullmatch(name))]
    whole = next((base for base in bases if bases.count(base) == len(AXES)), None)
    return [None if whole is None else f"{whole}:{i + 1}" for i in range(len(AXES))]


def sensors_without_axis(names: Sequence[str], triad: str) -> list[str]:
    """Return the columns in a unit of a ``triad`` of which `guessed_triad` has found none.

    None where one of them is called a reference or a command, which may be in the unit of the others.
    """
    in_unit = [name for name in names if sensor_of_unit(name) == triad]
    others = any(words.search(_plain(name)) for name in in_unit for words in (_NO_SENSOR, _GRAVITY_REMOVED))
    return [] if others else in_unit


def guessed_reference(names: Sequence[str]) -> str | None:
    """Return the column that is called as the rate or angle of a turntable, None where none is."""
    plain = ((name, _plain(name)) for name in names)
    return next((name for name, called in plain if _REFERENCE.fullmatch(called)), None)


def unit_of_triad(names: Sequence[str], columns: Sequence[str | None], known: Mapping[str, float]) -> str | None:
    """Return the unit, one of ``known`` or raw, that the columns of a triad have in common; None of none."""
    written = _written_out(names)
    units = {split_unit(written[name])[1] for name in columns if name}
    return units.pop() if len(units) == 1 and units <= {*known, RAW} else None


def is_called_as_other(names: Sequence[str], columns: Sequence[str | None]) -> bool:
    """Return whether a column without a unit is called as one with a unit: a copy in counts, or another sensor."""
    decided = {_word(name) for name in names if sensor_of_unit(name)}
    return any(sensor_of_unit(name) is None and _word(name) in decided for name in columns if name)


def is_by_letter_g(name: str) -> bool:
    """Return whether only the letter g calls a column a gyroscope's: ``gx`` may be an acceleration in g too."""
    return any(_pattern("g", axis).fullmatch(_plain(name)) for axis in AXES)


def _of_axis(written: Mapping[str, str], triad: str, i: int) -> str | None:
    """Return the column whose unit and name say so, else its unit, else its name where its unit says nothing.

    A unit says enough of names that are no words of the sensor, as ``nx [g]``, where it has all three axes.
    """
    axis, own, any_word = AXES[i], _WORDS[triad], "|".join(_WORDS.values())
    called = _pattern(own, axis)
    bare = rf"|{_BARE}{axis}(?:_?axis)?"
    turns = rf"|{_BARE}(?:{_TURNS[axis]})" if triad == "gyroscope" else ""
    other = re.compile(rf"{_pattern(f'(?:{any_word})', axis).pattern}{bare}{turns}")
    places = {_place(_plain(full)) for full in written.values() if sensor_of_unit(full) == triad}
    by_rank: dict[int, str] = {}
    for name, full in written.items():
        base, kind = _plain(full), sensor_of_unit(full)
        family, at = _place(base)
        is_called = called.fullmatch(base) is not None
        is_whole = at == i and places.issuperset((family, k) for k in range(3))
        is_magnetic = not is_quotient(split_unit(full)[1]) and _MAGNETIC.search(base)  # mag_x (G)
        is_other = is_magnetic or _NO_SENSOR.search(base) or _GRAVITY_REMOVED.search(base)
        if kind == triad and is_called:
            rank = 0
        elif kind == triad and (is_whole or other.fullmatch(base)) and not is_other:
            rank = 1
        elif kind is None and is_called:
            rank = 2
        else:
            continue
        by_rank.setdefault(rank, name)
    return by_rank[min(by_rank)] if by_rank else None


def _pattern(word: str, axis: str) -> re.Pattern[str]:
    called = rf"{word}(?:_?{_FILLER_WORD})?_?(?:in_)?{axis}(?:_?axis)?|{axis}(?:_?axis)?_?{word}"
    return re.compile(rf"(?:.*_)?(?:{called})(?:_?{_FILLER_WORD})?")


def _plain(name: str) -> str:
    return re.sub(r"[-./_\s()\[\]]+", "_", split_unit(_INDEX.sub(_axis_of_index, name))[0]).strip("_")


def _word(name: str) -> str:
    """Return a name without what may stand alongside its word, as ``gx`` of ``gx_raw``."""
    return re.sub(rf"_{_FILLER_WORD}(?=_|$)", "", _plain(name))


def _axis_of_index(found: re.Match[str]) -> str:
    """Return the axis that an index 0, 1, 2 says, as Betaflight's ``gyroADC[0]`` and PX4's ``gyro_rad[0]``."""
    return f"_{AXES[int(found[1])]}"


_PLACES = tuple(
    (re.compile(rf"(.*?)({'|'.join(axes)}){behind}"), axes)
    for axes, behind in (
        (AXES, rf"((?:_?axis)?(?:_?{_FILLER_WORD})?)"), (("roll", "pitch", "yaw"), r"((?:_?rate)?)"),
        (("p", "q", "r"), "()"),
    )
)  # fmt: skip
_IN_FRONT = re.compile(r"()([xyz])(.+)")  # x_acc, xacc
_CONTINUED = re.compile(r"([yz])(?:_[0-9]+)?", re.IGNORECASE)  # numbered where several are called so


def _place(base: str) -> tuple[str, int | None]:
    """Return what the columns of a triad have in common of a name, and which axis it is, None of none."""
    for pattern, axes in (*_PLACES, (_IN_FRONT, AXES)):
        if found := pattern.fullmatch(base):
            return f"{found[1]}{{{axes[0]}}}{found[3]}", axes.index(found[2])
    return base, None


def _written_out(names: Sequence[str]) -> dict[str, str]:
    """Return each name as it is where word and unit stand in every name of a triad: once is enough for people.

    ``ny`` next to ``nx [g]`` is ``ny [g]``; ``y`` behind ``ax [g]`` is ``ay [g]``. A name that stands there with a
    unit as well, as ``gx`` alongside ``gx (g)``, stays as it is.
    """
    bases = {name: _plain(name) for name in names}
    units: dict[str, set[str]] = {}
    for name in names:
        if unit := split_unit(name)[1]:
            units.setdefault(_place(bases[name])[0], set()).add(unit)
    stated = {bases[name] for name in names if split_unit(name)[1]}
    found = dict(zip(names, names, strict=True))
    for i, name in enumerate(names):
        if split_unit(name)[1]:
            continue
        its = units.get(_place(bases[name])[0], set())
        if len(its) == 1 and bases[name] not in stated:
            found[name] = f"{name} [{next(iter(its))}]"
        elif (follows := _CONTINUED.fullmatch(name.strip())) and i:
            k = AXES.index(follows[1].lower())
            family, at = _place(bases[names[i - k]]) if i >= k else ("", None)
            full = family.replace("{x}", follows[1].lower())
            if at == 0 and (unit := split_unit(names[i - k])[1]) and full not in stated:
                found[name] = f"{full} [{unit}]"
    return found
