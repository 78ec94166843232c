"""Which columns are the gyroscopes and accelerometers x, y, z: by the unit that a name states, else by its words.

A unit of rate or acceleration decides the kind of sensor, whatever the letters before it: ``Gx (g)`` is an
accelerometer, ``ax [deg/s]`` a gyroscope. A unit of another quantity, as ``uT`` or ``deg``, is of neither.
"""

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from procedures.frames import AXES
from station.files.logs.header_guesses import split_unit
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, OTHER_QUANTITIES

_GYRO = (
    r"(?:(?:scaled|uncomp)?_?(?:gyroscope|gyros?|gyr)(?:_?adc|_rad)?|pqr|motion_?rotation_?rate|ang(?:ular)?_?(?:vel(?:ocity)?|rate|speed)|omega|gyro_?rotation|"
    r"(?:rotation|dreh|turn)?_?rate|w|g)"
)
_ACCEL = (
    r"(?:accelerometer|(?:scaled|uncomp)?_?accel(?:eration)?(?:_[lw][nr])?|accl|accelerometer_?acceleration|acc|"
    r"accel(?:erometer)?_m_s2|acc_?smooth|total_?acceleration|lin(?:ear)?_?acc(?:el(?:eration)?)?|"
    r"specific_?force|g_?force|g?f|a)"
)
_WORDS = MappingProxyType({"gyroscope": _GYRO, "accelerometer": _ACCEL})
_UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {"gyroscope": GYRO_UNITS, "accelerometer": ACCEL_UNITS}
)
_TURNS = MappingProxyType({"x": r"p|roll(?:_?rate)?", "y": r"q|pitch(?:_?rate)?", "z": r"r|yaw(?:_?rate)?"})
_SINGLE_GYRO = re.compile(rf"(?:.*[_./-])?(?:fog|rlg|{_GYRO})(?:_?raw)?")
_NO_SENSOR = re.compile(r"ref|cmd|command|table|target|set_?point|true|enc")
_MAGNETIC = re.compile(r"(?:^|_)(?:mag|compass|field|[mbh]_?[xyz]$)")
_GRAVITY_REMOVED = re.compile(r"(?:^|_)(?:lin(?:ear)?|user|free)_?acc")
_BARE = r"(?:.*_)?"
_BESIDE_A_WORD = r"(?:raw|data|out|cal)"
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
    names = sorted(names, key=lambda name: bool(_GRAVITY_REMOVED.search(_plain(name))))  # the last to be taken
    kinds = _kinds(names)
    found = [_of_axis(kinds, triad, axis) for axis in AXES]
    if any(found):
        return found
    matrix = re.compile(rf"((?:.*[_./])?{word}(?:_?raw)?):[0-9]+", re.IGNORECASE)
    bases = [match[1] for name in names if (match := matrix.fullmatch(name))]
    whole = next((base for base in bases if bases.count(base) == len(AXES)), None)
    return [None if whole is None else f"{whole}:{i + 1}" for i in range(len(AXES))]


def guessed_single_gyro(names: Sequence[str]) -> str | None:
    """Return the column of the only gyroscope: the only one in its unit, and called so; None of another.

    It is of no axis: `guessed_triad` has found none. What is called a reference or a command is none.
    """
    in_unit = [name for name in names if split_unit(name)[1] in GYRO_UNITS]
    only = split_unit(in_unit[0])[0] if len(in_unit) == 1 else ""
    return in_unit[0] if _SINGLE_GYRO.fullmatch(only) and not _NO_SENSOR.search(only) else None


def is_called_as_other(names: Sequence[str], columns: Sequence[str | None]) -> bool:
    """Return whether a column without a unit is called as one with a unit: a copy in counts, or another sensor."""
    decided = {_word(name) for name in names if sensor_of_unit(name)}
    return any(sensor_of_unit(name) is None and _word(name) in decided for name in columns if name)


def is_by_letter_g(name: str) -> bool:
    """Return whether only the letter g calls a column a gyroscope's: ``gx`` may be an acceleration in g too."""
    return any(_pattern("g", axis).fullmatch(_plain(name)) for axis in AXES)


def _of_axis(kinds: Mapping[str, str | None], triad: str, axis: str) -> str | None:
    """Return the column whose unit and name say so, else its unit, else its name where its unit says nothing."""
    own, any_word = _WORDS[triad], "|".join(_WORDS.values())
    called = _pattern(own, axis)
    bare = rf"|{_BARE}{axis}(?:_?axis)?"
    turns = rf"|{_BARE}(?:{_TURNS[axis]})" if triad == "gyroscope" else ""
    other = re.compile(rf"{_pattern(f'(?:{any_word})', axis).pattern}{bare}{turns}")
    by_rank: dict[int, str] = {}
    for name, kind in kinds.items():
        base = _plain(name)
        is_called = called.fullmatch(base) is not None
        if kind == triad and is_called:
            rank = 0
        elif (
            kind == triad and other.fullmatch(base) and not _MAGNETIC.search(base) and not _NO_SENSOR.search(base)
        ):
            rank = 1
        elif kind is None and is_called:
            rank = 2
        else:
            continue
        by_rank.setdefault(rank, name)
    return by_rank[min(by_rank)] if by_rank else None


def _pattern(word: str, axis: str) -> re.Pattern[str]:
    called = rf"{word}(?:_?{_BESIDE_A_WORD})?_?(?:in_)?{axis}(?:_?axis)?|{axis}(?:_?axis)?_?{word}"
    return re.compile(rf"(?:.*_)?(?:{called})(?:_?{_BESIDE_A_WORD})?")


def _plain(name: str) -> str:
    return re.sub(r"[-./_\s()\[\]]+", "_", split_unit(_INDEX.sub(_axis_of_index, name))[0]).strip("_")


def _word(name: str) -> str:
    """Return a name without what may stand alongside its word, as ``gx`` of ``gx_raw``."""
    return re.sub(rf"_{_BESIDE_A_WORD}(?=_|$)", "", _plain(name))


def _axis_of_index(found: re.Match[str]) -> str:
    """Return the axis that an index 0, 1, 2 says, as Betaflight's ``gyroADC[0]`` and PX4's ``gyro_rad[0]``."""
    return f"_{AXES[int(found[1])]}"


def _family(base: str) -> str:
    """Return a name without its axis: columns of one triad have it in common."""
    return re.sub(r"[xyz](?=_?(?:axis|raw|data)?$)", "", base)


def _kinds(names: Sequence[str]) -> dict[str, str | None]:
    """Return the kind of each column that its unit decides, or the units of others of its family.

    Of a column that is called as one with a unit, as ``gx`` alongside ``gx (g)``, nothing is decided: None.
    """
    kinds = {name: sensor_of_unit(name) for name in names}
    decided = {_plain(name) for name, kind in kinds.items() if kind is not None}
    families: dict[str, set[str]] = {}
    for name, kind in kinds.items():
        if kind is not None:
            families.setdefault(_family(_plain(name)), set()).add(kind)
    found = dict[str, str | None]()
    for name, kind in kinds.items():
        its = families.get(_family(_plain(name)), set[str]())
        inherits = kind is None and len(its) == 1 and _plain(name) not in decided
        found[name] = next(iter(its)) if inherits else kind
    return found
