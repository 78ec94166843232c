"""What a log's header says of its columns: time, temperature, angles, and the unit in a name.

A guess is made for what nobody stated, and is always shown. Names are compared in lower case, without blanks.
"""

import re
from collections.abc import Callable, Sequence
from functools import lru_cache

from procedures.counts.time_decision import LIE_ODDS
from procedures.counts.time_unit import BY_NAME, TimeUnit, unit_called
from procedures.frames import AXES
from procedures.units import RAD_PER_DEG
from station.files.output_units import (
    ACCEL_UNITS,
    GYRO_UNITS,
    NOT_BEHIND_A_NAME,
    TIME_UNITS,
    TemperatureUnit,
    is_quotient,
    is_unit,
    temperature_unit,
    unit_behind_name,
    unit_named,
)

_UNIT_OF_TIME = r"(?:s|ms|us|µs|ns|min|h|sec|seconds|usec|msec|nsec|minutes|hours|days?)"  # noqa: RUF001
_TIME_WORD = (
    r"(?:t|time|.*time_?stamp|.*(?:^|_)time|millis|micros|nanos|zeit(?:stempel)?|seconds_elapsed|date|"
    r"sample_?time_?fine|datenum|(?:time_)?hhmmss|(?:time_)?(?:unix|epoch)|elapsed|uptime|x_value|(?:gps_?)?(?:i?tow|sow))"
)
_TIME = re.compile(rf"(?:.*[./])?{_TIME_WORD}(?:_?{_UNIT_OF_TIME})?")
_BY_LAST_WORD = re.compile(r"(?:.*_)?(datenum|hhmmss|excel|filetime|julian)(?:_(?:time|date))?")
_TIME_WITH_UNIT = re.compile(rf"(?:.*time_?stamp|.*time|t)_?({_UNIT_OF_TIME})|(millis|micros|nanos)")
_TIME_OF_DEVICE = re.compile(  # VectorNav, ROS, SensorLog, Shimmer, NovAtel
    r"time_?startup|(?:.*[_./])?header[_./]stamp|.*time_?stamp_?(?:since_?reboot|unix(?:_cal)?|sample)|g(?:ns|p)s_?time"
)
_AXIS = r"[xyz](?:_?axis)?"
_OPENS = re.compile(r"[\[({]")
_TAKES_G = re.compile(r"(?:.*[./:_])?(?:\w*acc\w*|force)|(?:.*[./:])?[af]")
CAPITAL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[XYZ])(?=[A-Z][a-z])")  # GyroXDegPerSec
_INDEX = re.compile(r"\[([0-2])\]")
_BRACKET = re.compile(r"_?[\[(].*[\])]$")
_STEP_IN_BRACKETS = re.compile(r"([0-9.]+(?:e[+-]?[0-9]+)?)_?(.+)")  # as in [0.1 ms]
_HINT_ODDS = 30.0  # such words are seldom used for another unit
_HINTS: tuple[tuple[str, tuple[str, ...], float], ...] = (  # words, units that they leave, odds for these
    (r".*sample_?time_?fine", ("tick:1e-4",), LIE_ODDS),  # Xsens MTi counts 0.1 ms
    (r".*sample_?time_?fine", ("us",), LIE_ODDS / 3),  # Xsens DOT counts 1 us
    (r".*(?:^|_)(?:i?tow|sow)", ("s", "ms"), _HINT_ODDS),  # GPS time of week, u-blox in ms
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
    return _unit_behind(plain) or _unit_behind(_lower(CAPITAL.sub("_", name)), is_quotient) or (plain, "")


def _unit_behind(plain: str, may_be: Callable[[str], bool] = bool) -> tuple[str, str] | None:
    """Return a name without the longest unit behind its words, or before its axis, and the unit; None of none."""
    words = re.split(r"[_,:]+", plain)
    axis = words.pop() if len(words) > 2 and words[-1] in AXES else ""
    for i in range(len(words)):
        unit = unit_behind_name("_".join(words[i:]))
        is_force = unit in ACCEL_UNITS and (len(unit) > 1 or _TAKES_G.fullmatch("_".join(words[:i])))
        is_sensors = is_quotient(unit) or is_force  # not g of imu_g_x, but of acc_g_x
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


def temperature_unit_in_name(name: str) -> tuple[TemperatureUnit | None, str]:
    """Return the unit of temperature that a name says, None where it says none; and what its brackets hold."""
    plain = _lower(name)
    if bracket := re.fullmatch(r".*?_?[\[(](.*)[\])]", plain):
        return temperature_unit(bracket[1]), bracket[1]
    words = plain.rpartition("_")[2], plain[1:]
    return next((unit for each in words if each.isalpha() and (unit := temperature_unit(each))), None), ""


def _lower(name: str) -> str:
    return re.sub(r"\s+", "_", name.strip().lower())


def _axis_of_index(found: re.Match[str]) -> str:
    """Return the axis that an index 0, 1, 2 says, as Betaflight's ``gyroADC[0]`` and PX4's ``gyro_rad[0]``."""
    return f"_{AXES[int(found[1])]}"


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
