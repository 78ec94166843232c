"""Which heading does the resting cube have: read from the Earth's rate that the gyros themselves see.

At rest in position p a gyro q counts ``r_q = k_q (u_q + b_q)`` per second, with ``u = C_ib C_bl(p) w`` the Earth's
rate ``w = Omega (0, cos lat, sin lat)`` in the IMU's axes [rad/s], ``b`` the bias [rad/s], ``k`` [count/rad].
Nothing stored is used: k is one free number, of which the gyros differ by `SPREAD`; the biases have a normal
prior. With ``s = 1 / k``, one gyro's dwells so far and the one in question obey

    s r = u + error,   cov(error) = bias_std^2 1 1' + SPREAD^2 u u' + SLACK^2 Omega^2 I + s^2 diag(std^2)

so that chi2(s) is a quadratic form, and its least value over ``s > 0`` is the square of the sigmas by which a
candidate heading strains what is known. Dwells whose position is certain make the bias drop out. Earth rate and
signs: `procedures.earth`, `procedures.frames`. The method is gyrocompassing; the rule of decision is this
project's own (docs/guiding.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from procedures.arrays import FloatArray
from procedures.earth import DEG_PER_HOUR, EARTH_RATE, earth_rate_n
from procedures.frames import cross_axes, face_normal, face_of, nominal_C_lb, vertical_rotation

BIAS_STD = DEG_PER_HOUR  # rad/s
SPREAD = 0.03  # 1 sigma of a gyro's scale factor about the unit's own
SLACK = 0.02  # 1 sigma, of the Earth's rate: misaligned gyros, and a cube set down a degree off
STRANGE = 1e-3  # probability of a chi2 above which a candidate does not fit
GAP = 60.0  # chi2 by which every other candidate must fit worse
ROUNDS = 4
ROUGH = 0.5  # relative sigma of a scale factor above which nothing is said


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """A dwell in a ``position`` that is certain: gyro rates (3,) and 1 sigma (3,) [count/s], raw."""

    position: int
    rate: FloatArray
    std: FloatArray


@dataclass(frozen=True, slots=True)
class Heading:
    """The likeliest of four headings, a quarter turn apart.

    ``quarter`` counts them counter-clockwise seen from above from the face's first position; ``position`` is None
    where the cube stands 90 deg off both positions of its face. ``margin`` is the chi2 by which the next candidate
    fits worse.
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
    C_ib: FloatArray,
    known: Sequence[Known] = (),
    bias_std: float = BIAS_STD,
) -> Heading:
    """Say which way the cube stands that rests with ``face`` up.

    Sure is: the best candidate fits (`STRANGE`), and every other fits worse by `GAP`. By Ville's inequality,
    however often one looks at a dwell, a likelihood ratio of ``exp(GAP / 2)`` against the truth is less likely
    than ``exp(-GAP / 2)`` = 1e-13. A false decision in 1e6 would ask for 30; the rest is for units worse than
    ``bias_std`` says: three biases of three times that strain the truth by 27.

    Parameters
    ----------
    rate, std : (3,) float64, count/s
        The gyros in this dwell so far, IMU axes, raw, with 1 sigma.
    face : the cube axis that points up, such as ``x_down``
    latitude : rad
    C_ib : (3, 3), takes the cube's axes to the IMU's
    known : dwells of this unit, since it was switched on, whose position is certain
    bias_std : rad/s, 1 sigma of a gyro's bias
    """
    first = first_position(face)
    before = [_earth_rate(each.position, 0, latitude, C_ib) for each in known]
    rates = np.array([*(each.rate for each in known), rate])
    stds = np.array([*(each.std for each in known), std])
    chi2 = np.array(
        [
            _fit(rates, stds, np.array([*before, _earth_rate(first, quarter, latitude, C_ib)]), bias_std)[2]
            for quarter in range(4)
        ]
    )
    best, second = np.argsort(chi2)[:2]
    margin = float(chi2[second] - chi2[best])
    fits = chi2[best] < chdtri(rates.size - 1, STRANGE)  # of which the scale factor takes one
    position = {0: first, 2: first + 1}.get(int(best))
    return Heading(position, int(best), bool(fits and margin > GAP), margin)


