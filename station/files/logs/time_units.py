"""The unit of a log's time: told, in its name, by the sample rate, by the magnitude of an epoch, by its steps."""

from datetime import UTC, datetime

import numpy as np

from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.files.logs.header_guesses import time_unit_in_name
from station.files.logs.log_table import LogTable
from station.files.output_units import TIME_UNITS, time_unit

EPOCH_S = (6.3e8, 4.1e9)  # seconds since 1970, of 1990 to 2100
MIN_STEP_S = 1e-5  # between samples of any unit
PLAIN_STEP_S = 0.3  # that can only be seconds: as milliseconds it is below any unit's
LONG_STEP_S = 1.0  # from which samples of an inertial sensor are rare
DAY_S, LONG_LOG_S = 86400.0, 31 * 86400.0
ASKED = ("ms", "us", "ns")


def unit_of_time(
    table: LogTable, time: str | None, told: str | None, rate_hz: float | None, guesses: list[str]
) -> str:
    """Return the unit of a log's column ``time``; what nobody told is added to ``guesses`` in words.

    Raises
    ------
    DataRefused
        If no unit makes the steps plausible, or several do.
    """
    if time is None:
        return "s"
    if time in table.moments:
        guesses.append(f"time in s, of the moments in {time}")
        return "s"
    if told is not None:
        return time_unit(told)
    stamps = table.column(time)
    stamps = stamps[np.isfinite(stamps)]
    step = _usual_step(stamps)
    if (unit := time_unit_in_name(time)) or rate_hz is not None:
        by = "by its name" if unit else "by --rate"
        unit = unit or min(TIME_UNITS, key=lambda name: abs(np.log(step * TIME_UNITS[name] * (rate_hz or 1.0))))
    elif unit := _epoch(stamps, step):
        moment = datetime.fromtimestamp(float(np.median(stamps)) * TIME_UNITS[unit], UTC)
        by = f"since 1970, being {moment:%Y-%m-%d}"
    else:
        unit, by = _by_steps(table, time, stamps, step)
    if 0 < step * TIME_UNITS[unit] < MIN_STEP_S:
        found = f"{time} in {unit} with {step:.4g} from row to row"
        raise DataRefused(table.file, None, found, f"at least {MIN_STEP_S:g} s", "say --unit-time s, ms, us or ns")
    guesses.append(f"time in {unit}, {by}")
    return unit


def _usual_step(stamps: FloatArray) -> float:
    """Return the usual step from row to row; rows that share a stamp count with those beside them."""
    step = np.diff(stamps)
    rising = step > 0
    return float(np.median(step[rising]) * np.mean(rising)) if rising.any() else 1.0


def _epoch(stamps: FloatArray, step: float) -> str:
    """Return the unit in which stamps (n,) are a moment since 1970, of samples of a plausible step; "" of none."""
    middle = float(np.median(stamps)) if len(stamps) else 0.0
    for unit, second in TIME_UNITS.items():
        if EPOCH_S[0] < middle * second < EPOCH_S[1] and MIN_STEP_S < step * second <= LONG_STEP_S:
            return unit
    return ""


def _by_steps(table: LogTable, time: str, stamps: FloatArray, step: float) -> tuple[str, str]:
    span = step * len(stamps)
    if step < PLAIN_STEP_S or (step <= LONG_STEP_S and span <= DAY_S):
        return "s", f"{step:.3g} from row to row"
    other = next((unit for unit in ASKED if step * TIME_UNITS[unit] <= LONG_STEP_S), ASKED[-1])
    if span > LONG_LOG_S:
        return other, f"{step:.3g} from row to row"
    rate = 1 / (step * TIME_UNITS[other])
    raise DataRefused(
        table.file, None, f"{time} with {step:.4g} from row to row and no unit",
        f"--unit-time {other} ({rate:.4g} samples a second) or --unit-time s", "say which",
    )  # fmt: skip
