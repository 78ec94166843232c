"""IMU samples integrated from one instant: attitude, velocity increment, and how both depend on the biases.

With ``b0`` the body at the first instant and constant biases,

    C_k = C_b0b(t_k),   alpha_k = int C (f - ba) dt,   Phi_k = int C dt,
    d alpha / d ba = -Phi,   d alpha / d bg = int [C (f - ba)]x Phi dt

(Forster, Carlone, Dellaert, Scaramuzza 2017, in integral form). Samples are taken as straight lines between
their times; an interval's attitude is that of its middle.
"""

from dataclasses import dataclass, replace

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

    @property
    def edges(self) -> "ImuGrid":
        """The same, at all edges of its rows."""
        return replace(self, at=np.arange(len(self.dt) + 1))


def grid(imu: ImuSeries, times: FloatArray) -> ImuGrid:
    """Return the IMU from the first to the last of ``times`` (n,) [s], cut at each of them and at each sample."""
    inside = imu.t[(imu.t > times[0]) & (imu.t < times[-1])]
    edges = np.unique(np.concatenate((times, inside)))
    middle = (edges[1:] + edges[:-1]) / 2
    omega, f = (interpolated(middle, imu.t, values) for values in (imu.omega_b, imu.f_b))
    return ImuGrid(np.diff(edges), omega, f, np.searchsorted(edges, times))


@dataclass(frozen=True, slots=True, eq=False)
class InertialIncrements:
    """At n times: ``C`` (n, 3, 3), ``alpha`` (n, 3) [m/s], ``by_gyro`` (n, 3, 3) and ``by_accel`` (n, 3, 3)."""

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
    earth_b : (m, 3), rad/s
        The Earth's rate in b at the middles, where it is to be taken off.
    """
    omega = g.omega_b - gyro_bias if earth_b is None else g.omega_b - gyro_bias - earth_b
    C = products(rotation(omega * g.dt[:, None]))
    middle = C[:-1] @ rotation(omega * g.dt[:, None] / 2)
    felt = np.einsum("nij,nj->ni", middle, g.f_b - accel_bias)
    alpha = _summed(felt * g.dt[:, None])
    Phi = _summed(middle * g.dt[:, None, None])
    by_gyro = _summed(skew(felt) @ (Phi[:-1] + Phi[1:]) / 2 * g.dt[:, None, None])
    return InertialIncrements(C[g.at], alpha[g.at], by_gyro[g.at], -Phi[g.at])


def products(steps: FloatArray) -> FloatArray:
    """Return the running products (n + 1, 3, 3) of rotations ``steps`` (n, 3, 3), the first the identity."""
    n = len(steps)
    size = max(int(np.sqrt(n)), 1)  # of blocks that are multiplied side by side, then one after the other
    blocks = np.broadcast_to(np.eye(3), (-(-n // size) * size, 3, 3)).copy()
    blocks[:n] = steps
    running = blocks.reshape(-1, size, 3, 3)
    for k in range(1, size):
        running[:, k] = running[:, k - 1] @ running[:, k]
    head = np.eye(3)
    for block in running:
        block[:] = head @ block
        head = block[-1]
    return np.concatenate((np.eye(3)[None], running.reshape(-1, 3, 3)[:n]))


def _summed(parts: FloatArray) -> FloatArray:
    return np.concatenate((np.zeros((1, *parts.shape[1:])), np.cumsum(parts, axis=0)))
