"""Units of a time column: how many seconds one unit is, in which range stamps lie, how common each is."""

import math
import re
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.units import S_PER_H

DAY_S = 86400.0
EPOCH_S = (6.311e8, 4.103e9)  # s since 1970-01-01 at the beginning of 1990 and of 2100
_EPOCH_DAYS = (EPOCH_S[0] / DAY_S, EPOCH_S[1] / DAY_S)
CLOCK_END = 240000.0  # of hhmmss
RATIO_TOLERANCE = 0.05  # relative: units differ by more than six times
CHECKED = 2**14  # rows at a time: the digits of seconds contradict a clock within a minute
_TICK = re.compile(r"tick:([0-9.]+(?:e[+-]?[0-9]+)?)")
TICK_RANGE_S = (1e-12, 1e7)  # of a tick that can be stated


@dataclass(frozen=True, slots=True)
class TimeUnit:
    """A unit of time stamps.

    Parameters
    ----------
    name
        As ``--unit-time`` takes it.
    seconds
        How many seconds one unit is [s].
    prior
        How common the unit is among logs whose header does not name it, relative to the others.
    printed
        Shares of the logs in this unit whose stamps have no decimal, one to three, and more.
    dates
        Stamps of the beginning of 1990 and of 2100, where the unit counts from a date; None: from any moment.
    digits
        Decimal digits are read as a clock, ``hhmmss.sss`` or ``yyyymmddhhmmss``, and not as a number.
    """

    name: str
    seconds: float
    prior: float = 0.0
    printed: tuple[float, float, float] = (0.34, 0.33, 0.33)
    dates: tuple[float, float] | None = None
    digits: bool = False

    def linear(self, stamps: FloatArray) -> FloatArray:
        """Return stamps (n,) whose steps are proportional to time; multiply by `seconds` for [s]."""
        return clock_seconds(stamps) if self.digits else stamps


def _since(seconds: float, origin_s: float) -> tuple[float, float]:
    """Return the stamps of 1990 and 2100 in a unit of ``seconds`` that counts from ``origin_s`` since 1970."""
    return (EPOCH_S[0] - origin_s) / seconds, (EPOCH_S[1] - origin_s) / seconds


def _since_days(days: float) -> tuple[float, float]:
    return _EPOCH_DAYS[0] + days, _EPOCH_DAYS[1] + days


# The priors are rough shares among public IMU logs with a bare `time` or `timestamp`; a factor of 3 in any of them
# changes which logs are asked about, not which unit wins. Clocks of micro-controllers count whole ms, us or ticks.
_COUNTED, _SECONDS, _LONG = (0.97, 0.02, 0.01), (0.2, 0.4, 0.4), (0.02, 0.05, 0.93)
TIME_UNITS: tuple[TimeUnit, ...] = (
    TimeUnit("s", 1.0, 0.40, _SECONDS),
    TimeUnit("ms", 1e-3, 0.20, (0.8, 0.17, 0.03)),
    TimeUnit("us", 1e-6, 0.15, (0.9, 0.09, 0.01)),
    TimeUnit("ns", 1e-9, 0.05, _COUNTED),
    TimeUnit("tick:1e-4", 1e-4, 0.02, _COUNTED),  # Xsens MTi SampleTimeFine
    TimeUnit("min", 60.0, 0.004, _LONG),
    TimeUnit("h", S_PER_H, 0.004, _LONG),
    TimeUnit("days", DAY_S, 0.002, _LONG),
    TimeUnit("unix-s", 1.0, 0.04, _SECONDS, _since(1.0, 0.0)),
    TimeUnit("unix-ms", 1e-3, 0.04, (0.8, 0.17, 0.03), _since(1e-3, 0.0)),
    TimeUnit("unix-us", 1e-6, 0.04, _COUNTED, _since(1e-6, 0.0)),
    TimeUnit("unix-ns", 1e-9, 0.04, _COUNTED, _since(1e-9, 0.0)),
    TimeUnit("filetime", 1e-7, 0.001, _COUNTED, _since(1e-7, -11644473600.0)),  # 100 ns since 1601, Windows
    TimeUnit("dotnet", 1e-7, 0.001, _COUNTED, _since(1e-7, -62135596800.0)),  # 100 ns since year 1
    TimeUnit("excel", DAY_S, 0.01, _LONG, _since_days(25569.0)),  # days since 1899-12-30
    TimeUnit("excel1904", DAY_S, 0.001, _LONG, _since_days(24107.0)),
    TimeUnit("matlab", DAY_S, 0.005, _LONG, _since_days(719529.0)),  # datenum
    TimeUnit("julian", DAY_S, 0.001, _LONG, _since_days(2440587.5)),
    TimeUnit("hhmmss", 1.0, 0.01, (0.3, 0.5, 0.2), (0.0, CLOCK_END), digits=True),
    TimeUnit("yyyymmddhhmmss", 1.0, 0.005, (0.3, 0.5, 0.2), (19900101e6, 21000101e6), digits=True),
)
BY_NAME = {unit.name: unit for unit in TIME_UNITS}
SECOND = BY_NAME["s"]
_ALIASES = {
    "gps": "s", "tow": "s", "iso8601": "s", "iso": "s", "d": "days", "day": "days", "datenum": "matlab",
    "serial": "excel", "spreadsheet": "excel", "tick": "tick:1e-4", "ticks": "tick:1e-4",
    "sampletimefine": "tick:1e-4", "clock": "hhmmss", "unix": "unix-s", "epoch": "unix-s", "posix": "unix-s",
}  # fmt: skip


