"""Attitudes on the slab, for bench effects: what turns between the slab's marks and the IMU."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import Excitation
from procedures.frames import nominal_C_lb, rotation


def slab_C_il(excitation: Excitation, *, at_ends: bool = False) -> FloatArray:
    """Return the nominal rotation (n, 3, 3) from the slab's marks to the IMU; zeros of steps in no position.

    In a turn the heading is what the rate about the vertical came to since the step began; ``at_ends``: as a turn
    ends, and where it began.
    """
    C_il = np.zeros((len(excitation.t), 3, 3))
    for number, step in enumerate(excitation.steps):
        nodes = np.flatnonzero(excitation.step == number)
        if not step.position or not len(nodes):
            continue
        C = excitation.C_sb[nodes[0]] @ nominal_C_lb(step.position).T
        C_il[nodes] = C
        if step.kind == "turn" and not at_ends:
            rate = np.radians(excitation.omega[nodes] @ C[:, 2])
            seconds = np.gradient(excitation.rest_s[nodes])
            heading = np.cumsum(rate * seconds) - rate * seconds / 2
            about = np.zeros((len(nodes), 3))
            about[:, 2] = -heading
            C_il[nodes] = C @ rotation(about)
    return C_il


def world_rotation_columns(
    excitation: Excitation, rotation_l: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return accelerometer and gyroscope columns (n, 3, k) of small rotations of all but the slab, and those.

    The rotation vectors ``rotation_l`` (3, k) are in the slab's marks and turn gravity and Earth rate as the slab
    sees them; a hand turn's own rate stays. Nought of steps in no position.
    """
    C_il = slab_C_il(excitation)
    turned = C_il @ rotation_l
    earth = np.einsum("nil,nl->ni", C_il, _earth_l(excitation, C_il))
    accel = excitation.E_accel @ np.cross(turned, excitation.f[:, :, None], axis=1)
    gyro = excitation.E_gyro @ np.cross(turned, earth[:, :, None], axis=1)
    away = np.array([not step.position for step in excitation.steps])[excitation.step]
    accel[away], gyro[away] = 0.0, 0.0
    return accel, gyro, slab_C_il(excitation, at_ends=True) @ rotation_l


def _earth_l(excitation: Excitation, C_il: FloatArray) -> FloatArray:
    """Return the Earth rate (n, 3) [deg/s] in the slab's marks, as the campaign's rests in positions see it."""
    found = np.zeros_like(excitation.omega)
    rests = np.array([step.position > 0 and step.kind != "turn" for step in excitation.steps])[excitation.step]
    campaign = excitation.per_step("campaign")
    for number in np.unique(campaign):
        here = campaign == number
        if (seen_at := here & rests).any():
            found[here] = np.einsum("nil,ni->nl", C_il[seen_at], excitation.omega[seen_at]).mean(axis=0)
    return found
