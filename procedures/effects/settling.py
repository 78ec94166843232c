"""What settles since power-on: the time since a recording began, and time constants to begin a search with."""

from collections.abc import Callable

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import TAU, Columns, Excitation
from procedures.effects.time_constant import search

SHORTEST_S = 30.0  # s, to begin with


def since_begun(seen: Excitation) -> FloatArray:
    """Return the time (n,) [s] since each history began; nan where no time is known.

    A node stands in the middle of what it is the mean of: a history began half of that before its first one.
    """
    history = seen.histories[seen.step]
    begun = np.array([_begin(np.sort(seen.t[history == one])) for one in range(int(history.max()) + 1)])
    found: FloatArray = seen.t - begun[history]
    return found


def _begin(t: FloatArray) -> float:
    """Return when a history of nodes at t (m,) [s] began; inf of none."""
    if len(t) == 0:
        return float(np.inf)
    return float(t[0] - (t[1] - t[0]) / 2) if len(t) > 1 else float(t[0])


def ways_to_settle(at: Callable[[Excitation, Columns], Columns], seen: Excitation) -> list[Columns]:
    """Return an effect's columns at the time constants that a search begins with; none where no time is known."""
    since = since_begun(seen)
    if not np.isfinite(since).all():
        return []
    return [at(seen, Columns((), nonlinear={TAU: tau})) for tau in search(SHORTEST_S, float(since.max()))]
