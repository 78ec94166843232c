"""Velocities of a receiver that gives none, from its positions: good enough to align by."""

from dataclasses import replace

import numpy as np

from procedures.fusion.records import GnssFixes


def with_differenced_velocity(fixes: GnssFixes) -> GnssFixes:
    """Return the inner fixes with the velocity from the one before to the one after.

    Its sigma is the positions', and a quarter of what the velocity changes meanwhile: a chord is no tangent.
    """
    wide = fixes.t[2:] - fixes.t[:-2]
    v_n = (fixes.p_n[2:] - fixes.p_n[:-2]) / wide[:, None]
    legs = np.diff(fixes.p_n, axis=0) / np.diff(fixes.t)[:, None]
    bent = np.linalg.norm(np.diff(legs, axis=0), axis=1) / 4
    std = np.sqrt(fixes.position_std[2:] ** 2 + fixes.position_std[:-2] ** 2) / wide
    return replace(fixes.part(slice(1, -1)), v_n=v_n, velocity_std=np.hypot(std, bent))
