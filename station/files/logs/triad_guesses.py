"""Which of a log's columns are gyroscopes and accelerometers x, y, z, by their units and words.

A unit of rate or acceleration in a name decides the kind of sensor, whatever the letters before it: ``Gx (g)`` is
an accelerometer, ``ax [deg/s]`` a gyroscope. A unit of another quantity, as ``uT`` or ``deg``, is of neither.
Without a unit words decide, and a single letter, as w or g, only where no word names another: ``acc_w_x`` is no
gyroscope. Columns of a matrix are named as single ones are.
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from procedures.frames import AXES
from station.files.logs.header_guesses import CAPITAL, split_unit
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, OTHER_QUANTITIES, RAW, is_quotient

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


_WORDS = MappingProxyType({
    "gyroscope": (
        r"(?:gyroscope|gyros?|gyr)(?:_?adc|_rad)?|pqr|motion_?rotation_?rate|ang(?:ular)?_?(?:vel(?:ocity)?|rate|speed)|omega|"
        r"gyro_?rotation|(?:rotation|dreh|turn)_?rate"
    ),
    "accelerometer": (
        r"accelerometer|accel(?:eration)?(?:_[lw][nr])?|accl|accelerometer_?acceleration|acc|acc_?smooth|"
        r"total_?acceleration|lin(?:ear)?_?acc(?:el(?:eration)?)?|specific_?force|g_?force"
    ),
})  # fmt: skip
_LETTERS = MappingProxyType({"gyroscope": r"rate|w|g", "accelerometer": r"g?f|a"})  # may be of other words, too
_LETTER_OF_FRAME = MappingProxyType({"gyroscope": r"[af](?=_[wg]_)", "accelerometer": r"[wg](?=_[af]_)"})  # a_w_x
_OTHER_WORDS = r"mag|compass|field|vel(?:ocity)?|pos(?:ition)?|grav(?:ity)?|quat|att(?:itude)?"
_UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {"gyroscope": GYRO_UNITS, "accelerometer": ACCEL_UNITS}
)
_TURNS = MappingProxyType({"x": r"p|roll(?:_?rate)?", "y": r"q|pitch(?:_?rate)?", "z": r"r|yaw(?:_?rate)?"})
_OF_A_TABLE = r"ref|cmd|command|table|target|set_?point|enc|soll|input|applied|nominal"
_REFERENCE = re.compile(rf"(?!sampl)(?:.*_)?(?:(?:{_OF_A_TABLE})[a-z]*|rate)(?:_.*)?")
_NO_SENSOR = re.compile(rf"{_OF_A_TABLE}|true|gravity|heading|course")
_MAGNETIC = re.compile(r"(?:^|_)(?:mag|compass|field|[mbh]_?[xyz]$)")
_GRAVITY_REMOVED = re.compile(r"(?:lin(?:ear)?|user|free)_?acc")
_NO_OUTPUT = re.compile(  # a filter's estimate, statistics, a derivative
    r"ang(?:ular)?_?acc|(?<!un)(?<!de)(?<!no)(?<!no_)(?:bias|offset)(?!.*(?:corr|remov|comp|free))|(?:^|_)std(?:dev)?(?:_|$)|sigma|covar|variance"
)
_BARE = r"(?:.*_)?"
_FILLER_WORD = r"(?:raw|data|out|cal)"


def sensor_of_unit(name: str) -> str | None:
    """Return the kind of sensor that a column's unit decides, "" of another quantity; None of none."""
    unit = split_unit(name)[1]
    if unit in OTHER_QUANTITIES:
        return ""
    return next((triad for triad, known in _UNITS.items() if unit in known), None)


def guessed_triad(names: Sequence[str], triad: str) -> list[str | None]:
    """Return the columns of x, y, z of a ``triad``, gyroscope or accelerometer; None of one that is not there.

    Single columns come before those of a matrix. Estimates, as of a bias, are no outputs.
    """
    written = _written_out(names)
    ordered = sorted((name for name in names if not _NO_OUTPUT.search(_plain(name))), key=_without_gravity)
    for is_matrix in (False, True):
        part = {name: written[name] for name in ordered if bool(_ELEMENT.fullmatch(name)) is is_matrix}
        found = [_of_axis(part, triad, i) for i in range(len(AXES))]
        if any(found):
            return found
    return [None] * len(AXES)


def _without_gravity(name: str) -> int:
    """Return an order in which accelerations with gravity come first, and those without it last."""
    plain = _plain(name)
    return 2 if _GRAVITY_REMOVED.search(plain) else 0 if "total" in plain else 1


