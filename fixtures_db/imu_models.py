"""What holds for an IMU model: limits of its parameters, and user-defined error terms, also of one unit.

An error term is in force from its ``add`` to its ``withdraw``, events in a chain; a unit's own take precedence.

A limit is what a parameter of a solution may be, and how a value is held against that. Guarded acceptance (JCGM
106:2012, 8.3): the interval is narrowed at both ends by ``guard_band`` times the value's own standard uncertainty,
so that a value accepted near a limit is unlikely to be beyond it.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import ROW_TITLES, chained, verify_rows
from fixtures_db.errors import InForceAlready, NotInForce
from fixtures_db.hash_chain import ChainFault, digest
from fixtures_db.schema import EffectEventRow, ImuLimitRow
from procedures.frames import AXES

ADD, WITHDRAW = "add", "withdraw"


def add_effect(session: Session, name: str, definition: str, model: str, serial: str | None) -> EffectEventRow:
    """Put an effect/1 in force for a model or, with ``serial``, one unit; it takes the place of one of its name.

    Call it in `fixtures_db.database.Database.write`. Raise `InForceAlready` if the same text is in force there.
    """
    now, sha256 = _newest(session, model, serial).get(name), digest(definition)
    if now is not None and (now.event, now.effect_sha256) == (ADD, sha256):
        raise InForceAlready(owner(model, serial), name)
    return _append(session, EffectEventRow(event=ADD, name=name, model=model, serial=serial,
                                           effect_sha256=sha256, definition=definition))  # fmt: skip


def withdraw_effect(session: Session, name: str, model: str, serial: str | None) -> EffectEventRow:
    """Take an effect out of force; its row stays. Call it in `fixtures_db.database.Database.write`.

    Raise `NotInForce` if there is none in force there.
    """
    known = _newest(session, model, serial)
    now = known.get(name)
    if now is None or now.event != ADD:
        there = [each.name for each in known.values() if each.event == ADD]
        raise NotInForce(owner(model, serial), name, there)
    return _append(session, EffectEventRow(event=WITHDRAW, name=name, model=model, serial=serial,
                                           effect_sha256=now.effect_sha256, definition=""))  # fmt: skip


def effects_in_force(session: Session, model: str, serial: str | None) -> tuple[EffectEventRow, ...]:
    """Return the effects of a unit, its model's among them, by name; without ``serial`` of the model alone."""
    found = {name: row for name, row in _newest(session, model, None).items() if row.event == ADD}
    if serial is not None:
        found |= {name: row for name, row in _newest(session, model, serial).items() if row.event == ADD}
    return tuple(found[name] for name in sorted(found))


def all_in_force(session: Session) -> tuple[EffectEventRow, ...]:
    """Return every effect in force, by model, unit and name."""
    owners = {(row.model, row.serial) for row in session.scalars(select(EffectEventRow))}
    rows = (row for model, serial in owners for row in _newest(session, model, serial).values())
    kept = (row for row in rows if row.event == ADD)
    return tuple(sorted(kept, key=lambda row: (row.model, row.serial or "", row.name)))


def owner(model: str, serial: str | None) -> str:
    """Return whose an effect is in words."""
    return f"model {model}" if serial is None else f"{model} {serial}"


def _newest(session: Session, model: str, serial: str | None) -> dict[str, EffectEventRow]:
    """Return the last event of each name of a model or a unit."""
    of_owner = select(EffectEventRow).where(EffectEventRow.model == model, EffectEventRow.serial.is_(serial)
                                            if serial is None else EffectEventRow.serial == serial)  # fmt: skip
    rows: Sequence[EffectEventRow] = session.scalars(of_owner.order_by(EffectEventRow.id)).all()
    return {row.name: row for row in rows}


def _append(session: Session, row: EffectEventRow) -> EffectEventRow:
    row.recorded_utc = datetime.now(UTC)
    return chained(session, row)


def verify_effects(session: Session, expected_head: str | None = None) -> list[ChainFault]:
    """Return every event that was altered, dropped or reordered since, or whose effect has another hash.

    Rows dropped at the newest end show only against ``expected_head``, a hash that was kept elsewhere.
    """

    def others(row: EffectEventRow) -> Iterator[ChainFault]:
        if row.event == ADD and (actual := digest(row.definition)) != row.effect_sha256:
            yield ChainFault(f"{ROW_TITLES[EffectEventRow]} {row.id}", f"sha256 {actual}", row.effect_sha256)

    return verify_rows(session, EffectEventRow, expected_head, others)


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

    Raise `ValueError` if a parameter is limited twice.
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
