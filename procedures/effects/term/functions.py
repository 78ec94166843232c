"""What a term may call: functions of values at one moment, and operators that look back in time.

Time goes on between the steps of a campaign: there a value is taken to go straight from the last node to the next.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.excitation import Excitation
from procedures.effects.temperature_history import lagged


@dataclass(frozen=True, slots=True)
class Function:
    """A function of ``arity`` values; ``of`` says which units it takes.

    ``number``: numbers to a number. ``angle``: an angle, or a number in rad, to a number. ``same``: of one unit,
    to that unit. ``sign``: any to a number. ``root``: any to its square root. ``square``: the square of an angle
    to a number. ``ratio``: of one unit, to a number.
    """

    arity: int
    of: str
    value: Callable[..., FloatArray]


FUNCTIONS: Mapping[str, Function] = {
    "abs": Function(1, "same", np.abs),
    "sign": Function(1, "sign", np.sign),
    "exp": Function(1, "number", np.exp),
    "log": Function(1, "number", np.log),
    "tanh": Function(1, "number", np.tanh),
    "sqrt": Function(1, "root", np.sqrt),
    "sin": Function(1, "angle", np.sin),
    "cos": Function(1, "angle", np.cos),
    "min": Function(2, "same", np.minimum),
    "max": Function(2, "same", np.maximum),
}


SERIES_BELOW = 1e-3  # of x^2, below which series are used


def sine_less_one(y: FloatArray) -> FloatArray:
    """Return sin(x) / x - 1, a number (n, 3), of ``y = x^2`` (n, 3); sinh of a negative y."""
    x = np.sqrt(np.maximum(abs(y), SERIES_BELOW))
    beyond = np.where(y > 0, np.sin(x), np.sinh(x)) / x - 1
    return np.where(abs(y) < SERIES_BELOW, -y / 6 + y**2 / 120 - y**3 / 5040, beyond)


OF_CATALOGUE: Mapping[str, Function] = {
    "sine": Function(1, "square", sine_less_one),
    "backlash": Function(2, "ratio", np.divide),  # of the temperature: `Values` follows it
}
"""What only laws of the catalogue call."""
ALL_FUNCTIONS: Mapping[str, Function] = {**FUNCTIONS, **OF_CATALOGUE}


def smooth(t: FloatArray, x: FloatArray, tau_s: float) -> FloatArray:
    """Return the mean (n,) of x (n,), in its unit, at times t (n,) [s] over the last ``tau_s``; it was x[0]."""
    total = np.concatenate((np.zeros(1), np.cumsum(np.diff(t) * (x[1:] + x[:-1]) / 2)))
    slope = np.append(np.diff(x) / np.maximum(np.diff(t), 1e-9), 0.0)
    begin = t - tau_s
    at = np.clip(np.searchsorted(t, begin, side="right") - 1, 0, len(t) - 1)
    into = begin - t[at]
    until = total[at] + into * x[at] + np.where(into > 0, slope[at] * into**2 / 2, 0.0)
    found: FloatArray = (total - until) / tau_s
    return found


OPERATORS: Mapping[str, Callable[[FloatArray, FloatArray, float], FloatArray]] = {"lag": lagged, "smooth": smooth}


def over_time(operator: str, seen: Excitation, x: FloatArray, tau_s: float) -> FloatArray:
    """Return an operator's value (n, 1) or (n, 3), in the unit of x, of one shaped so, history by history."""
    history = seen.histories[seen.step]
    found = np.full(x.shape, np.nan)
    for number in np.unique(history):
        nodes = np.flatnonzero(history == number)
        order = nodes[np.argsort(seen.t[nodes], kind="stable")]
        if not (tau_s > 0 and np.isfinite(x[order]).all() and np.isfinite(seen.t[order]).all()):
            continue
        for column in range(x.shape[1]):
            found[order, column] = OPERATORS[operator](seen.t[order], x[order, column], tau_s)
    return found
