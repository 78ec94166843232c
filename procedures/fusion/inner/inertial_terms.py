"""What an IMU says of a window of keyframes: residuals and their derivatives into normal equations.

Between keyframes i and j (Forster, Carlone, Dellaert, Scaramuzza 2017; Han's eq. 8 in the form of its reference):

    log(dC' C_i' C_j),   C_i' (v_j - v_i - g dt) - dv,   C_i' (p_j - p_i - v_i dt - g dt2 / 2) - dp,   b_j - b_i

with ``g`` gravity and the Coriolis acceleration. The Earth's rate in b acts as a bias of the gyro does, but turns
with the keyframe: it shows a FOG where North is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import rotation, rotation_vector, skew
from procedures.fusion.fusion_records import ImuNoise
from procedures.fusion.imu.preintegration import Preintegrated
from procedures.fusion.inner.window_state import FRAME, OWN, Normal, WindowState
from procedures.fusion.outer.pose_graph_terms import rz

STIFF = 1e-5  # of what is known of a bias, that it walks in a root of a second at least: else Cholesky fails


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """``gravity`` [m/s2], ``earth_n`` (3,) [rad/s], and the noise of the IMU."""

    gravity: float
    earth_n: FloatArray
    noise: ImuNoise

    def pull(self, v: FloatArray) -> FloatArray:
        """Return gravity and Coriolis acceleration (..., 3) [m/s2] at velocities ``v`` (..., 3) [m/s], frame o."""
        pull: FloatArray = np.array([0.0, 0.0, -self.gravity]) + 2 * v @ skew(self.earth_n)
        return pull


def predicted(state: WindowState, part: Preintegrated, site: Site) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return attitude (3, 3), position (3,) [m] and velocity (3,) [m/s] that follow the last keyframe, frame o."""
    C, p, v, dt = state.C_ob[-1], state.p[-1], state.v[-1], part.dt
    pull = site.pull(v)
    return C @ part.turn, p + v * dt + pull * dt**2 / 2 + C @ part.dp, v + pull * dt + C @ part.dv


def add_inertial(normal: Normal, state: WindowState, parts: Sequence[Preintegrated], site: Site) -> None:
    """Add the IMU between keyframes 0 and 1, 1 and 2, as many as there are ``parts``."""
    if not parts:
        return
    r, J, info = _residual(state, parts, site)
    JtW = np.swapaxes(J, 1, 2) @ info
    normal.add(JtW @ J, (JtW @ r[..., None])[..., 0])


def _residual(
    state: WindowState, parts: Sequence[Preintegrated], site: Site
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return residuals (f, 15), Jacobians (f, 15, 37) by `SHARED` and two keyframes, and weights (f, 15, 15)."""
    f = len(parts)
    R, dR = rz(np.array(state.heading))
    dt = np.array([part.dt for part in parts])[:, None]
    by_bias = np.array([part.by_bias for part in parts])
    Ct, C_j = np.swapaxes(state.C_ob[:f], 1, 2), state.C_ob[1 : f + 1]
    earth_b = Ct @ (R.T @ site.earth_n)
    bias = np.hstack((state.bg[:f], state.ba[:f]))
    moved = bias - np.hstack((np.array([part.bg for part in parts]), np.array([part.ba for part in parts])))
    moved[:, :3] += earth_b
    due = np.einsum("fij,fj->fi", by_bias, moved)
    dC = np.array([part.turn for part in parts]) @ rotation(due[:, :3])
    pull, v = site.pull(state.v[:f]), state.v[:f]
    gained = np.einsum("fij,fj->fi", Ct, state.v[1 : f + 1] - v - pull * dt)
    went = np.einsum("fij,fj->fi", Ct, state.p[1 : f + 1] - state.p[:f] - v * dt - pull * dt**2 / 2)
    r = np.hstack((
        rotation_vector(np.swapaxes(dC, 1, 2) @ Ct @ C_j),
        gained - np.array([part.dv for part in parts]) - due[:, 3:6],
        went - np.array([part.dp for part in parts]) - due[:, 6:],
        np.hstack((state.bg[1 : f + 1], state.ba[1 : f + 1])) - bias,
    ))  # fmt: skip
    J = np.zeros((f, 15, OWN + 2 * FRAME))
    K = J[:, :, OWN:]
    J[:, :9, 0] = -np.einsum("fij,fj->fi", by_bias[:, :, :3], Ct @ (dR.T @ site.earth_n))
    K[:, :3, :3], K[:, :3, FRAME : FRAME + 3] = -np.swapaxes(C_j, 1, 2) @ state.C_ob[:f], np.eye(3)
    K[:, 3:6, :3], K[:, 3:6, 6:9], K[:, 3:6, FRAME + 6 : FRAME + 9] = skew(gained), -Ct, Ct
    K[:, 6:9, :3], K[:, 6:9, 3:6], K[:, 6:9, FRAME + 3 : FRAME + 6] = skew(went), -Ct, Ct
    K[:, 6:9, 6:9] = -Ct * dt[:, :, None]
    K[:, :9, :3] -= by_bias[:, :, :3] @ skew(earth_b)
    K[:, :9, 9:FRAME] = -by_bias
    K[:, 9:, 9:FRAME], K[:, 9:, FRAME + 9 :] = -np.eye(6), np.eye(6)
    info = np.zeros((f, 15, 15))
    info[:, :9, :9] = np.array([part.info for part in parts])
    info[:, range(9, 15), range(9, 15)] = 1 / (_walk(site.noise) ** 2 * dt)
    return r, J, info


def _walk(noise: ImuNoise) -> FloatArray:
    """Return the densities (6,) of the biases' walks."""
    gyro = max(noise.gyro_walk, STIFF * noise.gyro_bias)
    return np.repeat([gyro, max(noise.accel_walk, STIFF * noise.accel_bias)], 3)
