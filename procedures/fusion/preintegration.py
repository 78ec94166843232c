"""IMU samples between two keyframes as one measurement, with its covariance and how it depends on the biases.

In the axes b of the first keyframe, with constant biases and the Earth's rate corrected,

    dC = prod exp((omega - bg) dt),   dv = int C (f - ba) dt,   dp = int int C (f - ba) dt2

(Forster, Carlone, Dellaert, Scaramuzza 2017). An error of a sample carries to the end in closed form, so that
covariance and bias Jacobians are sums over the samples and nothing recurs: a turn e at the middle of sample k
turns what follows, ``dv_err = -(dv - dv_k) x C_k e`` and ``dp_err = -(dp - dp_k - dv_k (T - t_k)) x C_k e``.

`InertialIncrements` are those of samples integrated from one instant. With ``b0`` the body at that instant,

    C_k = C_b0b(t_k),   alpha_k = int C (f - ba) dt,   Phi_k = int C dt,
    d alpha / d ba = -Phi,   d alpha / d bg = int [C (f - ba)]x Phi dt

Samples are taken as straight lines between their times; an interval's attitude is that of its middle. A gap in the
samples (`ImuGap`) is bridged by the line between its ends; the error of such a line is that which the recording
itself shows over as long a time.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, interpolated
from procedures.frames import rotation, rotation_vector, skew
from procedures.fusion.fusion_records import ImuNoise, ImuSeries


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
        The Earth's rate in b0, where it is to be corrected: 1e-4 rad/s by the attitudes that still have it.
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


END_RATE_SAMPLES = 6


@dataclass(frozen=True, slots=True, eq=False)
class Preintegrated:
    """``dt`` [s], ``turn`` (3, 3), ``dv`` (3,) [m/s], ``dp`` (3,) [m] for biases ``bg`` and ``ba``.

    The Earth's rate counts as bias: it is in ``bg``.
    ``by_bias`` (9, 6) is their derivative by gyro and accelerometer bias, rows rotation (right), velocity,
    position; ``info`` (9, 9) the inverse of the covariance in the same order. ``dv_from`` (m + 1, 3) is the
    velocity increment up to each edge ``edges`` (m + 1,) [s] of the samples; ``rates`` (2, 3) [rad/s] are those
    in b at its beginning and its end.
    """

    dt: float
    turn: FloatArray
    dv: FloatArray
    dp: FloatArray
    bg: FloatArray
    ba: FloatArray
    by_bias: FloatArray
    info: FloatArray
    edges: FloatArray
    dv_from: FloatArray
    rates: FloatArray


def preintegrate(
    part: ImuGrid, bg: FloatArray, ba: FloatArray, earth_b: FloatArray, noise: ImuNoise
) -> Preintegrated:
    """Preintegrate all intervals of ``part``.

    Parameters
    ----------
    bg, ba, earth_b : (3,), rad/s, m/s2, rad/s
        Gyro and accelerometer bias, and the Earth's rate in the first b.
    """
    dt = part.dt[:, None]
    turn = (part.omega_b - bg - earth_b) * dt
    C = products(rotation(turn))
    middle = C[:-1] @ rotation(turn / 2)
    v = _summed(np.einsum("nij,nj->ni", middle, part.f_b - ba) * dt)
    p, edges = _summed((v[:-1] + v[1:]) / 2 * dt), _summed(part.dt)
    left = (edges[-1] - (edges[1:] + edges[:-1]) / 2)[:, None]
    v_mid, p_mid = (v[1:] + v[:-1]) / 2, (p[1:] + p[:-1]) / 2
    G = np.zeros((len(dt), 9, 6))
    G[:, :3, :3] = C[-1].T @ middle
    G[:, 3:6, :3] = -skew(v[-1] - v_mid) @ middle
    G[:, 6:, :3] = -skew(p[-1] - p_mid - v_mid * left) @ middle
    G[:, 3:6, 3:] = middle
    G[:, 6:, 3:] = middle * left[:, :, None]
    G *= dt[:, :, None]
    # white noise of density N has the variance N2 / dt over a sample
    scaled = G / np.sqrt(dt)[:, :, None] * np.repeat([noise.gyro, noise.accel], 3)
    covariance = np.einsum("nij,nkj->ik", scaled, scaled)
    return Preintegrated(
        float(edges[-1]), C[-1], v[-1], p[-1], bg + earth_b, ba, -G.sum(axis=0), _inverse(covariance, edges[-1]),
        edges, v, _rates(turn, dt),
    )  # fmt: skip


def _rates(turn: FloatArray, dt: FloatArray) -> FloatArray:
    """Return the rates at both ends, each the mean of `END_RATE_SAMPLES` samples: one alone is vibration."""
    ends = (slice(END_RATE_SAMPLES), slice(-END_RATE_SAMPLES, None))
    return np.array([turn[part].sum(axis=0) / dt[part].sum() for part in ends])


def _inverse(covariance: FloatArray, dt: float) -> FloatArray:
    """Invert, with a floor for the position: over one sample it is all but a function of the velocity."""
    covariance[range(6, 9), range(6, 9)] += 1e-8 * dt  # m2, as of integrating in straight lines
    size = np.sqrt(np.diag(covariance))
    scale = np.outer(size, size)
    return np.asarray(np.linalg.inv(covariance / scale) / scale, np.float64)


RATE_HALF_SPAN_S = 0.03  # s about a moment, over which its rate is taken: a sample alone is vibration


class GyroRotations:
    """Samples integrated once with a constant bias [rad/s], then asked at any times.

    Rates are straight between samples; within an interval its mean rate is taken.
    """

    def __init__(self, imu: ImuSeries, bias: FloatArray) -> None:
        dt = np.diff(imu.t)[:, None]
        self.t, self._rate = imu.t, (imu.omega_b[1:] + imu.omega_b[:-1]) / 2 - bias
        self._C = products(rotation(self._rate * dt))
        middle = self._C[:-1] @ rotation(self._rate * dt / 2)
        self._Phi = _summed(middle * dt[:, :, None])

    def turned(self, t0: FloatArray, t1: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return C_10 (n, 3, 3), from b at ``t0`` to b at ``t1`` (n,) [s], and its left turn by the bias."""
        (C0, Phi0), (C1, Phi1) = self._at(t0), self._at(t1)
        back = np.swapaxes(C1, 1, 2)
        return back @ C0, back @ (Phi1 - Phi0)

    def rate(self, t: FloatArray) -> FloatArray:
        """Return the mean rates (n, 3) [rad/s] in b about the times ``t`` (n,) [s]."""
        turned, _ = self.turned(t + RATE_HALF_SPAN_S, t - RATE_HALF_SPAN_S)
        return rotation_vector(turned) / (2 * RATE_HALF_SPAN_S)

    def _at(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        k = np.clip(np.searchsorted(self.t, t, "right") - 1, 0, len(self._rate) - 1)
        since = (t - self.t[k])[:, None]
        return self._C[k] @ rotation(self._rate[k] * since), self._Phi[k] + self._C[k] * since[:, :, None]


MIN_GAP_PERIODS = 5.0  # of the samples, from which a step is a gap: what is shorter a line follows


@dataclass(frozen=True, slots=True)
class ImuGap:
    """From ``first`` to ``last`` [s]; 1 sigma of the mean rate [rad/s] and specific force [m/s2] of the line."""

    first: float
    last: float
    rate_std: float
    force_std: float

    @property
    def length(self) -> float:
        """How long it is [s]."""
        return self.last - self.first


def imu_gaps(imu: ImuSeries) -> tuple[ImuGap, ...]:
    """Return the gaps of a recording."""
    dt = np.diff(imu.t)
    period = float(np.median(dt))
    return tuple(
        ImuGap(float(imu.t[i]), float(imu.t[i + 1]), _missed(imu.omega_b, n), _missed(imu.f_b, n))
        for i in np.flatnonzero(dt > MIN_GAP_PERIODS * period)
        if (n := min(round(dt[i] / period), len(dt)))
    )


def _missed(values: FloatArray, n: int) -> float:
    """Return the rms, of an axis, of the mean of n + 1 samples less that of the first and the last of them."""
    total = _summed(values)
    mean = (total[n + 1 :] - total[: -n - 1]) / (n + 1)
    ends = (values[n:] + values[: len(values) - n]) / 2
    return float(np.sqrt(np.mean((mean - ends) ** 2)))
