"""The temperature column of a log and its unit: told, in its name, or kelvin by its size."""

from collections.abc import Sequence

import numpy as np

from station.errors import DataRefused
from station.files.columns import PLAUSIBLE_C
from station.files.logs.header_guesses import guessed_temperature, temperature_unit_in_name
from station.files.logs.log_table import LogTable

_RANGE = f"{PLAUSIBLE_C[0]:g} to {PLAUSIBLE_C[1]:g} degC"
KELVINS = (200.0, 500.0)  # a temperature without a unit that lies there is none in degC
SHOWN = {"degc": "degC", "k": "K", "degf": "degF"}


def temperature_column(
    table: LogTable, told: str | None, free: Sequence[str], guesses: list[str]
) -> tuple[str | None, str]:
    """Return the column of temperature, None where there is none, and its unit (`TEMPERATURE_UNITS`).

    A guess among the columns ``free`` is added to ``guesses``.

    Raises
    ------
    DataRefused
        If the column that was told is in a unit that is none of a temperature, or holds what is none in degC.
    """
    name = guessed_temperature(free) if told is None else table.name_of(told) if told else None
    if name is None:
        return None, "degc"
    unit, bracket = temperature_unit_in_name(name)
    if unit is None and bracket:
        if told is not None:
            raise DataRefused(
                table.file,
                None,
                f"temperature {name} in {bracket!a}",
                "degC, K or degF",
                "name it by --aux instead",
            )
        guesses.append(f"{name} is no temperature in degC, K or degF: not used (--aux {name} takes it)")
        return None, "degc"
    if unit in {None, "degc"} and (far := _implausible(table, name)) is not None:
        if told is not None:
            raise DataRefused(
                table.file, None, f"{far:.6g} in temperature {name}", _RANGE, "name it by --aux instead"
            )
        guesses.append(f"{name} holds {far:.6g}, no temperature in degC: not used (--aux {name} takes it)")
        return None, "degc"
    if unit is None:
        unit = "k" if name not in table.unreadable and _is_kelvin(table, name) else "degc"
    if told is None or unit != "degc":
        guesses.append(f"temperature is {name} [{SHOWN[unit]}]")
    return name, unit


def _implausible(table: LogTable, name: str) -> float | None:
    """Return the first value that is neither a temperature in degC nor, as most of the others, one in K."""
    if name in table.unreadable or _is_kelvin(table, name):
        return None
    values = table.columns[name]
    bad = values[(values < PLAUSIBLE_C[0]) | (values > PLAUSIBLE_C[1])]
    return float(bad[0]) if len(bad) else None


def _is_kelvin(table: LogTable, name: str) -> bool:
    values = table.columns[name]
    known = values[np.isfinite(values)]
    return bool(len(known)) and KELVINS[0] < float(np.median(known.clip(-1e6, 1e6))) < KELVINS[1]
