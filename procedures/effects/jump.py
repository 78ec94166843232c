"""A bias or scale factor that jumped between two steps: ``c`` or ``1e-6 c u`` in every step after it.

Where the unit was switched off and on in between it is its turn-on bias. Each place between two neighbouring steps
of a campaign is a way of its own, and of the bias each of some places within a rest: half of all jumps come while
the cube rests. Plausible: 100 ug and 0.5 deg/h, 100 ppm.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Columns, Effect, Excitation, ExcitationStep, per_axis
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S, PPM_PER_ONE

SCALE_PPM = 100.0  # plausible
RESTING = ("dwell", "rest")
MAX_PLACES = 200  # that are tried: of more, as in many soaks together, evenly spread ones
MIN_STEPS = 2  # on either side: one step by itself is no jump
PARTS = 8  # of a rest, in the middle of each of which a jump is tried: then its time is known to a sixteenth of it

Place = TypeVar("Place")


def places(excitation: Excitation) -> list[tuple[ExcitationStep, FloatArray]]:
    """Return the step before each place, and 1 at the nodes (n,) after it in its campaign, else 0.

    Of more than `MAX_PLACES` they are every so many: a jump in between is seen at its neighbour, a step or two
    off, and each place that is tried counts.
    """
    begins = np.array([_begin(excitation, number) for number in range(len(excitation.steps))])
    history = excitation.histories
    pairs = list[tuple[int, int, int]]()
    for one in np.unique(history):
        numbers = [n for n in range(len(begins)) if history[n] == one and np.isfinite(begins[n])]
        order = sorted(numbers, key=lambda number: begins[number])
        for before, after in zip(
            order[MIN_STEPS - 1 :], order[MIN_STEPS : len(order) - MIN_STEPS + 1], strict=False
        ):
            pairs.append((int(one), before, after))
    found = list[tuple[ExcitationStep, FloatArray]]()
    for one, before, after in _evenly(pairs, MAX_PLACES):
        later = (history[excitation.step] == one) & (begins[excitation.step] >= begins[after])
        found.append((excitation.steps[before], later.astype(float)))
    return found


def places_within(excitation: Excitation) -> list[tuple[ExcitationStep, float, FloatArray]]:
    """Return the dwell or rest of each place within, seconds since it began, and 1 at the nodes (n,) after it.

    Not of the first and the last step of a campaign, which are one side of it by themselves. Of many rests they
    are fewer in each, of more than `MAX_PLACES` the middle of every so many.
    """
    begins = np.array([_begin(excitation, number) for number in range(len(excitation.steps))])
    history, found = excitation.histories, list[tuple[ExcitationStep, float, FloatArray]]()
    inner = list[int]()
    for one in np.unique(history):
        here = [n for n in range(len(begins)) if history[n] == one and np.isfinite(begins[n])]
        inner += sorted(here, key=lambda number: begins[number])[1:-1]
    inner = _evenly([number for number in inner if excitation.steps[number].kind in RESTING], MAX_PLACES)
    parts = min(PARTS, MAX_PLACES // max(len(inner), 1))
    for number in inner:
        step, t = excitation.steps[number], excitation.t[excitation.step == number]
        for part in range(parts):
            at = float(t[0] + (part + 0.5) / parts * (t[-1] - t[0]))
            later = (history[excitation.step] == history[number]) & (excitation.t > at)
            found.append((step, at - float(t[0]), later.astype(float)))
    return found


def _evenly(what: list[Place], most: int) -> list[Place]:
    """Return every so many of a list, at most so many."""
    return what[:: -(-len(what) // most) or 1]


def _begin(excitation: Excitation, step: int) -> float:
    t = excitation.t[excitation.step == step]
    return float(t[0]) if len(t) else np.nan


def accelerometer_columns(excitation: Excitation) -> list[Columns]:
    """Return a jump of bias, and between steps one of scale factor, at every place [g per g, per ppm]."""
    return _columns(excitation, excitation.accel_output, lambda one, after: replace(one, accel=after), 1.0, 1e-4)


def gyroscope_columns(excitation: Excitation) -> list[Columns]:
    """Return a jump of bias, and between steps one of scale factor, at every place [deg/s per deg/h, per ppm]."""
    per = 1 / DEG_H_PER_DEG_S
    return _columns(excitation, excitation.gyro_output, lambda one, after: replace(one, gyro=after), per, 0.5)


def _columns(
    excitation: Excitation,
    output: FloatArray,
    placed: Callable[[Columns, FloatArray], Columns],
    per: float,
    plausible: float,
) -> list[Columns]:
    several, found = len({step.campaign for step in excitation.steps}) > 1, list[Columns]()

    def of(step: ExcitationStep) -> dict[str, object]:
        return {"campaign": step.campaign + 1} if several else {}  # whose files may share their names

    for step, later in places(excitation):
        bias = Columns(AXES, where={"after": step.name, **of(step)}, shape="bias", plausible=(plausible,) * 3)
        scale = replace(bias, shape="scale factor", unit="ppm", plausible=(SCALE_PPM,) * 3)
        found.append(placed(bias, per_axis(later * per)))
        found.append(placed(scale, per_axis(later[:, None] * output / PPM_PER_ONE)))
    for step, seconds, later in places_within(excitation):
        where = {"in": step.name, "after_s": round(seconds, 1), **of(step)}
        within = Columns(AXES, where=where, shape="bias", plausible=(plausible,) * 3)
        found.append(placed(within, per_axis(later * per)))
    return found


ACCELEROMETER = Effect(
    name="accelerometer.jump",
    unit="g",
    physics="c, or 1e-6 c u, in every step after one",
    source="IEEE Std 1293, bias and scale factor repeatability",
    plausible=1e-4,
    columns=accelerometer_columns,
    separate_by="the first position again at the end, and the campaign once more without switching off",
    may_hang_on_a_step=True,
)
GYROSCOPE = replace(
    ACCELEROMETER,
    name="gyroscope.jump",
    unit="deg/h",
    source="IEEE Std 952, bias and scale factor repeatability",
    plausible=0.5,
    columns=gyroscope_columns,
)
