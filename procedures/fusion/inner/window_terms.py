"""Residuals of a window of keyframes by IMU, GNSS fixes and wheel, and their derivatives into normal equations.

*IMU*, between keyframes i and j (Forster, Carlone, Dellaert, Scaramuzza 2017; Han's eq. 8 as its reference has
it):

    log(dC' C_i' C_j),   C_i' (v_j - v_i - g dt) - dv,   C_i' (p_j - p_i - v_i dt - g dt2 / 2) - dp,   b_j - b_i

with ``g`` gravity and the Coriolis acceleration. The Earth's rate in b acts as a bias of the gyro that turns with
the keyframe.

*Fixes*. With the heading R of the window's frame, the antenna's lever arm l and velocity S l in b, and the offset
tau that GNSS's stamps lack (within tau the motion is straight; the velocity's residual is Han's, ``R v_k -
v_gnss``, with the antenna's swing),

    velocity   R (v + C S l) + a tau - z_v,      position   R (p + C l + v tau) - z_p

*Wheel*. A wheel that rolls measures the speed of its place along forward f, up to a scale factor 1 + k,

    r = f_1 . C' v - due - (1 + k) w,          at rest     r = C' v

with the keyframe's attitude C and velocity v. A speed measured between two keyframes is carried to the later one
by the IMU: ``f_1`` is forward then in the later axes, and ``due`` what was gained since, less the swing of the
wheel's place about the IMU. Nothing is assumed across forward.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray, interpolated
from procedures.frames import rotation, rotation_vector, skew
from procedures.fusion.fusion_records import ImuNoise, KeyframeWheel, WheelMount, WheelSpeeds
from procedures.fusion.gnss_velocity import KeyframeFix
from procedures.fusion.inner.window_state import FRAME, OWN, WHEEL_OWN, Normal, WindowState
from procedures.fusion.pose_graph_terms import rz
from procedures.fusion.preintegration import Preintegrated

# of what is known of a bias, that it walks in a root of a second at least: else Cholesky fails
MIN_WALK_RATIO = 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """``gravity`` [m/s2], ``earth_n`` (3,) [rad/s], and the noise of the IMU."""

    gravity: float
    earth_n: FloatArray
    noise: ImuNoise

    def shaken(self, gyro: float, accel: float) -> "Site":
        """Return it with the IMU's white noise times factors: what carries the IMU shakes it."""
        noise = replace(self.noise, gyro=gyro * self.noise.gyro, accel=accel * self.noise.accel)
        return replace(self, noise=noise)

    def pull(self, v: FloatArray) -> FloatArray:
        """Return gravity and Coriolis acceleration (..., 3) [m/s2] at velocities ``v`` (..., 3) [m/s], frame o."""
        return np.array([0.0, 0.0, -self.gravity]) + 2 * v @ skew(self.earth_n)


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
    normal.add(r, J, np.swapaxes(J, 1, 2) @ info)


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
    gyro = max(noise.gyro_walk, MIN_WALK_RATIO * noise.gyro_bias)
    return np.repeat([gyro, max(noise.accel_walk, MIN_WALK_RATIO * noise.accel_bias)], 3)


def add_fixes(normal: Normal, state: WindowState, fixes: Sequence[KeyframeFix]) -> None:
    """Add what GNSS says of the first keyframes."""
    if any(fix.v_weight.any() or fix.p_weight.any() for fix in fixes):
        r, J, weight = fix_residuals(state, range(len(fixes)), fixes)
        normal.add(r, J, np.swapaxes(J, 1, 2) * weight[:, None, :])


