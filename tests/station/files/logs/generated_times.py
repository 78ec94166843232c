"""Logs as loggers write them, with the true unit of time: written without the code under test.

Rates are nominal ones of inertial sensors, most within an oscillator's tolerance; a tenth are arbitrary, as of a
free loop, but for ticks, which a sensor counts, and for minutes, hours and days of spreadsheets and data loggers.
"""

import datetime as dt
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "tick:1e-4": 1e-4, "min": 60.0, "h": 3600.0,
           "days": 86400.0,
           "unix-s": 1.0, "unix-ms": 1e-3, "unix-us": 1e-6, "unix-ns": 1e-9, "excel": 86400.0, "matlab": 86400.0,
           "hhmmss": 1.0, "iso8601": 1.0, "header": 0.0}  # fmt: skip
HEADERS = {
    "s": ("t [s]", "time_s", "Time (s)", "t_sec"), "ms": ("time_ms", "timestamp (ms)", "millis", "t [msec]"),
    "us": ("timestamp_us", "TimeUS", "t [us]", "micros"), "ns": ("time_ns", "timestamp [ns]", "t_nsec"),
    "tick:1e-4": ("SampleTimeFine", "t [0.1 ms]", "time [tick:1e-4]"), "min": ("time [min]", "time_min"),
    "h": ("time [h]", "time_hours"), "days": ("time [days]", "time (d)"),
    "unix-s": ("time_unix_s", "timestamp [s]"),
    "unix-ms": ("timestamp_ms", "epoch [ms]"), "unix-us": ("timestamp_us", "unix_us"),
    "unix-ns": ("timestamp_ns", "time [ns]"), "excel": ("time [days]", "excel_time"),
    "matlab": ("datenum", "time [d]"),
    "hhmmss": ("hhmmss", "time_hhmmss"), "iso8601": ("datetime_time", "time"), "header": ("t", "time"),
}  # fmt: skip
BARE = ("time", "t", "timestamp")
NOMINAL = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 25, 50, 100, 104, 125, 200, 208, 250, 256, 400, 416, 500, 512, 800, 833,
           1000, 1600, 1666, 2000, 3200, 4000, 6400, 8000)  # fmt: skip
DECIMALS = {"s": (3, 4, 6), "ms": (0, 0, 0, 3), "us": (0,), "ns": (0,), "tick:1e-4": (0,), "min": (7, 8, 9),
            "h": (8, 10), "days": (10, 12), "unix-s": (3, 6), "unix-ms": (0, 0, 3), "unix-us": (0,),
            "unix-ns": (0,), "excel": (10,), "matlab": (10,), "hhmmss": (2, 3), "iso8601": (6,),
            "header": (0,)}  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Stamps:
    """A time column as it stands in a file, its header, and the truth; ``scale_s`` stands above the table."""

    name: str
    stamps: FloatArray
    unit: str
    rate_hz: float
    has_header: bool
    decimals: int
    scale_s: float | None
    t: FloatArray


def generated(rng: np.random.Generator) -> Stamps:
    """Return one log's stamps: a unit, a rate, a header or none, an offset, jitter, dropouts, digits."""
    unit = str(rng.choice(list(SECONDS)))
    has_header = bool(rng.random() < 0.5)
    name = str(rng.choice(HEADERS[unit] if has_header else BARE))
    rate = float(rng.choice(NOMINAL)) * float(rng.choice([1.0, 1.0, 1 + 2e-4 * rng.standard_normal()]))
    if unit not in {"tick:1e-4", "min", "h", "days", "excel", "matlab"} and rng.random() < 0.1:
        rate = float(np.exp(rng.uniform(np.log(0.1), np.log(8000))))
    rows = int(rng.choice([300, 1000, 3000]))
    t = np.arange(rows) / rate
    jitter = float(rng.choice([0.0, 0.0, 0.002, 0.02, 0.1])) / rate
    t = np.sort(t + jitter * rng.standard_normal(rows).clip(-3, 3))
    if rng.random() < 0.2:
        t = t[rng.random(rows) > 0.01]
    if unit == "header":
        scale = float(rng.choice([1 / rate, 1e-3, 1e-6, 1e-4, 2.5e-3]))
        scale = min(scale, 0.5 / rate)
        return Stamps(name, np.round(t / scale), unit, rate, has_header, 0, scale, t)
    stamps, decimals = _printed(unit, t, rate, rng)
    return Stamps(name, stamps, unit, rate, has_header, decimals, None, t)


def _printed(unit: str, t: FloatArray, rate: float, rng: np.random.Generator) -> tuple[FloatArray, int]:
    second = SECONDS[unit]
    decimals = int(rng.choice(DECIMALS[unit]))
    is_counted = unit in {"us", "ns", "tick:1e-4", "unix-us", "unix-ns"}
    while (
        not is_counted and 10.0**-decimals * second > 0.3 / rate and decimals < 15
    ):  # whoever writes a log resolves its samples
        decimals += 1
    if unit.startswith("unix") or unit == "iso8601":
        stamps = rng.uniform(1.2e9, 1.9e9) / second + (t - t[0]) / second
    elif unit == "excel":
        stamps = rng.uniform(40000, 47000) + t / second
    elif unit == "matlab":
        stamps = rng.uniform(733000, 742000) + t / second
    elif unit == "hhmmss":
        began = dt.timedelta(seconds=float(rng.uniform(0, 80000)))
        stamps = np.array([_digits(began + dt.timedelta(seconds=float(each))) for each in t - t[0]])
    else:
        start = float(rng.choice([0.0, rng.uniform(0, 1000), 10 ** rng.uniform(0, 5)]))
        stamps = (start + t - t[0]) / second
    return np.round(stamps, decimals), decimals


def _digits(moment: dt.timedelta) -> float:
    seconds = moment.total_seconds() % 86400
    return float(f"{int(seconds // 3600):02d}{int(seconds % 3600 // 60):02d}{seconds % 60:012.9f}")


def sensors(kind: str, t: FloatArray, rng: np.random.Generator) -> dict[str, FloatArray]:
    """Return columns of a soak, of rests between rotations, or of motion: deg/s and m/s2, no units in names."""
    gyro = 0.02 * rng.standard_normal((len(t), 3))
    share = np.linspace(0, 1, len(t))
    if kind == "rests":
        gyro[:, 1] += 90.0 * (np.floor(20 * share) % 2)
    if kind == "motion":
        gyro += 30.0 * np.sin(2 * np.pi * 7 * share)[:, None] * np.array([1.0, 0.5, -0.3])
    angle = np.radians(np.cumsum(gyro[:, 1]) * (t[-1] - t[0]) / len(t))
    accel = 9.80665 * np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    accel += 0.01 * rng.standard_normal(accel.shape)
    return {f"{s}{a}": part[:, i] for s, part in (("g", gyro), ("a", accel)) for i, a in enumerate("xyz")}
