"""Relaxation of the accelerometers after a flip: ``A exp(-t / tau)``, t since the step began.

Flexure and suspension creep after the load on them changed. A is the same after every flip, or in proportion to
the change of specific force along the axis, or to the specific force that is. tau is fitted. The cube comes to
rest before a step begins: A is what is left at its beginning. Plausible: 100 ug.
"""

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.effects.effect import TAU, Columns, Effect, Excitation, per_axis
from procedures.effects.time_constant import search, with_nonlinear
from procedures.frames import AXES

SHORTEST_S = 3.0  # s, to begin with
AT_REST = ("dwell", "rest")
PLAUSIBLE = 1e-4  # g, or g/g
BY_CHANGE, BY_FORCE = "by the change of f", "by f"
SHAPES = ("", BY_CHANGE, BY_FORCE)


def columns(excitation: Excitation) -> list[Columns]:
    """Return exp(-t / tau) per sensor at rests in every shape, with time constants to begin with."""
    rests = _rests(excitation)
    if not rests.any():
        return []
    longest = float(np.max(excitation.rest_s[rests]))
    return [
        at(excitation, Columns((), shape=shape, nonlinear={TAU: tau}))
        for tau in search(SHORTEST_S, longest)
        for shape in SHAPES
    ]


def at(excitation: Excitation, way: Columns) -> Columns:
    """Return exp(-t / tau) per sensor at rests, or that times f or its change (nought of the first, unknown)."""
    fading = np.where(_rests(excitation), np.exp(-excitation.rest_s / way.tau_s), 0.0)
    by: dict[str, FloatArray] = {BY_CHANGE: excitation.change, BY_FORCE: excitation.f}
    value = fading if way.shape not in by else fading[:, None] * np.nan_to_num(by[way.shape])
    unit = "g/g" if way.shape in by else ""
    found = Columns(AXES, accel=per_axis(value), shape=way.shape, unit=unit, nonlinear=way.nonlinear)
    return with_nonlinear(found, (PLAUSIBLE,) * 3)


def _rests(excitation: Excitation) -> BoolArray:
    found: BoolArray = np.array([step.kind in AT_REST for step in excitation.steps])[excitation.step]
    return found


EFFECT = Effect(
    name="accelerometer.relaxation",
    unit="g",
    physics="A exp(-t / tau) after a flip; A constant, or in proportion to u or to its change",
    source="IEEE Std 1293, hysteresis and warm-up trend after tumbling",
    plausible=PLAUSIBLE,
    columns=columns,
    separate_by="a long dwell after a flip, and one without a flip before it",
    at=at,
    driver="time at rest",
)
