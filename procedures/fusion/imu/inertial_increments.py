"""IMU samples integrated from one instant: attitude, velocity increment, and how both depend on the biases.

With ``b0`` the body at the first instant and constant biases,

    C_k = C_b0b(t_k),   alpha_k = int C (f - ba) dt,   Phi_k = int C dt,
    d alpha / d ba = -Phi,   d alpha / d bg = int [C (f - ba)]x Phi dt

(Forster, Carlone, Dellaert, Scaramuzza 2017, in integral form). Samples are taken as straight lines between
their times; an interval's attitude is that of its middle.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, interpolated
from procedures.frames import rotation, skew
from procedures.fusion.fusion_records import ImuSeries


@dataclass(frozen=True, slots=True, eq=False)
class ImuGrid:
    """IMU between times: ``dt`` (m,) [s], ``omega_b`` and ``f_b`` (m, 3) at the middles, ``at`` (n,) ends of rows.

    ``at[k]`` counts the intervals before the k-th of the times asked for.
    """

    dt: FloatArray
    omega_b: FloatArray
    f_b: FloatArray
    at: np.ndarray


def grid(imu: ImuSeries, times: FloatArray) -> ImuGrid:
    """Return the IMU from the first to the last of ``times`` (n,) [s], cut at each of them and at each sample."""
    inside = imu.t[(imu.t > times[0]) & (imu.t < times[-1])]
    edges = np.unique(np.concatenate((times, inside)))
    middle = (edges[1:] + edges[:-1]) / 2
    omega, f = (interpolated(middle, imu.t, values) for values in (imu.omega_b, imu.f_b))
    return ImuGrid(np.diff(edges), omega, f, np.searchsorted(edges, times))


@dataclass(frozen=True, slots=True, eq=False)
class InertialIncrements:
    """At all edges of a grid: ``C`` (m + 1, 3, 3), ``alpha`` (m + 1, 3) [m/s], ``by_gyro`` and ``by_accel``
    (m + 1, 3, 3).
    """  # noqa: D205

    C: FloatArray
    alpha: FloatArray
    by_gyro: FloatArray
    by_accel: FloatArray


def integrate(
    g: ImuGrid, gyro_bias: FloatArray, accel_bias: FloatArray, earth_b: FloatArray | None = None
) -> InertialIncrements:
    """Integrate a grid.

    Parameters
    ----------
    gyro_bias, accel_bias : (3,), rad/s, m/s2
    earth_b : (3,), rad/s
        The Earth's rate in b0, where it is to be taken off: 1e-4 rad/s by the attitudes that still have it.
    """
    turn = (g.omega_b - gyro_bias) * g.dt[:, None]
    C = products(rotation(turn))
    if earth_b is not None:
        turn -= np.einsum("nji,j->ni", C[:-1], earth_b) * g.dt[:, None]
        C = products(rotation(turn))
    middle = C[:-1] @ rotation(turn / 2)
    felt = np.einsum("nij,nj->ni", middle, g.f_b - accel_bias)
    alpha = _summed(felt * g.dt[:, None])
    Phi = _summed(middle * g.dt[:, None, None])
    by_gyro = _summed(skew(felt * g.dt[:, None] / 2) @ (Phi[:-1] + Phi[1:]))
    return InertialIncrements(C, alpha, by_gyro, -Phi)


def products(steps: FloatArray) -> FloatArray:
    """Return the running products (n + 1, 3, 3) of rotations ``steps`` (n, 3, 3), the first the identity."""
    n = len(steps)
    running = np.empty((n + 1, 3, 3))
    running[0] = np.eye(3)
    if n:  # every second one is a product of pairs; those between take one step more
        running[::2] = products(steps[: n - 1 : 2] @ steps[1::2])
        running[1::2] = running[:n:2] @ steps[::2]
    return running


def _summed(parts: FloatArray) -> FloatArray:
    total = np.zeros((len(parts) + 1, *parts.shape[1:]))
    np.cumsum(parts, axis=0, out=total[1:])
    return total
