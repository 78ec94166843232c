"""The latitude that the gyroscopes measure: the Earth's rate in the dwells, held against that of the stated site.

In East-North-Up the Earth's rate is ``Omega (0, cos L, sin L)`` (Titterton and Weston, *Strapdown Inertial
Navigation Technology*, 3.5.3; gyrocompassing, 10.3). The joint fit takes L for known. What its whitened residual r
has of another rate follows by one more linear step, since the outputs are linear in that rate:

    min | r + J dx + R (dh, G) |^2,    G (3, 3) a bias per specific force

``dh`` is the change of the horizontal rate, ``tr G / 3`` that of the vertical one: a bias that is proportional to
gravity along each axis cannot be told from it. What the other eight numbers of G show of the unit's sensitivity to
gravity is the 1 sigma of that. Bias is in dx, told apart as the cube stands on opposite faces and headings.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.dwells_and_turns.gyroscopes_joint_fit import GyroscopeFit
from procedures.earth.gravity_and_rate import EARTH_RATE
from procedures.units import RAD_S_PER_DEG_H

OTHER_BIAS_STD = 0.1 * RAD_S_PER_DEG_H  # rad/s: what the Earth's magnetic field does to a gyroscope unnoticed
CONTRADICTION = 4.5  # sigma
LEAST_FREE = 6  # degrees of freedom that judge the scatter
GRID = np.radians(np.linspace(-90.0, 90.0, 3601))


@dataclass(frozen=True, slots=True)
class MeasuredLatitude:
    """The latitude measured and its 1 sigma, that stated [rad], and by how many sigma the rates contradict it."""

    value: float
    std: float
    stated: float
    sigmas: float

    @property
    def contradicts(self) -> bool:
        """Whether the stated site is not where the gyroscopes were."""
        return self.sigmas > CONTRADICTION


def measured_latitude(gyroscope: GyroscopeFit) -> MeasuredLatitude | None:
    """Return the latitude that a joint fit's residual shows; None where campaigns differ in it or rows are few."""
    joint = gyroscope.joint
    campaigns = joint.bench.campaigns
    stated = {campaign.site.latitude for campaign in campaigns}
    if len(stated) != 1:
        return None
    latitude = stated.pop()
    n = joint.sigma.size
    weight = np.ones(len(joint.fit.residual))
    weight[:n] = (joint.sigma / joint.expected).ravel()  # without the scatter that a wrong latitude itself makes
    added = np.stack([_rows(gyroscope, rate) for rate in _rates(gyroscope)], axis=1)
    absorbed = np.zeros((len(weight), joint.profiled))
    absorbed[: len(joint.absorbed)] = joint.absorbed
    A = np.hstack([added, joint.fit.jacobian, absorbed]) * weight[:, None]
    size = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
    U, s, Vt = np.linalg.svd(A / size, full_matrices=False)
    seen = s > 1e-9 * s[0]
    free = len(weight) - int(seen.sum())
    if free < LEAST_FREE or not seen.all():
        return None
    r = joint.fit.residual * weight
    found = -(Vt.T / s) @ (U.T @ r)
    left = r + (A / size) @ found
    scale = max(float(left @ left) / free, 1.0)
    cov = scale * (Vt.T / s**2) @ Vt / np.outer(size, size)
    found = found / size
    G = found[1:10].reshape(3, 3)
    c = float(np.trace(G)) / 3
    pick = np.zeros(len(found))
    pick[[1, 5, 9]] = 1 / 3
    others = float(np.sqrt(np.sum((G - c * np.eye(3)) ** 2) / 8))
    std_h = float(np.hypot(np.radians(np.sqrt(cov[0, 0])), OTHER_BIAS_STD))
    std_v = float(np.hypot(np.hypot(np.radians(np.sqrt(pick @ cov @ pick)), np.radians(others)), OTHER_BIAS_STD))
    h = EARTH_RATE * np.cos(latitude) + np.radians(found[0])
    v = EARTH_RATE * np.sin(latitude) + np.radians(c)
    return _latitude(float(h), float(v), std_h, std_v, latitude)


def _latitude(h: float, v: float, std_h: float, std_v: float, stated: float) -> MeasuredLatitude:
    """Return the latitude whose Earth rate is nearest to ``h`` and ``v`` [rad/s], by their 1 sigma."""

    def chi2(at: FloatArray) -> FloatArray:
        return np.asarray(
            ((h - EARTH_RATE * np.cos(at)) / std_h) ** 2 + ((v - EARTH_RATE * np.sin(at)) / std_v) ** 2
        )

    best = float(GRID[int(np.argmin(chi2(GRID)))])
    size = EARTH_RATE**2 * (np.sin(best) ** 2 / std_h**2 + np.cos(best) ** 2 / std_v**2)
    more = float(chi2(np.array(stated)) - chi2(GRID).min())
    return MeasuredLatitude(best, float(1 / np.sqrt(size)), stated, float(np.sqrt(max(more, 0.0))))


def _rates(gyroscope: GyroscopeFit) -> list[FloatArray]:
    """Return ten rates (m, 3) [deg/s; of a turn deg], IMU axes: 1 deg/s to the north, then 1 deg/s/g of each G."""
    joint = gyroscope.joint
    bench, dwells = joint.bench, len(joint.seen.dwells)
    motion = np.stack([np.eye(3)] * dwells + [shape.motion for shape in gyroscope.geometry])
    x = joint.fit.x[12 : 12 + bench.size]
    north, up = (
        bench.seen_by_imu(x, [vector] * len(bench.campaigns), motion)
        for vector in (np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    )
    found = [north]
    for i in range(3):
        for j in range(3):
            rate = np.zeros_like(up)
            rate[:, i] = up[:, j]
            found.append(rate)
    return found


def _rows(gyroscope: GyroscopeFit, rate: FloatArray) -> FloatArray:
    """Return the change of the whitened residual (n,) by modelled rates (m, 3) of dwells, integrals of turns."""
    sigma = np.concatenate((gyroscope.joint.sigma, gyroscope.turn_sigma))
    rows = np.zeros(len(gyroscope.joint.fit.residual))
    change = -rate @ gyroscope.joint.K.T / sigma  # the residual is observed less modelled
    rows[: change.size] = change.ravel()
    return rows
