"""Whether a reference is an angle, and in which unit, by its name."""

import re

from procedures.units import RAD_PER_DEG
from station.files.logs.header_guesses import split_unit
from station.files.output_units import GYRO_UNITS

_UNITS = {
    "deg": 1.0, "degree": 1.0, "degrees": 1.0,
    "rad": 1 / RAD_PER_DEG, "radian": 1 / RAD_PER_DEG, "radians": 1 / RAD_PER_DEG,
    "mrad": 1e-3 / RAD_PER_DEG, "rev": 360.0, "revs": 360.0, "turns": 360.0, "revolutions": 360.0,
    "arcsec": 1 / 3600, "arcmin": 1 / 60,
}  # fmt: skip
_IN_UNIT = re.compile(rf"(?:.*[_\s(\[])?({'|'.join(_UNITS)})[)\]]?")
_WORDS = re.compile(r".*(?:angle|theta|phi|encoder|(?:^|_)enc|winkel|motor_?pos|position)(?:_.*|[\d(\[].*)?")
_RATES = {"rate", "rates", "vel", "velocity", "speed", "omega", "dot", "dt", "angvel", "angrate"}  # dot: thetaDot
_PARTS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+")  # between _, blanks and digits; of ThetaDot both words


def degrees_per_angle(name: str) -> float | None:
    """Return how many degrees a unit of a reference is by its name; None of a rate, as of what does not say."""
    plain = name.strip().lower()
    if split_unit(name)[1] in GYRO_UNITS or is_rate(name):
        return None
    if unit := _IN_UNIT.fullmatch(plain):
        return _UNITS[unit[1]]
    return 1.0 if _WORDS.fullmatch(plain) else None


def is_rate(name: str) -> bool:
    """Say whether a whole part of a name says that it is a rate, as in ``theta_dot``; not in ``integrated``."""
    return any(part.lower() in _RATES for part in _PARTS.findall(name))
