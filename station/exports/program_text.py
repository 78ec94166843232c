"""What programs in any language share: names, terms with their coefficients, inputs, the comment at the top."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

from procedures.effects.term.grammar import names
from procedures.units import RAD_PER_DEG, STANDARD_GRAVITY
from station.calibrated.applied_effects import AppliedEffect
from station.exports.c_and_matlab_expressions import Expressions
from station.exports.exported_calibration import NotExported, StoredCalibration
from station.exports.known_samples import Rounds

SHORT = {"accelerometer": ("accel", "f", "g", "count/(g s)"), "gyroscope": ("gyro", "omega", "deg/s", "count/deg")}
OUTPUTS = {"accelerometer": ("force_m_s2", STANDARD_GRAVITY), "gyroscope": ("rate_rad_s", RAD_PER_DEG)}


@dataclass(frozen=True, slots=True)
class NamedInput:
    """What the user of a program sets: a member of its state, how many numbers it has, and what it means."""

    variable: str
    size: int
    meaning: str


def tables_of(effects: Sequence[AppliedEffect]) -> list[str]:
    """Return a name for each effect's coefficients; MATLAB takes 63 characters."""
    return [f"effect_{number}_{one.name.replace('.', '_')}"[:60] for number, one in enumerate(effects)]


def terms_of(
    effects: Sequence[AppliedEffect], triad: str, write: Expressions, coefficient: str, times: str
) -> list[str]:
    """Return what is added to a triad's output: products of a coefficient and its term.

    ``coefficient`` has {table} and {column}, from zero, ``times`` multiplies.
    """
    found = list[str]()
    for one, table in zip(effects, tables_of(effects), strict=True):
        for column, term in enumerate(one.terms if one.triad == triad else ()):
            c, text = coefficient.format(table=table, column=column, next=column + 1), write.of(term, triad)
            inside = any(each.name == "c" for each in names(term))
            found.append(re.sub(r"\bc\b", c, text) if inside else f"{c} {times} {text}")
    return found


def lags_of(effects: Sequence[AppliedEffect]) -> list[float]:
    """Return the time constants [s] by which effects follow the temperature, each once."""
    return list(dict.fromkeys(tau for one in effects for tau in one.lags))


def inputs_of(effects: Sequence[AppliedEffect]) -> list[NamedInput]:
    """Return what has to be set in addition to the sample."""
    named = sorted({name for one in effects for name in one.inputs})
    magnetic = any(name == "B" or name.startswith("B_") for name in named)
    found = [NamedInput("magnetic_ut", 3, "the field in the IMU's axes [uT]")] if magnetic else []
    return found + [NamedInput(name, 1, "in the channel's unit") for name in named if name.startswith("aux_")]


def about(
    stored: StoredCalibration,
    effects: Sequence[AppliedEffect],
    left: Sequence[NotExported],
    rounds: Rounds,
    digits: str,
) -> list[str]:
    """Return the lines of the comment at the top, fit for any language's."""
    lines = [*stored.origin, "", "Carried: scale factor, misalignment and bias of each triad"]
    lines += [f"  {name}" for name in dict.fromkeys(one.name for one in effects)]
    if effects:
        lines.append(f"Rounds: {rounds}")
    lines += ["NOT CARRIED: the uncertainties; see the calibration", *(f"NOT CARRIED: {one}" for one in left)]
    return [plain(line) for line in (*lines, f"Numbers: {digits}")]


@cache
def templates() -> Environment:
    """Return the templates of programs."""
    return Environment(
        loader=PackageLoader("station.exports"), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True, autoescape=False,
    )  # fmt: skip


def plain(text: str) -> str:
    """Return a line that ends no comment and begins none: of plain characters."""
    shown = "".join(each if each.isprintable() and each.isascii() else "_" for each in text)
    return shown.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").rstrip("\\")
