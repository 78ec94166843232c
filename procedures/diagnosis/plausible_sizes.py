"""How large an effect may plausibly be for a unit of the grade that its recordings show."""

from functools import lru_cache

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.diagnosis.rate_points import STD_PER_MAD
from procedures.diagnosis.residual_rows import Evidence
from procedures.effects.effect import Effect
from procedures.units import DEG_H_PER_DEG_S, UG_PER_G

# g, deg/s: 1 sigma of a dwell of the grade the ranges are for
NAVIGATION_GRADE_STD = (1 / UG_PER_G, 0.5 / DEG_H_PER_DEG_S)
MEASURED = ("temperature", "auxiliary")  # in the names of effects that go with a channel of the recording
BY_TIME = (".bias_drift", ".bias_settling", ".jump", "placement.tilt")
ROUNDING = 1e-9  # of a column's largest
TIMES_SPREAD = 2.0  # by which an effect may be larger than what makes the spread of soaks' levels


def grade_factor(evidence: Evidence, effect: Effect) -> float:
    """Return by how much an effect's plausible range is wider than for a unit of navigation grade; at least 1.

    Nonlinearity, temperature coefficients and the care of the hands go with the noise, over many decades. Of a
    unit that is known by a rest alone how far its output wanders tells its grade too, for what goes with a channel
    that is measured: the biases of MEMS sensors move with temperature by tens of times their noise over 100 s.
    """
    return noise_in_navigation_grade(evidence, _triad_of(effect), _is_measured(effect))


def as_it_wanders(evidence: Evidence, effect: Effect, H: FloatArray) -> FloatArray:
    """Return coefficients (k,) of columns H (n, k) that move rests as far as they wander; else nought.

    Of a unit that is known by rests alone, what goes by time may be all that is seen: a MEMS gyroscope jumps and
    drifts by tens of times its noise. Whether it is a random walk is asked of every drift and jump that is found.
    What goes by time or with a channel may make all of the spread of several rests.
    """
    of_triad, found = evidence.triad == _triad_of(effect), np.zeros(H.shape[1])
    is_by_time = effect.name.endswith(BY_TIME)
    if (evidence.rows("mean", "norm", "rate") & of_triad).any() or not (is_by_time or _is_measured(effect)):
        return found
    least = ROUNDING * float(np.max(np.abs(H), initial=0.0))
    if is_by_time and (rows := evidence.rows("soak") & of_triad).any():
        found = _sizes(evidence, rows, H[rows].std(axis=0), least)
    if (rows := evidence.rows("level") & of_triad).any():  # of the sensor that shows most: others are alike
        between = TIMES_SPREAD * _sizes(evidence, rows, np.full(H.shape[1], np.max(H[rows].std(axis=0))), least)
        found = np.maximum(found, between)
    return found


def _sizes(evidence: Evidence, rows: BoolArray, moved: FloatArray, least: float) -> FloatArray:
    """Return the coefficients (k,) that move rows by their rms, where 1 of each moves them by ``moved`` (k,).

    What moves them by no more than ``least`` is nought but for rounding, as a turn about the vertical is.
    """
    wandering = float(np.sqrt(np.mean(evidence.residual[rows] ** 2)))
    found: FloatArray = np.divide(wandering, moved, out=np.zeros(len(moved)), where=moved > least)
    return found


def _triad_of(effect: Effect) -> int:
    return int(effect.name.startswith("gyroscope"))


def _is_measured(effect: Effect) -> bool:
    return any(channel in effect.name for channel in MEASURED)


@lru_cache(maxsize=32)
def noise_in_navigation_grade(evidence: Evidence, triad: int, is_measured: bool) -> float:
    """Return how many times as noisy as of navigation grade a triad is, by `grade_factor`; at least 1."""
    of_triad = evidence.triad == triad
    rows = evidence.rows("mean", "norm", "rate") & of_triad
    if rows.any():
        return max(float(np.median(evidence.sigma[rows])) / NAVIGATION_GRADE_STD[triad], 1.0)
    if not (rows := evidence.rows("soak") & of_triad).any():
        return 1.0
    if not is_measured:
        return max(float(np.median(evidence.sigma[rows])) / NAVIGATION_GRADE_STD[triad], 1.0)
    sensors = [evidence.residual[rows & (evidence.axis == axis)] for axis in np.unique(evidence.axis[rows])]
    wandering = max(STD_PER_MAD * float(np.median(np.abs(of))) for of in sensors)  # of the one that moves most
    return max(max(float(np.median(evidence.sigma[rows])), wandering) / NAVIGATION_GRADE_STD[triad], 1.0)
