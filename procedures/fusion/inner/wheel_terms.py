"""What a wheel says of a keyframe: residuals and their derivatives into normal equations.

A wheel that rolls tells the speed of its place along forward f, up to a scale factor 1 + k,

    r = f_1 . C' v - due - (1 + k) w,          at rest     r = C' v

with the keyframe's attitude C and velocity v. What the wheel said between two keyframes is carried to the later
one by the IMU: ``f_1`` is forward then in the later axes, and ``due`` what was gained since, less the swing of the
wheel's place about the IMU. Nothing is said across forward: a constraint of that (non-holonomic) is not Han's,
and holds for no place but one on the unsteered axle.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray, interpolated
from procedures.frames import skew
from procedures.fusion.imu.preintegration import Preintegrated
from procedures.fusion.inner.window_state import FRAME, OWN, WHEEL_OWN, Normal, WindowState
from procedures.fusion.wheel_speeds import KeyframeWheel, WheelMount, WheelSpeeds


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
        JtW = np.swapaxes(J, 1, 2) * weight[:, None, :]
        normal.add(JtW @ J, (JtW @ r[..., None])[..., 0])


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
    # what it should tell, not what it tells: multiplied by itself its noise would draw the scale factor down
    J[:, 0, WHEEL_OWN] = -r[:, 0] / (1 + state.wheel)
    r[:, 0] -= (1 + state.wheel) * speed
    J[:, :, OWN : OWN + 3] = rows @ skew(v_b)
    J[:, :, OWN + 6 : OWN + 9] = rows @ np.swapaxes(C, 1, 2)
    weight = np.array([[wheel.weight, *[wheel.rest_weight] * 3] for wheel in wheels])
    return r, J, weight
