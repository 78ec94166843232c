"""What a live attitude is: the newest reading, what each filter reads, the errors at rest.

Angles in deg, rates in deg/s, body axes forward-right-down.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from procedures.attitude.attitude_log import inclination

MotionState = Literal["waiting", "aligning", "at rest", "moving"]


@dataclass(frozen=True, slots=True)
class AttitudeReading:
    """The newest attitude, absolute: a zero changes nothing here.

    ``sigma`` is of the vertical's direction, nan where the filter has none; ``residual`` the angle between the
    specific force and the vertical;
    ``bias`` what the filter has learnt of the gyros [deg/h]; ``sample`` its last sample's number.
    """

    t: float
    roll: float
    pitch: float
    sigma: float
    rate: tuple[float, float, float]
    bias: tuple[float, float, float]
    residual: float
    mode: MotionState
    heading: float | None = None  # true, where given or learnt
    speed: float | None = None  # of the aid [m/s]
    temperature: float | None = None  # degC
    sample: int = 0


@dataclass(frozen=True, slots=True)
class RestErrors:
    """How far a unit at rest is off, by one way of reading it: ``level`` [deg], ``drift`` [deg/h], ``g`` [mg]."""

    level: float
    drift: float
    g: float


@dataclass(frozen=True, slots=True)
class RestErrorComparison:
    """Errors with and without the calibration over ``seconds`` of rest; ``earth``: is its rate subtracted."""

    seconds: float
    calibrated: RestErrors
    nominal: RestErrors
    earth: str


class SettlesAt(NamedTuple):
    """By how much roll and pitch will read too much if the motion continues: You and Lee (8).

    A sigma is nan where it is not known.
    """

    roll: float
    pitch: float
    roll_std: float
    pitch_std: float


@dataclass(frozen=True, slots=True)
class FilterReading:
    """What one filter reads: absolute angles, what it learnt of the gyros [deg/h], where it will settle.

    ``down`` is the unit vector of gravity; ``form`` says how it takes the velocity; ``note`` what is against it.
    """

    name: str
    form: str
    roll: float
    pitch: float
    down: tuple[float, float, float]
    bias: tuple[float, float, float]
    settles: SettlesAt | None = None
    note: str = ""


class FilterDifference(NamedTuple):
    """The second filter less the first: roll, pitch, and the angle between their verticals [deg]."""

    roll: float
    pitch: float
    angle: float


def difference(filters: Sequence[FilterReading]) -> FilterDifference | None:
    """Return how two filters differ; None where there are not two."""
    if len(filters) < 2:
        return None
    first, second = filters[:2]
    angle = np.degrees(inclination(np.array(first.down), np.array(second.down)))
    return FilterDifference((second.roll - first.roll + 180) % 360 - 180, second.pitch - first.pitch, float(angle))
