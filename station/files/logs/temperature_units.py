"""The temperature column of a log and its unit: told, in its name, or kelvin by its size."""

from collections.abc import Sequence

import numpy as np

from station.errors import DataRefused
from station.files.logs.header_guesses import guessed_temperature, temperature_unit_in_name
from station.files.logs.log_table import LogTable

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
        If the column that was told is in a unit that is none of a temperature.
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
        guesses.append(f"{name} is no temperature in degC, K or degF: left out (--aux {name} takes it)")
        return None, "degc"
    if unit is None:
        unit = "k" if name not in table.unreadable and _is_kelvin(table, name) else "degc"
    if told is None or unit != "degc":
        guesses.append(f"temperature is {name} [{SHOWN[unit]}]")
    return name, unit


def _is_kelvin(table: LogTable, name: str) -> bool:
    values = table.columns[name]
    known = values[np.isfinite(values)]
    return bool(len(known)) and KELVINS[0] < float(np.median(known)) < KELVINS[1]
