"""Limits of an IMU model: what each parameter of a solution may be, and how a value is held against that.

Guarded acceptance (JCGM 106:2012, 8.3): the interval is narrowed at both ends by ``guard_band`` times the value's
own 1 sigma, so that a value accepted near a limit is unlikely to be beyond it.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.schema import ImuLimitRow
from procedures.frames import AXES

PAIRS = tuple(q + p for q in AXES for p in AXES if p != q)
_FACES = tuple(f"{pair}.{other}" for pair in AXES for other in AXES if other != pair)
_BIASES = ("bias", "bias_12_position", "bias_two_direction")

UNITS: dict[str, tuple[str, ...]] = {  # the units a solution prints, by parameter
    **{f"accelerometer.scale_factor.{axis}": ("count/(g s)", "output/g") for axis in AXES},
    **{f"gyroscope.scale_factor.{axis}": ("count/deg", "output/(deg/s)") for axis in AXES},
    **{f"{triad}.misalignment.{pair}": ("1",) for triad in ("accelerometer", "gyroscope") for pair in PAIRS},
    **{f"accelerometer.{bias}.{axis}": ("g",) for bias in _BIASES for axis in AXES},
    **{f"gyroscope.{bias}.{axis}": ("deg/h",) for bias in _BIASES for axis in AXES},
    **{f"slab.tilt.{side}": ("rad",) for side in ("east", "north")},
    **{f"fixture.parallelism.{face}": ("rad",) for face in _FACES},
    "residual.accelerometer_rms_g": ("g",),
    "residual.gyroscope_rms_deg_h": ("deg/h",),
    "residual.p_value": ("1",),
}


@dataclass(frozen=True, slots=True)
class Limit:
    """What ``parameter`` may be, in ``unit``; ``low`` or ``high`` is None where that side is open."""

    parameter: str
    low: float | None
    high: float | None
    unit: str
    guard_band: float = 0.0

    def __post_init__(self) -> None:
        names = covered(self.parameter)
        if len({UNITS[name] for name in names}) != 1:
            groups = dict.fromkeys(".".join(name.split(".")[:2]) for name in UNITS)
            raise ValueError(f"parameter {self.parameter!r} to be one of {', '.join(groups)}")
        if self.unit not in UNITS[names[0]]:
            raise ValueError(f"the unit of {self.parameter} to be {' or '.join(UNITS[names[0]])}")
        ends = [end for end in (self.low, self.high) if end is not None]
        if not ends or not all(map(math.isfinite, ends)) or ends != sorted(ends):
            raise ValueError(f"low, high or both of {self.parameter}, finite, low not above high")
        if not (math.isfinite(self.guard_band) and self.guard_band >= 0):
            raise ValueError(f"guard_band of {self.parameter} to be 0 or more sigmas")
        if self.guard_band and self.parameter.startswith("residual."):
            raise ValueError(f"no guard_band of {self.parameter}: it has no sigma")

    def accepted(self, std: float | None) -> tuple[float, float]:
        """Return the interval in which a value of 1 sigma ``std`` is accepted; infinite at an open side."""
        guard = self.guard_band * (std or 0.0)
        low = -math.inf if self.low is None else self.low + guard
        return low, math.inf if self.high is None else self.high - guard


def covered(parameter: str) -> tuple[str, ...]:
    """Return the parameters that a name stands for: itself, or without an axis all of its axes."""
    return tuple(name for name in UNITS if name == parameter or name.startswith(f"{parameter}."))


def each_axis(limit: Limit) -> tuple[Limit, ...]:
    """Return a limit as one for each parameter that its name stands for."""
    return tuple(replace(limit, parameter=name) for name in covered(limit.parameter))


def set_limits(session: Session, model: str, limits: Sequence[Limit]) -> None:
    """Put these limits in the place of all that a model had; a name without an axis means all axes.

    Raises
    ------
    ValueError
        If a parameter is limited twice.
    """
    rows = [one for limit in limits for one in each_axis(limit)]
    names = [row.parameter for row in rows]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"{twice[0]} once")
    for row in session.scalars(select(ImuLimitRow).where(ImuLimitRow.model == model)):
        session.delete(row)
    session.flush()  # before the new ones of the same names
    session.add_all(ImuLimitRow(model=model, **asdict(one)) for one in rows)
    session.flush()


def limits_of(session: Session, model: str) -> tuple[Limit, ...]:
    """Return a model's limits in the order in which they were given, one for each axis; none if it has none."""
    rows = session.scalars(select(ImuLimitRow).where(ImuLimitRow.model == model).order_by(ImuLimitRow.id))
    return tuple(Limit(row.parameter, row.low, row.high, row.unit, row.guard_band) for row in rows)


def limited_models(session: Session) -> Sequence[str]:
    """Return the models that have limits, by name."""
    return session.scalars(select(ImuLimitRow.model).distinct().order_by(ImuLimitRow.model)).all()
