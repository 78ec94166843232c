"""Units of a log's columns, as people spell them, and how many outputs they make of 1 deg/s, 1 g or 1 s."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.time_unit import BY_NAME, TimeUnit, unit_called
from procedures.units import DEG_H_PER_DEG_S, RAD_PER_DEG, STANDARD_GRAVITY, UG_PER_G

TIME_UNITS: Mapping[str, float] = MappingProxyType(
    {  # s, of units that need no date
        name: unit.seconds for name in ("s", "ms", "us", "ns", "min", "h", "days") if (unit := BY_NAME[name])
    }
)
GYRO_UNITS: Mapping[str, float] = MappingProxyType({  # outputs in 1 deg/s
    "deg/s": 1.0, "rad/s": RAD_PER_DEG, "deg/h": DEG_H_PER_DEG_S, "mdeg/s": 1e3, "mrad/s": 1e3 * RAD_PER_DEG,
})  # fmt: skip
ACCEL_UNITS: Mapping[str, float] = MappingProxyType({  # outputs in 1 g
    "m/s2": STANDARD_GRAVITY, "g": 1.0, "mg": 1e3, "ug": UG_PER_G, "cm/s2": 100 * STANDARD_GRAVITY,
})  # fmt: skip
RAW = "raw"
OTHER_QUANTITIES = frozenset({  # in brackets behind a name they say that it is no rate and no specific force
    "ut", "nt", "mt", "t", "tesla", "gauss", "mgauss", "ga", "mga", "oe", "deg", "rad", "mrad", "rev", "m", "mm",
    "cm", "km", "m/s", "km/h", "kmh", "mph", "kn", "knots", "pa", "hpa", "mbar", "m/s3", "%", "degc", "n", "nm",
})  # fmt: skip
SPELLED = {  # as headers and people write units
    "dps": "deg/s", "deg_s": "deg/s", "degps": "deg/s", "°/s": "deg/s", "deg/sec": "deg/s", "rad_s": "rad/s",
    "rads": "rad/s", "radps": "rad/s", "rad/sec": "rad/s", "deg_h": "deg/h", "dph": "deg/h", "°/h": "deg/h",
    "deg/hr": "deg/h", "deg_sec": "deg/s", "rad_sec": "rad/s", "deg_hr": "deg/h", "deg_hour": "deg/h",
    "mdps": "mdeg/s", "m_s2": "m/s2", "m_s_2": "m/s2", "m/s^2": "m/s2", "m/s/s": "m/s2", "m_s^2": "m/s2",
    "m/s²": "m/s2", "ms2": "m/s2", "mps2": "m/s2", "cm_s2": "cm/s2", "mdeg_s": "mdeg/s", "mrad_s": "mrad/s",
    "m_s": "m/s", "km_h": "km/h", "milli_g": "mg", "micro_g": "ug",
    "sec": "s", "seconds": "s", "µs": "us", "usec": "us",  # noqa: RUF001
    "msec": "ms", "nsec": "ns",
    "millis": "ms", "micros": "us", "nanos": "ns", "minutes": "min", "hours": "h", "day": "days",
    "milliseconds": "ms", "microseconds": "us", "nanoseconds": "ns",
    "lsb": RAW, "count": RAW, "counts": RAW, "adc": RAW,
}  # fmt: skip


_SPELLED_OUT = {  # in brackets or as an option: behind ``_`` they may be words
    "degrees": "deg", "degree": "deg", "radians": "rad", "radian": "rad", "°": "deg", "º": "deg", "mps": "m/s",
    "gee": "g", "gees": "g", "gs": "g", "g0": "g", "gn": "g", "gravity": "g", "g-force": "g", "gforce": "g",
    "milligee": "mg", "mgee": "mg", "gal": "cm/s2", "digit": RAW, "digits": RAW, "codes": RAW, "adu": RAW,
}  # fmt: skip
_WRITTEN = (  # parts of units of sensors, in the order in which they are replaced
    (r"_", ""), (r"[·*\u22c5]|(?<=[a-z])\.(?=[a-z])", ""),
    (r"[µμ]", "u"), (r"[°º]", "deg"), (r"²", "2"), (r"⁻", "-"), (r"¹", "1"),
    (r"per", "/"), (r"milli-?", "m"), (r"micro-?", "u"),
    (r"degrees?", "deg"), (r"radians?", "rad"), (r"met(?:er|re)s?", "m"),
    (r"seconds?|sec(?![a-z])", "s"), (r"hours?|hr", "h"), (r"squared", "2"), (r"\^", ""),
    (r"^(m?(?:deg|rad))(s|h)-1$", r"\1/\2"), (r"^(c?m)s-2$", r"\1/s2"), (r"^(c?m)/\(?s[*/]?[s2]\)?$", r"\1/s2"),
    (r"^m/ss$", "m/s2"), (r"^\((.*)\)$", r"\1"),
)  # fmt: skip
NOT_BEHIND_A_NAME = ("min", "h", "day", "days")  # temp_min is a minimum
_BEHIND_A_NAME = frozenset({*SPELLED, *GYRO_UNITS, *ACCEL_UNITS, *TIME_UNITS} - {*NOT_BEHIND_A_NAME})
_SENSOR_UNITS = frozenset({*GYRO_UNITS, *ACCEL_UNITS, *OTHER_QUANTITIES, RAW})

PLAUSIBLE_C = (-100.0, 400.0)  # degC: beyond it no IMU works; 0x7FFF in hundredths, a dead thermometer, is within


@dataclass(frozen=True, slots=True)
class TemperatureUnit:
    """A unit of temperature: degC are (value - ``zero``) * ``degrees``."""

    name: str
    zero: float
    degrees: float

    def celsius(self, values: FloatArray) -> FloatArray:
        """Return ``values`` (n,) in degC, nan where they are no temperature that an IMU can have."""
        found = (values - self.zero) * self.degrees
        return np.where((found >= PLAUSIBLE_C[0]) & (found <= PLAUSIBLE_C[1]), found, np.nan)


DEGC = TemperatureUnit("degC", 0.0, 1.0)
_KELVIN, _DEGF = TemperatureUnit("K", 273.15, 1.0), TemperatureUnit("degF", 32.0, 1 / 1.8)
_TEMPERATURES = {"c": DEGC, "celsius": DEGC, "k": _KELVIN, "kelvin": _KELVIN, "f": _DEGF, "fahrenheit": _DEGF}
_DEGREES = re.compile(r"^(?:°|º|deg(?:rees?)?)_?")  # degC, Degrees Celsius
_SCALED_TEMPERATURE = re.compile(  # 0.0125degC+25; 16k is none
    r"([0-9]*\.[0-9]+|[0-9]+e-[0-9]+)[*_]?([^0-9.+-]+)([+-][0-9]*\.?[0-9]+)?"
)


def temperature_unit(text: str) -> TemperatureUnit | None:
    """Return a unit of temperature, or a multiple and an offset of one as ``0.0125degC+25``; None of none."""
    plain = text.strip().lower().replace(" ", "")
    if (unit := _TEMPERATURES.get(_DEGREES.sub("", plain))) is not None:
        return unit
    scaled = _SCALED_TEMPERATURE.fullmatch(plain)
    unit = temperature_unit(scaled[2]) if scaled else None
    if scaled is None or unit is None or not (step := float(scaled[1])) > 0:
        return None
    name = f"{step:g}{unit.name}{scaled[3] or ''}"
    return TemperatureUnit(name, (unit.zero - float(scaled[3] or 0)) / step, unit.degrees * step)


def stated_temperature_unit(text: str) -> TemperatureUnit:
    """Return a unit of temperature; raise `ValueError` if it is none; says what is expected."""
    if (unit := temperature_unit(text)) is None:
        raise ValueError(
            f"found unit {text!a}, expected degC, K or degF, or a step and offset as in 0.1degC or 0.0125degC+25"
        )
    return unit


def is_unit(text: str) -> bool:
    """Return whether a text is a unit of time, rate, force, temperature or an output."""
    known = (*TIME_UNITS, *GYRO_UNITS, *ACCEL_UNITS, RAW)
    return unit_named(text) in known or temperature_unit(text) is not None


def unit_named(text: str) -> str:
    """Return a unit as this module spells it, the text itself where it is none that is known."""
    plain = text.strip().lower().replace(" ", "")
    if (known := SPELLED.get(plain) or _SPELLED_OUT.get(plain)) is not None:
        return known
    short = _composed(plain)
    return short if short in _SENSOR_UNITS else plain


def unit_behind_name(words: str) -> str:
    """Return the unit that words behind a name are, as ``deg_per_h``; empty where they may be of the name."""
    if words in _BEHIND_A_NAME:
        return unit_named(words)
    composed = _composed(words)
    return composed if is_quotient(composed) else ""


def is_quotient(unit: str) -> bool:
    """Return whether a unit is a known quotient, as deg/s, that no word or letter of a name is."""
    return "/" in unit and unit in _SENSOR_UNITS


def _composed(plain: str) -> str:
    for written, meant in _WRITTEN:
        plain = re.sub(written, meant, plain)
    return SPELLED.get(plain, plain)


def time_unit(text: str) -> TimeUnit:
    """Return a unit of time as people spell it; raise `ValueError` if it is none; says what is expected."""
    if (unit := unit_called(unit_named(text))) is None:
        raise ValueError(
            f"found unit {text!a}, expected one of {', '.join(BY_NAME)}, or tick:SECONDS as in tick:1e-4"
        )
    return unit


def outputs_per_unit(unit: str, known: Mapping[str, float]) -> float | None:
    """Return how many outputs 1 deg/s or 1 g is, None of ``raw``.

    ``unit`` is one of ``known``, or ``N/(deg/s)``, ``N/g``: so many outputs. Raise `ValueError` if it is none;
    says what is expected.
    """
    name = unit_named(unit)
    if name == RAW:
        return None
    if name in known:
        return known[name]
    number, _, per = name.partition("/")
    if (per := per.strip("()")) in known and re.fullmatch(r"[0-9]+(?:\.[0-9]*)?(?:e[+-]?[0-9]+)?", number):
        if (value := float(number)) > 0:
            return value * known[per]
    first = next(iter(known))
    raise ValueError(f"found unit {unit!a}, expected one of {', '.join(known)}, {RAW}, or N/({first})")
