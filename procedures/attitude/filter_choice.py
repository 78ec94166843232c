"""Attitude filters that a live unit can be read by, how each takes the given velocity, and the gains.

Equation numbers are those of You and Lee.
"""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Gains:
    """K1 [1/s] pulls the attitude towards the accelerometer's, K2 [1/s] learns the gyro bias from the rest.

    The loop is ``s^2 + K1 s + K1 K2`` (You and Lee eq. 1): natural frequency ``sqrt(K1 K2)``, damping
    ``sqrt(K1 / K2) / 2``.
    """

    k1: float
    k2: float

    def __post_init__(self) -> None:
        if not (self.k1 > 0 and self.k2 >= 0):
            raise ValueError(f"gains are K1 = {self.k1:g}, K2 = {self.k2:g}, expected K1 > 0 and K2 >= 0")

    @classmethod
    def of_time_constant(cls, tau: float) -> "Gains":
        """Return the critically damped gains of a time constant [s]: You and Lee eq. 15."""
        if not tau > 0:
            raise ValueError(f"the time constant is {tau:g} s, expected more than 0")
        return cls(2 / tau, 1 / (2 * tau))


PAPER_GAINS = Gains(0.08, 0.0125)  # You and Lee, section 4: printed next to (15), but not of its form


JOINT = "joint"
# by filter and by aid: the aid of `procedures.attitude.complementary_filter`
FORMS = {
    "mixer": {"none": "none", "gnss": "airspeed", "airspeed-filter": "airspeed"},
    "paper": {"none": "paper-airspeed", "gnss": "paper-airspeed", "airspeed-filter": "paper-airspeed"},
    "paper-filter": {"gnss": "paper-filter", "airspeed-filter": "paper-filter"},
    "paper-whole": {"gnss": "paper-gnss", "airspeed-filter": "paper-airspeed-rate"},
}
LIVE_FILTERS = (JOINT, *FORMS)
MAX_LIVE_FILTERS = 2  # that stand side by side
FORM_DESCRIPTIONS = {
    "none": "no velocity", "airspeed": "forward speed, angle of attack", "paper-airspeed": "forward speed (10)",
    "paper-filter": "velocity filter (11)-(14)", "paper-airspeed-rate": "speed and its change (9)",
    "paper-gnss": "velocity and its change (9)",
}  # fmt: skip


def parse_filters(text: str) -> tuple[str, ...]:
    """Read one filter, or two with a comma between; raise ValueError where they are none."""
    filters = tuple(part.strip() for part in text.split(",")) if text else (JOINT,)
    if unknown := [name for name in filters if name not in LIVE_FILTERS]:
        names = f"{', '.join(LIVE_FILTERS)}, or two of them"
        raise ValueError(f"found {unknown[0]!r}, expected one of {names}")
    if len(set(filters)) < len(filters) or len(filters) > MAX_LIVE_FILTERS:
        raise ValueError(f"found {text!r}, expected one law, or two different ones: joint,paper")
    return filters


def refuse_without_velocity(filters: Sequence[str], aid: str) -> None:
    """Raise ValueError for a filter that cannot work by an aid."""
    for name in filters:
        if name != JOINT and aid not in FORMS[name]:
            raise ValueError(
                f"law {name} needs a velocity, found aid {aid}, expected gnss or airspeed: give --gnss URL, or "
                f"use the law paper or mixer"
            )
