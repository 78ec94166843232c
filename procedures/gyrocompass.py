"""Gyrocompassing: heading of a resting cube from the Earth's rate that its own gyroscopes measure.

At rest in position p a gyro q counts ``r_q = k_q (u_q + b_q)`` per second, with ``u = C_sb C_bl(p) w`` the Earth's
rate ``w = Omega (0, cos lat, sin lat)`` in the IMU's axes [rad/s], ``b`` the bias [rad/s], ``k`` [count/rad].
k is one free number, of which the gyros differ by `SCALE_SPREAD`; the biases have a normal prior. With
``s = 1 / k``, one gyro's dwells so far and the one in question obey

    s r = u + error
    cov(error) = bias_std^2 1 1' + SCALE_SPREAD^2 u u' + EARTH_RATE_SLACK^2 Omega^2 I + s^2 diag(std^2)

so that -2 log likelihood is ``chi2(s) - 6 n log s`` for n dwells, chi2 a quadratic form; its least value over
``s > 0`` judges a candidate heading. The rule of decision is this project's own (docs/explanation/guiding.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.special import chdtri

from procedures.arrays import FloatArray
from procedures.frames import vertical_rotation
from procedures.geodesy import EARTH_RATE, earth_rate_n
from procedures.positions import ATTITUDES, face_normal, face_of, nominal_C_lb
from procedures.units import RAD_S_PER_DEG_H

BIAS_STD_RAD_S = RAD_S_PER_DEG_H  # rad/s
SCALE_SPREAD = 0.03  # 1 sigma of a gyro's scale factor about the unit's own
EARTH_RATE_SLACK = 0.02  # 1 sigma, of the Earth's rate: misaligned gyros, and a cube set down a degree off
MISFIT_P_VALUE = 1e-3  # probability of a chi2 above which a candidate does not fit
MIN_LIKELIHOOD_MARGIN = 60.0  # of -2 log likelihood, to every other candidate
SCALE_ITERATIONS = 4
MAX_RELATIVE_SCALE_STD = 0.5  # relative sigma of a scale factor above which nothing is stated


@dataclass(frozen=True, slots=True, eq=False)
class CertainDwell:
    """A dwell in a ``position`` that is certain: gyro rates (3,) and 1 sigma (3,) [count/s], raw."""

    position: int
    rate: FloatArray
    std: FloatArray


@dataclass(frozen=True, slots=True)
class QuarterHeading:
    """The likeliest of four headings, a quarter turn apart.

    ``quarter`` counts them counter-clockwise seen from above from the face's first position; ``position`` is None
    where the cube stands 90 deg off both positions of its face. ``margin`` is -2 log of the likelihood ratio of
    the next candidate to it.
    """

    position: int | None
    quarter: int
    is_sure: bool
    margin: float


def find_heading(
    rate: FloatArray,
    std: FloatArray,
    face: str,
    latitude: float,
    C_sb: FloatArray,
    known: Sequence[CertainDwell] = (),
    bias_std: float = BIAS_STD_RAD_S,
) -> QuarterHeading:
    """Find which of four headings a cube has that rests with ``face`` up.

    Sure is: the best candidate fits (`MISFIT_P_VALUE`), and every other fits worse by `MIN_LIKELIHOOD_MARGIN`. By
    Ville's inequality, however often one looks at a dwell, a likelihood ratio of ``exp(MIN_LIKELIHOOD_MARGIN /
    2)`` against the truth is less likely than ``exp(-MIN_LIKELIHOOD_MARGIN / 2)`` = 1e-13. A false decision in 1e6
    would ask for 30; the rest is for units worse than ``bias_std`` says: three biases of three times that strain
    the truth by 27.

    Parameters
    ----------
    rate, std : (3,) float64, count/s
        The gyros in this dwell so far, IMU axes, raw, with 1 sigma.
    face : the cube axis that points up, such as ``x_down``
    latitude : rad
    C_sb : (3, 3), takes the cube's axes to the IMU's
    known : dwells of this unit, since it was switched on, whose position is certain
    bias_std : rad/s, 1 sigma of a gyro's bias
    """
    first = first_position(face)
    before = [earth_rate_at(each.position, latitude, C_sb) for each in known]
    rates = np.array([*(each.rate for each in known), rate])
    stds = np.array([*(each.std for each in known), std])
    candidates = [np.array([*before, earth_rate_at(first, latitude, C_sb, quarter)]) for quarter in range(4)]
    fits = [_fit(rates, stds, u, bias_std) for u in candidates]
    best, second = np.argsort([fit.cost for fit in fits])[:2]
    margin = fits[second].cost - fits[best].cost
    is_like = fits[best].chi2 < chdtri(rates.size - 1, MISFIT_P_VALUE)  # of which the scale factor takes one
    position = {0: first, 2: first + 1}.get(int(best))
    return QuarterHeading(position, int(best), bool(is_like and margin > MIN_LIKELIHOOD_MARGIN), float(margin))


def rough_scale_factor(
    known: Sequence[CertainDwell], latitude: float, C_sb: FloatArray
) -> tuple[float, float] | None:
    """Return the gyros' scale factor [count/rad] and its relative 1 sigma, roughly, from dwells alone.

    None while the dwells do not determine it to within a half, or contradict each other. ``latitude`` in rad;
    ``C_sb`` (3, 3) takes the cube's axes to the IMU's.
    """
    if not known:
        return None
    u = np.array([earth_rate_at(each.position, latitude, C_sb) for each in known])
    fit = _fit(np.array([k.rate for k in known]), np.array([k.std for k in known]), u, BIAS_STD_RAD_S)
    fits = fit.chi2 < chdtri(u.size - 1, MISFIT_P_VALUE) and fit.std < MAX_RELATIVE_SCALE_STD * fit.s
    return (1 / fit.s, fit.std / fit.s) if fits else None


def heading_change(
    before: CertainDwell, after: CertainDwell, latitude: float, C_sb: FloatArray, k: float
) -> tuple[float, float]:
    """Return how far the cube turned [rad], counter-clockwise seen from above, between two rests, and 1 sigma.

    Both rests are in, or near, ``before.position``. The bias drops out of the difference; a heading error is a
    difference of the horizontal Earth rate as the cube sees it, along East for a small one:
    ``dr = k W cos(lat) sin(change)``. Good for angles below 90 deg. The sigma is infinite at the poles.

    ``C_sb`` (3, 3) takes the cube's axes to the IMU's. ``k`` is the gyros' scale factor [count/rad], of which a
    few per cent are enough.
    """
    up = face_normal(face_of(before.position))
    north = nominal_C_lb(before.position).T @ np.array([0.0, 1.0, 0.0])
    east = np.cross(north, up)
    horizontal = EARTH_RATE * np.cos(latitude)
    difference = C_sb.T @ (after.rate - before.rate) / k
    variance = (C_sb.T**2) @ (before.std**2 + after.std**2) / k**2
    # a cube turned counter-clockwise sees North turn clockwise, towards what pointed East
    along = np.array([horizontal + difference @ north, difference @ east])
    if not horizontal > 0:
        return 0.0, np.inf
    return float(np.arctan2(along[1], along[0])), float(np.sqrt(variance @ east**2) / horizontal)


def attitude_at_rest(force: FloatArray, rate: FloatArray) -> FloatArray | None:
    """Return ``C_nb`` (3, 3) of a unit at rest: up along its specific force, North along its rate's level part.

    ``force`` and ``rate`` (3,), body axes, any unit, are without bias. None where the rate has no level part.
    """
    up = force / np.linalg.norm(force)
    level = rate - up * (up @ rate)
    if not (size := np.linalg.norm(level)) > 0:
        return None
    north = level / size
    return np.stack((np.cross(north, up), north, up))


def first_position(face: str) -> int:
    """Return the first of the two positions 1..12 that a face has."""
    return next(p for p in range(1, 13, 2) if face_of(p) == face)


@cache
def turned_position(face: str, quarter: int) -> int:
    """Return the position 1..24 with ``face`` up, ``quarter`` turns counter-clockwise from its first."""
    C_lb = vertical_rotation(quarter * np.pi / 2) @ nominal_C_lb(first_position(face))
    here = [p for p in range(1, len(ATTITUDES) + 1) if face_of(p) == face]
    return max(here, key=lambda p: float(np.sum(nominal_C_lb(p) * C_lb)))


def quarters_to(position: int, quarter: int) -> int:
    """Return the quarter turns, counter-clockwise and 0 to 3, that lead from ``quarter`` of its face there."""
    own = next(q for q in range(4) if turned_position(face_of(position), q) == position)
    return (own - quarter) % 4


def earth_rate_at(position: int, latitude: float, C_sb: FloatArray, quarter: int = 0) -> FloatArray:
    """Return the Earth's rate (3,) [rad/s], IMU axes, ``quarter`` turns counter-clockwise from ``position``.

    ``latitude`` in rad; ``C_sb`` (3, 3) takes the cube's axes to the IMU's.
    """
    C_bl = nominal_C_lb(position).T @ vertical_rotation(-quarter * np.pi / 2)
    return C_sb @ C_bl @ earth_rate_n(latitude)


@dataclass(frozen=True, slots=True)
class _Fit:
    """The likeliest s = 1 / k [rad/count], its 1 sigma, chi2 there, and -2 log likelihood up to a constant."""

    s: float
    std: float
    chi2: float
    cost: float


def _fit(rate: FloatArray, std: FloatArray, u: FloatArray, bias_std: float) -> _Fit:
    """Fit one s to dwells (n, 3) at Earth rates ``u`` (n, 3) [rad/s]; the variance moves little with it."""
    n = len(rate)
    r, w, variance = rate.T[:, :, None], u.T[:, :, None], std.T**2  # gyro by gyro
    own = (
        bias_std**2
        + SCALE_SPREAD**2 * (w @ w.transpose(0, 2, 1))
        + (EARTH_RATE_SLACK * EARTH_RATE) ** 2 * np.eye(n)
    )
    s = float(np.linalg.norm(u)) / max(float(np.linalg.norm(rate)), 1e-9)
    for _ in range(SCALE_ITERATIONS):
        covariance = own + s**2 * variance[:, :, None] * np.eye(n)
        white = np.linalg.inv(covariance)
        a = max(float(np.sum(r.transpose(0, 2, 1) @ white @ r)), 1e-9)
        b = float(np.sum(r.transpose(0, 2, 1) @ white @ w))
        s = (b + np.sqrt(b**2 + 12 * n * a)) / (2 * a)  # where a s^2 - 2 b s - 6 n log s is least
    left = s * r - w
    chi2 = float(np.sum(left.transpose(0, 2, 1) @ white @ left))
    cost = chi2 + float(np.linalg.slogdet(covariance)[1].sum()) - 6 * n * np.log(s)
    return _Fit(s, a**-0.5, chi2, cost)


MAX_EARTH_RATE_SIGMAS = 4.0  # sigma


def earth_heading(
    rate: FloatArray, std: FloatArray, C_lb: FloatArray, latitude: float, C_sb: FloatArray, k: float,
    known: Sequence[CertainDwell] = (),
) -> tuple[float, float]:  # fmt: skip
    """Return how far the cube's heading is off [rad], counter-clockwise seen from above, and 1 sigma.

    The rate less the bias should be ``(0, W cos lat, W sin lat)`` in the slab's axes: its level part points North.
    Turned so far the cube points as ``C_lb`` says. The sigma is infinite where the rate is not the Earth's.

    Parameters
    ----------
    rate, std : (3,) float64, count/s
        The gyros at rest, IMU axes, raw, with 1 sigma.
    C_lb : (3, 3), the cube's axes to East, North, Up, right but for the heading
    latitude : rad
    C_sb : (3, 3), takes the cube's axes to the IMU's
    k : the gyros' scale factor [count/rad]
    known : dwells of this unit, since it was switched on, whose position is certain
    """
    bias, bias_var = _bias(latitude, C_sb, k, known)
    found = rate / k - bias
    variance = (std / k) ** 2 + bias_var + (EARTH_RATE_SLACK * EARTH_RATE) ** 2 + (SCALE_SPREAD * found) ** 2
    seen, seen_var = C_lb @ C_sb.T @ found, (C_lb @ C_sb.T) ** 2 @ variance
    earth = earth_rate_n(latitude)
    level = float(np.hypot(seen[0], seen[1]))
    level_std = float(np.sqrt(max(seen_var[:2])))
    off = np.abs([level - earth[1], seen[2] - earth[2]]) / np.array([level_std, np.sqrt(seen_var[2])])
    if not (off < MAX_EARTH_RATE_SIGMAS).all() or not earth[1] > 0:
        return 0.0, np.inf
    return float(np.arctan2(seen[0], seen[1])), level_std / float(earth[1])


def _bias(
    latitude: float, C_sb: FloatArray, k: float, known: Sequence[CertainDwell]
) -> tuple[FloatArray, FloatArray]:
    """Return the gyros' biases (3,) [rad/s] and their variances (3,)."""
    weight, total = np.full(3, BIAS_STD_RAD_S**-2), np.zeros(3)
    for each in known:
        u = earth_rate_at(each.position, latitude, C_sb)
        of_dwell = 1 / ((each.std / k) ** 2 + (EARTH_RATE_SLACK * EARTH_RATE) ** 2 + (SCALE_SPREAD * u) ** 2)
        weight, total = weight + of_dwell, total + of_dwell * (each.rate / k - u)
    return total / weight, 1 / weight
