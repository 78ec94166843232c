"""What fixes say of a window of keyframes: residuals and their derivatives into normal equations.

With the heading R of the window's frame, the antenna's lever arm l and velocity S l in b, and the offset tau that
GNSS's stamps lack,

    velocity   R (v + C S l) + a tau - z_v,      position   R (p + C l + v tau) - z_p

Within tau the motion is straight. The velocity's residual is Han's, ``R v_k - v_gnss``, with the antenna's swing.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import skew
from procedures.fusion.imu.gnss_velocity import KeyframeFix
from procedures.fusion.inner.window_state import FRAME, OWN, Normal, WindowState
from procedures.fusion.outer.pose_graph_terms import rz


def add_fixes(normal: Normal, state: WindowState, fixes: Sequence[KeyframeFix]) -> None:
    """Add what GNSS says of the first keyframes."""
    if any(fix.v_weight.any() or fix.p_weight.any() for fix in fixes):
        r, J, weight = fix_residuals(state, range(len(fixes)), fixes)
        JtW = np.swapaxes(J, 1, 2) * weight[:, None, :]
        normal.add(JtW @ J, (JtW @ r[..., None])[..., 0])


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
