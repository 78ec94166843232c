"""What temperature did in a campaign: the temperature that a sensor follows, and whether it warmed or cooled.

Between nodes temperature goes straight. A unit is switched on in equilibrium, as warm as the thermometer, when its
time begins; where that is longer ago than the sensor remembers, or not known, when the campaign does.
"""

from functools import lru_cache

import numpy as np
from scipy.linalg import solve_banded

from procedures.arrays import FloatArray, IntArray
from procedures.effects.excitation import Excitation
from procedures.units import S_PER_MIN

SWITCHED_ON_S = 600.0  # ago, within which temperature is carried back to where a unit was switched on
REVERSAL_K = 0.5  # by which temperature must come back before it has turned: less is the thermometer's noise


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


@lru_cache(maxsize=64)  # of a campaign several effects ask for the same
def sensor_temperature(seen: Excitation, tau_s: float) -> FloatArray:
    """Return T_s (n,) [degC] at the nodes, which follows the temperature: ``tau dT_s/dt = T - T_s``.

    nan where a campaign's temperature is not known, or there is no time constant above zero.
    """
    found = np.full(len(seen.t), np.nan)
    for order in known_histories(seen) if tau_s > 0 else ():
        t, T = seen.t[order], seen.temperature[order]
        if 0 < t[0] < tau_s and np.isfinite(seen.temperature_rate[order[0]]):
            begin = T[0] - seen.temperature_rate[order[0]] * t[0] / S_PER_MIN
            t, T = np.append(0.0, t), np.append(begin, T)
        found[order] = lagged(t, T, tau_s)[-len(order) :]
    found.flags.writeable = False
    return found


def warming(seen: Excitation) -> FloatArray:
    """Return 1 (n,) at nodes where it grows warmer, -1 where it cools, from each turning point on; nan if unknown.

    A temperature that never moved by `REVERSAL_K` has no direction: 0.
    """
    found = np.full(len(seen.t), np.nan)
    for order in known_histories(seen):
        found[order] = _direction(seen.temperature[order])
    return found


def played(seen: Excitation, half_width_k: float) -> FloatArray:
    """Return what follows the temperature with a play (n,) [degC], nan where that is unknown.

    It moves where T is farther away than the play's half width: the classical play operator (Krasnosel'skii and
    Pokrovskii 1989), from equilibrium when the unit was switched on.
    """
    found = np.full(len(seen.t), np.nan)
    for order in known_histories(seen):
        T = seen.temperature[order]
        at, left = _when_switched_on(seen, order), np.empty_like(T)
        for i, now in enumerate(T.tolist()):
            at = left[i] = min(max(at, now - half_width_k), now + half_width_k)
        found[order] = left
    return found


def _when_switched_on(seen: Excitation, order: IntArray) -> float:
    """Return the temperature [degC] when time began, if that is not long ago, else the first that is known."""
    t, T, rate = (float(each[order[0]]) for each in (seen.t, seen.temperature, seen.temperature_rate))
    return T - rate * t / S_PER_MIN if 0 < t < SWITCHED_ON_S and np.isfinite(rate) else T


def direction_or_play(seen: Excitation, half_width_k: float | None) -> FloatArray:
    """Return on which branch a hysteresis is (n,), from -1 to 1; at once on one of both without a play.

    With one it is ``(T - P) / w``. nan where it is unknown, or w is not above zero.
    """
    if half_width_k is None:
        return warming(seen)
    if not half_width_k > 0:
        return np.full(len(seen.t), np.nan)
    return (seen.temperature - played(seen, half_width_k)) / half_width_k


def ranged_k(seen: Excitation) -> float:
    """Return by how much temperature ranged in the campaign where it did most [K], 0 where none is known."""
    return max((float(np.ptp(seen.temperature[order])) for order in known_histories(seen)), default=0.0)


def recorded_s(seen: Excitation) -> float:
    """Return how long the longest campaign with a known temperature is [s], 0 without one."""
    return max((float(np.ptp(seen.t[order])) for order in known_histories(seen)), default=0.0)


@lru_cache(maxsize=4)
def known_histories(seen: Excitation) -> tuple[IntArray, ...]:
    """Return the nodes (m,), in the order of time, of each history with a known temperature."""
    history, found = seen.histories[seen.step], list[IntArray]()
    for number in np.unique(history):
        nodes = np.flatnonzero(history == number)
        if np.isfinite(seen.temperature[nodes]).all() and np.isfinite(seen.t[nodes]).all():
            found.append(nodes[np.argsort(seen.t[nodes], kind="stable")])
            found[-1].flags.writeable = False
    return tuple(found)


def lagged(t: FloatArray, T: FloatArray, tau_s: float) -> FloatArray:
    """Return T_s (n,) [degC] of T (n,) at times t (n,) [s]; exact where T goes straight from node to node.

    It begins at the first T. In place of T anything may stand.
    """
    gap = np.maximum(np.diff(t, prepend=t[0]), 0.0) / tau_s
    kept = np.exp(-gap)
    # of a straight line through a gap: the part that its end adds, and its beginning
    end = np.where(gap > 1e-6, 1 + np.expm1(-gap) / np.maximum(gap, 1e-12), gap / 2)
    before = np.concatenate((T[:1], T[:-1]))
    driven = end * T + (1 - kept - end) * before
    driven[0] = T[0]
    banded = np.vstack((np.ones(len(t)), np.append(-kept[1:], 0.0)))
    found: FloatArray = solve_banded((1, 0), banded, driven)
    return found


def _direction(T: FloatArray) -> FloatArray:
    """Return the direction (n,) from each turning point on; the first is that of all before it was seen."""
    found, way = np.zeros(len(T)), 0.0
    low = high = 0
    for i, value in enumerate(T.tolist()):
        low, high = (i if value < T[low] else low), (i if value > T[high] else high)
        if way <= 0 and value - T[low] > REVERSAL_K:
            way, turn = 1.0, low
        elif way >= 0 and T[high] - value > REVERSAL_K:
            way, turn = -1.0, high
        else:
            continue
        found[turn if found[0] else 0 :] = way
        low = high = i
    return found