def tick_of(seconds: float) -> TimeUnit:
    """Return the unit that is so many seconds [s] and counts from any moment."""
    return TimeUnit(f"tick:{seconds:.10g}", seconds)


def unit_called(name: str) -> TimeUnit | None:
    """Return the unit of a name as `TIME_UNITS` has it, an alias of it, or ``tick:1e-4``; None of another."""
    plain = name.strip().lower().replace("_", "-")
    plain = re.sub(r"^(?:epoch|posix)-", "unix-", plain)
    if found := BY_NAME.get(_ALIASES.get(plain, plain)):
        return found
    if (match := _TICK.fullmatch(plain)) and TICK_RANGE_S[0] <= (seconds := _number(match[1])) <= TICK_RANGE_S[1]:
        return tick_of(seconds)
    return None


def unit_by_ratio(ratio: float) -> TimeUnit | None:
    """Return the unit, other than s, in which a time of seconds is ``ratio`` times as large; None of no unit."""
    elapsed = (unit for unit in TIME_UNITS if unit.dates is None and unit is not SECOND)
    return next((unit for unit in elapsed if abs(math.log(ratio * unit.seconds)) < RATIO_TOLERANCE), None)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def is_clock(stamps: FloatArray) -> bool:
    """Say whether the decimal digits of all stamps (n,) can be ``hhmmss`` or ``yyyymmddhhmmss``."""
    return all(_is_clock(stamps[i : i + CHECKED]) for i in range(0, len(stamps), CHECKED))


def _is_clock(stamps: FloatArray) -> bool:
    day, seconds = np.floor(stamps / 1e6), np.mod(stamps, 1e6)
    if (stamps < 0).any() or (seconds >= CLOCK_END).any():
        return False
    month, monthday = np.floor(np.mod(day, 1e4) / 100), np.mod(day, 100)
    is_day = (month >= 1) & (month <= 12) & (monthday >= 1) & (monthday <= 31)
    of_a_minute = (np.mod(seconds, 1e4) <= 6000) & (np.mod(seconds, 100) <= 60)  # 59.998 is printed 60.00
    return bool(np.all(of_a_minute & ((day == 0) | is_day)))


def clock_seconds(stamps: FloatArray) -> FloatArray:
    """Return the time [s] of stamps (n,) of a clock, from midnight, or from 1970 where they have a date.

    Source: days from the civil date by counting years from March, so that February is last.
    """
    day, within = np.floor(stamps / 1e6), np.mod(stamps, 1e6)
    hours, minutes, seconds = np.floor(within / 1e4), np.floor(np.mod(within, 1e4) / 100), np.mod(within, 100)
    month = np.floor(np.mod(day, 1e4) / 100)
    year = np.floor(day / 1e4) - (month <= 2)
    of_year = np.floor((153 * np.mod(month + 9, 12) + 2) / 5) + np.mod(day, 100) - 1
    days = 365 * year + np.floor(year / 4) - np.floor(year / 100) + np.floor(year / 400) + of_year - 719468
    since: FloatArray = np.where(day > 0, days * DAY_S, 0.0) + hours * S_PER_H + minutes * 60 + seconds
    return since


def minute_jumps(stamps: FloatArray) -> int:
    """Return how often stamps (n,) go from the end of a minute to the beginning of the next by their digits."""
    step = np.diff(stamps)
    usual = float(np.median(step[step > 0])) if (step > 0).any() else 0.0
    jumps = [(step > skipped) & (step < skipped + 5 * usual) & (usual < 40.0) for skipped in (40.0, 4040.0)]
    return int(np.sum(jumps))