def sensors_without_axis(names: Sequence[str], triad: str) -> list[str]:
    """Return the columns in a unit of a ``triad`` of which `guessed_triad` has found none.

    None where one of them is called a reference or a command, which may be in the unit of the others.
    """
    in_unit = [name for name in names if sensor_of_unit(name) == triad]
    in_unit = [name for name in in_unit if not _NO_OUTPUT.search(_plain(name))] or in_unit
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
    axis, any_word = AXES[i], "|".join((*_WORDS.values(), *_LETTERS.values()))
    bare = rf"|{_BARE}{axis}(?:_?axis)?"
    turns = rf"|{_BARE}(?:{_TURNS[axis]})" if triad == "gyroscope" else ""
    other = re.compile(rf"{_pattern(f'(?:{any_word})', axis).pattern}{bare}{turns}")
    places = {_place(_plain(full)) for full in written.values() if sensor_of_unit(full) == triad}
    by_rank: dict[int, str] = {}
    for name, full in written.items():
        base, kind = _plain(full), sensor_of_unit(full)
        family, at = _place(base)
        is_called = _is_called(full, triad, axis)
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


def _is_called(full: str, triad: str, axis: str) -> bool:
    """Return whether a name calls a column one of a triad: by a word, else by a letter next to no other word."""
    base, word = _plain(full), _pattern(f"(?:{_WORDS[triad]})", axis)
    if word.fullmatch(base):
        return True
    if word.fullmatch(_plain(CAPITAL.sub("_", full))):  # UncompAccX
        return not _GRAVITY_REMOVED.search(base)
    others = "|".join(
        (_OTHER_WORDS, _LETTER_OF_FRAME[triad], *(words for kind, words in _WORDS.items() if kind != triad))
    )
    is_other = re.search(rf"(?:^|_)(?:{others})(?:_|$)", base)
    return not is_other and _pattern(f"(?:{_LETTERS[triad]})", axis).fullmatch(base) is not None


def _pattern(word: str, axis: str) -> re.Pattern[str]:
    called = rf"{word}(?:_?{_FILLER_WORD})?_?(?:in_)?{axis}(?:_?axis)?|{axis}(?:_?axis)?_?{word}"
    return re.compile(rf"(?:.*_)?(?:{called})(?:_?{_FILLER_WORD})?")


def _plain(name: str) -> str:
    return re.sub(r"[-.:/_\s()\[\]]+", "_", split_unit(name)[0]).strip("_")


def _word(name: str) -> str:
    """Return a name without what may stand alongside its word, as ``gx`` of ``gx_raw``."""
    return re.sub(rf"_{_FILLER_WORD}(?=_|$)", "", _plain(name))


_PLACES = tuple(
    (re.compile(rf"(.*?)({'|'.join(axes)}){behind}"), axes)
    for axes, behind in (
        (AXES, rf"((?:_?axis)?(?:_?{_FILLER_WORD})?)"), (("roll", "pitch", "yaw"), r"((?:_?rate)?)"),
        (("p", "q", "r"), "()"),
    )
)  # fmt: skip
_IN_FRONT = re.compile(r"()([xyz])(.+)")  # x_acc, xacc
_ELEMENT = re.compile(r"(.+):([0-9]+)")  # of a matrix
_OF_MATRIX = ([1, 2, 3], [0, 1, 2])  # the columns of one of three
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
    unit as well, as ``gx`` alongside ``gx (g)``, stays as it is. The columns of a matrix of three are x, y, z:
    ``acc_g:1`` is ``acc_g_x``.
    """
    columns: dict[str, list[int]] = {}
    for name in names:
        if found := _ELEMENT.fullmatch(name):
            columns.setdefault(found[1], []).append(int(found[2]))
    spelled = list(names)
    for i, name in enumerate(names):
        if (found := _ELEMENT.fullmatch(name)) and sorted(columns[found[1]]) in _OF_MATRIX:
            spelled[i] = f"{found[1]}_{AXES[int(found[2]) - min(columns[found[1]])]}"
    return dict(zip(names, _with_units(spelled), strict=True))


def _with_units(names: Sequence[str]) -> list[str]:
    """Return ``names`` with word and unit in every name of a triad."""
    bases = {name: _plain(name) for name in names}
    units: dict[str, set[str]] = {}
    for name in names:
        if unit := split_unit(name)[1]:
            units.setdefault(_place(bases[name])[0], set()).add(unit)
    stated = {bases[name] for name in names if split_unit(name)[1]}
    found = list(names)
    for i, name in enumerate(names):
        if split_unit(name)[1]:
            continue
        its = units.get(_place(bases[name])[0], set())
        if len(its) == 1 and bases[name] not in stated:
            found[i] = f"{name} [{next(iter(its))}]"
        elif (follows := _CONTINUED.fullmatch(name.strip())) and i:
            k = AXES.index(follows[1].lower())
            family, at = _place(bases[names[i - k]]) if i >= k else ("", None)
            full = family.replace("{x}", follows[1].lower())
            if at == 0 and (unit := split_unit(names[i - k])[1]) and full not in stated:
                found[i] = f"{full} [{unit}]"
    return found