def scale(
    known: Sequence[Known], latitude: float, C_ib: FloatArray, bias_std: float = BIAS_STD
) -> tuple[float, float] | None:
    """Return the gyros' scale factor [count/rad] and its relative 1 sigma, roughly, from dwells alone.

    None while the dwells do not tell it to within a half.
    """
    if not known:
        return None
    u = np.array([_earth_rate(each.position, 0, latitude, C_ib) for each in known])
    s, s_std, _ = _fit(np.array([k.rate for k in known]), np.array([k.std for k in known]), u, bias_std)
    return (1 / s, s_std / s) if s_std < ROUGH * s else None


def heading_change(
    before: Known, after: Known, latitude: float, C_ib: FloatArray, k: float
) -> tuple[float, float]:
    """Return how far the cube turned [rad], counter-clockwise seen from above, between two rests, and 1 sigma.

    Both rests are in, or near, ``before.position``. The bias drops out of the difference; a heading error is a
    difference of the horizontal Earth rate as the cube sees it, along East for a small one:
    ``dr = k W cos(lat) sin(change)``. Good for angles below 90 deg. The sigma is infinite at the poles.

    ``k`` is the gyros' scale factor [count/rad], of which a few per cent are enough.
    """
    up = face_normal(face_of(before.position))
    north = nominal_C_lb(before.position).T @ np.array([0.0, 1.0, 0.0])
    east = np.cross(north, up)
    horizontal = EARTH_RATE * np.cos(latitude)
    difference = C_ib.T @ (after.rate - before.rate) / k
    variance = (C_ib.T**2) @ (before.std**2 + after.std**2) / k**2
    # a cube turned counter-clockwise sees North turn clockwise, towards what pointed East
    along = np.array([horizontal + difference @ north, difference @ east])
    if not horizontal > 0:
        return 0.0, np.inf
    return float(np.arctan2(along[1], along[0])), float(np.sqrt(variance @ east**2) / horizontal)


def first_position(face: str) -> int:
    """Return the first of the two positions 1..12 that a face has."""
    return next(p for p in range(1, 13, 2) if face_of(p) == face)


def _earth_rate(position: int, quarter: int, latitude: float, C_ib: FloatArray) -> FloatArray:
    """Return the Earth's rate (3,) [rad/s], IMU axes, ``quarter`` turns counter-clockwise from ``position``."""
    C_bl = nominal_C_lb(position).T @ vertical_rotation(-quarter * np.pi / 2)
    rate: FloatArray = C_ib @ C_bl @ earth_rate_n(latitude)
    return rate


def _fit(rate: FloatArray, std: FloatArray, u: FloatArray, bias_std: float) -> tuple[float, float, float]:
    """Return s = 1 / k [rad/count], its 1 sigma and chi2 of dwells (n, 3) at Earth rates ``u`` (n, 3) [rad/s]."""
    n = len(rate)
    r, w, variance = rate.T[:, :, None], u.T[:, :, None], std.T**2  # gyro by gyro
    own = bias_std**2 + SPREAD**2 * (w @ w.transpose(0, 2, 1)) + (SLACK * EARTH_RATE) ** 2 * np.eye(n)
    s = float(np.linalg.norm(u) / np.linalg.norm(rate)) if np.any(rate) else 0.0
    for _ in range(ROUNDS):
        white = np.linalg.inv(own + s**2 * variance[:, :, None] * np.eye(n))
        information = float(np.sum(r.transpose(0, 2, 1) @ white @ r))
        s = max(float(np.sum(r.transpose(0, 2, 1) @ white @ w)) / information, 0.0) if information > 0 else 0.0
    left = s * r - w
    return (
        s,
        information**-0.5 if information > 0 else np.inf,
        float(np.sum(left.transpose(0, 2, 1) @ white @ left)),
    )