def fix_residuals(
    state: WindowState, frames: Sequence[int], fixes: Sequence[KeyframeFix]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return residuals (f, 6), Jacobians (f, 6, 22) by `SHARED` and keyframe, weights (f, 6): m/s, then m."""
    R, dR = rz(np.array(state.heading))
    C, p, v = (each[list(frames)] for each in (state.C_ob, state.p, state.v))
    lever = np.array([fix.lever for fix in fixes]) + state.antenna[:3]
    late = np.array([fix.age for fix in fixes])[:, None] + state.antenna[3]
    swing, a = np.array([fix.swing for fix in fixes]), np.array([fix.a for fix in fixes])
    swung = np.einsum("kij,kj->ki", swing, lever)
    v_there = v + np.einsum("kij,kj->ki", C, swung)
    there = p + np.einsum("kij,kj->ki", C, lever) + v * late
    z = np.hstack((np.array([fix.v for fix in fixes]), np.array([fix.p for fix in fixes])))
    J = np.zeros((len(fixes), 6, OWN + FRAME))
    J[:, :3, 0], J[:, 3:, 0] = v_there @ dR.T, there @ dR.T
    J[:, :3, 2:5], J[:, :3, 5] = R @ C @ swing, a
    J[:, 3:, 2:5], J[:, 3:, 5] = R @ C, v @ R.T
    K = J[:, :, OWN:]
    K[:, :3, :3], K[:, :3, 6:9] = -R @ C @ skew(swung), R
    K[:, 3:, :3], K[:, 3:, 3:6], K[:, 3:, 6:9] = -R @ C @ skew(lever), R, R * late[:, :, None]
    weight = np.hstack((np.array([fix.v_weight for fix in fixes]), np.array([fix.p_weight for fix in fixes])))
    return np.hstack((v_there @ R.T + a * state.antenna[3], there @ R.T)) - z, J, weight


def at_end(
    speeds: WheelSpeeds, mount: WheelMount, t0: float, part: Preintegrated, pull_b: FloatArray
) -> KeyframeWheel | None:
    """Return what all ``speeds``, of times within ``part``, say at its end; None where there are none.

    ``t0`` [s] is the time at its beginning, ``pull_b`` (3,) [m/s2] gravity and Coriolis acceleration in the axes
    at its end.
    """
    since = speeds.t - t0
    if not len(since):
        return None
    share = (since / part.dt)[:, None]
    # turned in a straight line: within 0.1 s and 0.5 rad/s that is 3e-4 of the speed at most
    along = (1 - share) * (part.turn.T @ mount.forward) + share * mount.forward
    gained = (part.dv - interpolated(since, part.edges, part.dv_from)) @ part.turn
    gained += pull_b * (part.dt - since)[:, None]
    rates = (1 - share) * part.rates[0] + share * part.rates[1]
    swing = np.cross(rates, mount.lever) @ mount.forward
    due = np.einsum("ni,ni->n", along, gained) - swing
    weight = len(since) / mount.std**2
    return KeyframeWheel(along.mean(axis=0), float(due.mean()), float(speeds.speed.mean()), weight)


def add_wheels(normal: Normal, state: WindowState, wheels: Sequence[KeyframeWheel | None]) -> None:
    """Add what a wheel says of the first keyframes."""
    if any(wheels):
        silent = KeyframeWheel(np.zeros(3), 0.0, 0.0, 0.0)
        r, J, weight = wheel_residuals(state, range(len(wheels)), [wheel or silent for wheel in wheels])
        normal.add(r, J, np.swapaxes(J, 1, 2) * weight[:, None, :])


def wheel_residuals(
    state: WindowState, frames: Sequence[int], wheels: Sequence[KeyframeWheel]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return residuals (f, 4) [m/s], speed then rest, Jacobians (f, 4, 22) by `SHARED` and keyframe, weights."""
    C, v = state.C_ob[list(frames)], state.v[list(frames)]
    v_b = np.einsum("fji,fj->fi", C, v)
    along, speed = np.array([wheel.along for wheel in wheels]), np.array([wheel.speed for wheel in wheels])
    rows = np.concatenate((along[:, None], np.broadcast_to(np.eye(3), C.shape)), axis=1)
    r = np.einsum("fij,fj->fi", rows, v_b)
    r[:, 0] -= np.array([wheel.due for wheel in wheels])
    J = np.zeros((len(wheels), 4, OWN + FRAME))
    # the predicted speed, not the measured one: multiplied by itself its noise would draw the scale factor down
    J[:, 0, WHEEL_OWN] = -r[:, 0] / (1 + state.wheel)
    r[:, 0] -= (1 + state.wheel) * speed
    J[:, :, OWN : OWN + 3] = rows @ skew(v_b)
    J[:, :, OWN + 6 : OWN + 9] = rows @ np.swapaxes(C, 1, 2)
    weight = np.array([[wheel.weight, *[wheel.rest_weight] * 3] for wheel in wheels])
    return r, J, weight
