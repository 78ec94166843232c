"""Time constants of effects: where a search begins, and what a change of one adds.

The search begins at steps too small for a minimum to hide between them, from what the nodes can resolve to several
times what was recorded; from the best one on the time constant is fitted with the coefficients (Golub and Pereyra
1973, variable projection), as its logarithm.
"""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import TAU, Columns, Effect, Excitation

RATIO = 1.7  # between neighbours, at most
LONGEST = 3.0  # times what was recorded: beyond it an exponential is a straight line
LOG_RANGE = 3.0  # plausible change of a logarithm from where the search begins
STEP = 1e-3  # of a logarithm, over which a slope is taken


def search(shortest_s: float, recorded_s: float) -> tuple[float, ...]:
    """Return time constants [s] to begin with, from the shortest to several times what was recorded."""
    longest = LONGEST * recorded_s
    if not 0 < shortest_s < longest:
        return ()
    count = 1 + int(np.ceil(np.log(longest / shortest_s) / np.log(RATIO)))
    return tuple(np.geomspace(shortest_s, longest, count).tolist())


def with_tau(way: Columns, plausible: tuple[float, ...]) -> Columns:
    """Return a way with its time constant as the last coefficient, of which nothing is known yet: nought."""
    return replace(
        way, coefficients=(*way.coefficients, TAU), plausible=(*plausible, LOG_RANGE),
        accel=_appended(way.accel), gyro=_appended(way.gyro),
    )  # fmt: skip


def _appended(part: FloatArray | None) -> FloatArray | None:
    return None if part is None else np.concatenate((part, np.zeros((*part.shape[:2], 1))), axis=2)


def with_slope(effect: Effect, seen: Excitation, way: Columns, c: FloatArray) -> Columns:
    """Return a way whose last column is the slope by the time constant's logarithm at coefficients ``c`` (k,).

    These are in the effect's unit, such as g/K or deg/h/K.
    """
    if effect.at is None or not way.tau_s or not np.any(c[:-1]):
        return way
    less, more = (effect.at(seen, replace(way, tau_s=way.tau_s * np.exp(step))) for step in (-STEP, STEP))
    return replace(
        way, accel=_sloped(way.accel, less.accel, more.accel, c), gyro=_sloped(way.gyro, less.gyro, more.gyro, c)
    )  # fmt: skip


def _sloped(
    part: FloatArray | None, less: FloatArray | None, more: FloatArray | None, c: FloatArray
) -> FloatArray | None:
    if part is None or less is None or more is None:
        return part
    slope: FloatArray = (more - less)[:, :, :-1] @ c[:-1] / (2 * STEP)
    return np.concatenate((part[:, :, :-1], slope[:, :, None]), axis=2)
