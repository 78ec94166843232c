"""What a correction is computed from: temperature signals without look-ahead, other channels, a triad's numbers.

Between samples temperature goes straight; one that a sample lacks is that of the sample before. The rate is the
slope of a straight line through the last minute. A unit is in equilibrium when its first sample is taken.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import exp, expm1, isfinite, isnan, nan
from typing import Any, NamedTuple

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.kernel_options import kernel
from procedures.effects.excitation import REFERENCE_C
from procedures.effects.temperature_history import REVERSAL_K

SLOPE_S = 60.0  # over which the temperature's rate is taken
MIN_SLOPE_S = 10.0
KEPT_S = 1.0  # between the temperatures of which the slope is taken
KEPT = int(SLOPE_S / KEPT_S) + 2
_LAST_T, _LAST, _WAY, _LOW, _HIGH, _RATE, _FIRST, _COUNT, _STATES = range(9)  # of the state


WARMTH, RATE, DIRECTION = "warmth", "rate", "direction"


class Backlash(NamedTuple):
    """Where a hysteresis with a play is between its branches, by the half width [K] of the play."""

    half_width_k: float


Signal = str | float | Backlash  # a lag is named by its time constant
# At n samples: WARMTH [K] above 25 degC, RATE [K/min], DIRECTION 1 once it is seen to warm, -1 once it cools,
# 0 before; lags as warmth; a backlash from -1 to 1, T less what follows it in half widths. nan: not known.
Signals = Mapping[Signal, FloatArray]


class TemperatureFollower:
    """Follows the temperature from block to block, by lags and backlashes among ``signals`` too."""

    def __init__(self, signals: Iterable[Signal] = ()) -> None:
        followed = set(signals)
        self._taus = np.array(sorted(tau for tau in followed if isinstance(tau, float)))
        self._plays = np.array(sorted(one.half_width_k for one in followed if isinstance(one, Backlash)))
        self._state = np.zeros(_STATES)
        self._sensor, self._kept = np.zeros(len(self._taus)), np.zeros((KEPT, 2))
        self._pushed = np.zeros(len(self._plays))
        self._state[[_LAST_T, _LAST, _LOW, _HIGH]] = nan

    def take(self, t: FloatArray, temperature: FloatArray | None) -> Signals:
        """Return the signals at times ``t`` (n,) [s] of ``temperature`` (n,) [degC], None where not known."""
        n = len(t)
        known = np.full(n, nan) if temperature is None else np.asarray(temperature, dtype=np.float64)
        found, lagged, branch = (np.empty((rows, n)) for rows in (3, len(self._taus), len(self._plays)))
        _follow(
            np.asarray(t, np.float64), known, self._taus, self._plays, self._state, self._sensor, self._pushed,
            self._kept, found, lagged, branch,
        )  # fmt: skip
        names: list[Signal] = [WARMTH, RATE, DIRECTION, *self._taus.tolist(), *map(Backlash, self._plays.tolist())]
        return dict(zip(names, (*found, *lagged, *branch), strict=True))


@kernel
def _follow(
    t: FloatArray, temperature: FloatArray, taus: FloatArray, backlashes: FloatArray, state: FloatArray,
    sensor: FloatArray, pushed: FloatArray, kept: FloatArray, found: FloatArray, lagged: FloatArray,
    branch: FloatArray,
) -> None:  # fmt: skip
    """Write warmth, rate and direction (3, n), what each sensor has come to (taus, n) and branches (plays, n).

    The state goes on.
    """
    for i in range(t.shape[0]):
        T, now = temperature[i], t[i]
        if not isfinite(T):
            T = state[_LAST]
        if isnan(T):
            for m in range(3):
                found[m, i] = nan
            for m in range(taus.shape[0]):
                lagged[m, i] = nan
            for m in range(backlashes.shape[0]):
                branch[m, i] = nan
            continue
        is_first = isnan(state[_LAST_T]) or now < state[_LAST_T]
        if is_first:
            state[_LAST], state[_LOW], state[_HIGH] = T, T, T
            state[_WAY], state[_RATE], state[_FIRST], state[_COUNT] = 0.0, 0.0, 0.0, 0.0
        for m in range(taus.shape[0]):
            if is_first:
                sensor[m] = T
            else:
                gap = (now - state[_LAST_T]) / taus[m]
                end = 1.0 + expm1(-gap) / gap if gap > 1e-6 else gap / 2
                left = exp(-gap)
                sensor[m] = left * sensor[m] + end * T + (1.0 - left - end) * state[_LAST]
            lagged[m, i] = sensor[m] - REFERENCE_C
        for m in range(backlashes.shape[0]):
            pushed[m] = T if is_first else min(max(pushed[m], T - backlashes[m]), T + backlashes[m])
            branch[m, i] = (T - pushed[m]) / backlashes[m]
        newest = (int(state[_FIRST]) + int(state[_COUNT]) - 1) % kept.shape[0]
        if state[_COUNT] == 0 or now - kept[newest, 0] >= KEPT_S:
            _keep(now, T, state, kept)
        state[_LOW], state[_HIGH] = min(T, state[_LOW]), max(T, state[_HIGH])
        if state[_WAY] <= 0 and T - state[_LOW] > REVERSAL_K:
            state[_WAY], state[_LOW], state[_HIGH] = 1.0, T, T
        elif state[_WAY] >= 0 and state[_HIGH] - T > REVERSAL_K:
            state[_WAY], state[_LOW], state[_HIGH] = -1.0, T, T
        state[_LAST_T], state[_LAST] = now, T
        found[0, i], found[1, i], found[2, i] = T - REFERENCE_C, state[_RATE], state[_WAY]


@kernel
def _keep(now: float, T: float, state: FloatArray, kept: FloatArray) -> None:
    """Keep a temperature, let go of what is older than a minute, and take the slope of a straight line [K/min]."""
    size = kept.shape[0]
    while state[_COUNT] > 0 and (now - kept[int(state[_FIRST]), 0] > SLOPE_S or state[_COUNT] == size):
        state[_FIRST] = (int(state[_FIRST]) + 1) % size
        state[_COUNT] -= 1
    at = (int(state[_FIRST]) + int(state[_COUNT])) % size
    kept[at, 0], kept[at, 1] = now, T
    state[_COUNT] += 1
    state[_RATE] = 0.0
    first, count = int(state[_FIRST]), int(state[_COUNT])
    if now - kept[first, 0] < MIN_SLOPE_S:
        return
    mean_t = mean_T = 0.0
    for j in range(count):
        mean_t += (kept[(first + j) % size, 0] - now) / count
        mean_T += (kept[(first + j) % size, 1] - T) / count
    top = bottom = 0.0
    for j in range(count):
        dt = kept[(first + j) % size, 0] - now - mean_t
        top += dt * (kept[(first + j) % size, 1] - T - mean_T)
        bottom += dt * dt
    state[_RATE] = 60.0 * top / bottom


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What the sensors were in at n samples, each (n,) or (n, 3), None where unknown.

    ``temperature`` [degC], ``temperature_rate`` [K/min], ``magnetic`` [uT] in IMU axes, ``auxiliary`` by channel;
    ``t`` [s] rises. ``signals`` are what a `TemperatureFollower` makes of the temperature, where it was followed
    before; else it begins with the first sample.
    """

    temperature: FloatArray | None = None
    temperature_rate: FloatArray | None = None
    magnetic: FloatArray | None = None
    auxiliary: Mapping[str, FloatArray] = field(default_factory=dict)
    t: FloatArray | None = None
    signals: Signals | None = None

    @property
    def followed(self) -> Signals:
        """Its signals, which are there by now."""
        assert self.signals is not None
        return self.signals


@dataclass(frozen=True, slots=True, eq=False)
class Triad:
    """k (3,), E (3, 3), D (3,) in g or deg/s, and ``inverse`` (3, 3) of E."""

    k: FloatArray
    E: FloatArray
    D: FloatArray
    inverse: FloatArray

    @classmethod
    def of(cls, part: Mapping[str, Any], per: float) -> "Triad":
        """Return a triad of `calibration/1` whose bias is in 1 / ``per`` of the unit of u."""
        names = ("scale_factor", "misalignment", "bias")
        k, E, D = (np.array(part[name]["value"], dtype=np.float64) for name in names)
        return cls(k, E, D * per, np.asarray(np.linalg.inv(E), np.float64))


NOTHING_KNOWN = Surroundings()
