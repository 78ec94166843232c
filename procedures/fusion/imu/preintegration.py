"""IMU samples between two keyframes as one measurement, with its covariance and how it depends on the biases.

In the axes b of the first keyframe, with constant biases and the Earth's rate taken off,

    dC = prod exp((omega - bg) dt),   dv = int C (f - ba) dt,   dp = int int C (f - ba) dt2

(Forster, Carlone, Dellaert, Scaramuzza 2017). An error of a sample carries to the end in closed form, so that
covariance and bias Jacobians are sums over the samples and nothing recurs: a turn e at the middle of sample k
turns what follows, ``dv_err = -(dv - dv_k) x C_k e`` and ``dp_err = -(dp - dp_k - dv_k (T - t_k)) x C_k e``.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import rotation, skew
from procedures.fusion.fusion_records import ImuNoise
from procedures.fusion.imu.inertial_increments import ImuGrid, products

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
    felt = np.einsum("nij,nj->ni", middle, part.f_b - ba) * dt
    v = np.vstack((np.zeros(3), np.cumsum(felt, axis=0)))
    p = np.vstack((np.zeros(3), np.cumsum((v[:-1] + v[1:]) / 2 * dt, axis=0)))
    edges = np.concatenate(([0.0], np.cumsum(part.dt)))
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
    inverse: FloatArray = np.asarray(np.linalg.inv(covariance / np.outer(size, size)), np.float64)
    inverse /= np.outer(size, size)
    return inverse
