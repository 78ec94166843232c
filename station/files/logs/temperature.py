"""Which column of a log is a temperature, and in which unit; cells beyond any temperature are empty ones.

A unit is stated by an option or by the name of the column. Without either only degC is read, where the size of the
values is that of an instrument in degC; kelvins and tenths of degC are alike by their size, so they are asked for.
"""

from collections.abc import Callable, Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.logs.header_guesses import guessed_temperature, temperature_unit_in_name
from station.files.output_units import DEGC, PLAUSIBLE_C, TemperatureUnit, temperature_unit
from station.files.tables.table import Table

USUAL_C = (-60.0, 150.0)  # degC: instruments work there, so values within it may be in degC
USUAL_SHARE = 0.95  # of the plausible cells, that must be within it: a spike or two decide nothing
MOST = 0.5  # share of the cells beyond `PLAUSIBLE_C` from which a column is none of temperatures
OFFERED = ("K", "0.1degC", "0.01degC", "0.001degC", "degF")
MOST_OFFERED = 2
_OF_COUNTS = "0.0125degC+25"  # as of ADIS16495


def temperature_column(
    table: Table, stated: str | None, stated_unit: str | None, free: Sequence[str], guesses: list[str],
    column_of: Callable[[str], FloatArray] | None = None,
) -> tuple[str | None, TemperatureUnit]:  # fmt: skip
    """Return the column of temperature, None where there is none, and its unit.

    A guess among the columns ``free`` is added to ``guesses``. ``table`` may be the first rows alone; then
    ``column_of`` returns a whole column (n,). Raise `DataRefused` if the column that was stated is in an unknown
    unit, or few of its cells are temperatures.
    """
    name = guessed_temperature(free) if stated is None else table.name_of(stated) if stated else None
    if name is None:
        return None, DEGC
    if name in table.unreadable:
        row, text = table.unreadable[name]
        if stated is None:
            guesses.append(f"{name} holds text, as {text[:40]!a} in line {table.line(row)}: not used")
        return (None if stated is None else name), DEGC  # it is refused where it is read
    values = (column_of or table.column)(name)
    values = values[np.isfinite(values)]
    unit, bracket = temperature_unit_in_name(name)
    unit = temperature_unit(stated_unit) if stated_unit is not None else unit
    reason = "" if unit is not None else ", by its size (--unit-temperature states another)"
    if unit is None and not bracket and _is_usual(values):
        unit = DEGC
    if unit is None:
        why = f"in {bracket!a}" if bracket else _asked(values)
        _leave_out(table, name, stated, why, guesses)
        return None, DEGC
    beyond = values[np.isnan(unit.celsius(values))]
    limits = "{:g} to {:g} degC".format(*PLAUSIBLE_C)
    if len(beyond) > MOST * len(values):
        why = f"with most cells beyond {limits}, the first {beyond[0]:.6g}"
        _leave_out(table, name, stated, why, guesses)
        return None, DEGC
    if stated is None or unit != DEGC or reason:
        guesses.append(f"temperature is {name} [{unit.name}]{reason}")
    if len(beyond):
        guesses.append(f"{name}: {len(beyond)} of {len(values)} cells are beyond {limits}, the first "
                       f"{beyond[0]:.6g}: read as empty")  # fmt: skip
    return name, unit


def _is_usual(values: FloatArray) -> bool:
    """Return whether values (n,) that may be in degC are those of an instrument's temperature; so are none."""
    others = _without_sentinel(values)
    usual = (others >= USUAL_C[0]) & (others <= USUAL_C[1])
    return len(others) >= MOST * len(values) and usual.sum() >= USUAL_SHARE * len(others)


def _without_sentinel(values: FloatArray) -> FloatArray:
    """Return values (n,) without the most frequent of those that are no temperature in degC."""
    beyond, counts = np.unique(values[np.isnan(DEGC.celsius(values))], return_counts=True)
    return values[values != beyond[counts.argmax()]] if len(beyond) else values


def _asked(values: FloatArray) -> str:
    """Return in words that the unit is unknown, and what the usual values (n,) are in those that are possible."""
    others = _without_sentinel(values)
    low, high = np.percentile(others if len(others) else values, (1, 99), method="nearest")
    units = [unit for name in OFFERED if (unit := temperature_unit(name)) is not None]
    ranges = {unit.name: unit.celsius(np.array([low, high])) for unit in units}
    possible = [
        f"{name} ({a:.4g} to {b:.4g} degC)"
        for name, (a, b) in ranges.items() if USUAL_C[0] <= a and b <= USUAL_C[1]
    ]  # fmt: skip
    either = " or ".join([*possible[:MOST_OFFERED], f"counts (as {_OF_COUNTS})"])
    return f"from {low:g} to {high:g} in no stated unit, which may be {either}"


def _leave_out(table: Table, name: str, stated: str | None, why: str, guesses: list[str]) -> None:
    """Add to ``guesses`` that a column is not used; raise `DataRefused` where the user asked for it."""
    remedy = f"state --unit-temperature, or --aux {name} to take it as it is"
    if stated is not None:
        raise DataRefused(
            table.file, None, f"temperature {name} {why}", "degC, K, degF or a multiple", remedy, ErrorCode.UNIT
        )
    guesses.append(f"temperature {name} {why}: not used ({remedy})")
