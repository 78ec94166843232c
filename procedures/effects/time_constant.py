"""Time constants of effects and what else is not linear: where a search begins, and their columns.

The search begins at steps too small for a minimum to hide between them, from what the nodes can resolve to several
times what was recorded; from the best one on the time constant is fitted with the coefficients (Golub and Pereyra
1973, variable projection), as its logarithm.
"""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.excitation import Columns

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


def with_nonlinear(way: Columns, plausible: tuple[float, ...]) -> Columns:
    """Return a way with what is not linear as its last coefficients, of which nothing is known yet: zero.

    ``plausible`` are 1 sigma of the others, each in its unit.
    """
    names, more = tuple(way.nonlinear), len(way.nonlinear)
    return replace(
        way, coefficients=(*way.coefficients, *names), plausible=(*plausible, *(LOG_RANGE,) * more),
        accel=_appended(way.accel, more), gyro=_appended(way.gyro, more),
    )  # fmt: skip


def _appended(part: FloatArray | None, more: int) -> FloatArray | None:
    return None if part is None else np.concatenate((part, np.zeros((*part.shape[:2], more))), axis=2)
