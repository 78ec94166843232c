"""The mean cube, to which misalignment refers, and what its skew does where nobody measured it."""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.dwells_and_turns.bench_parameters import MACHINING_ITEMS_DOWN, MACHINING_ITEMS_UP
from procedures.frames import AXES, cross_axes


def mean_cube(q: FloatArray) -> FloatArray:
    """Return (3, 3): columns the unit mean normals of the face pairs for perpendicularity ``q`` (3, 2)."""
    normals = np.eye(3)
    for pair, axis in enumerate(AXES):
        normals[list(cross_axes(f"{axis}_up")), pair] = q[pair]
    unit: FloatArray = normals / np.linalg.norm(normals, axis=0)
    return unit


def mean_axes(q: FloatArray) -> FloatArray:
    """Return (3, 3): columns the axes nearest to `mean_cube` for ``q`` (3, 2) [rad], its polar factor."""
    U, _, Vt = np.linalg.svd(mean_cube(q))
    axes: FloatArray = U @ Vt
    return axes


def skew_variance(p: FloatArray, held: Sequence[bool]) -> FloatArray:
    """Return the variance (3,) [rad^2] of the skews S_xy, S_xz, S_yz of a cube whose parallelism is ``p`` (3, 2).

    An item's variance is judged from p, whose two values per pair have the pair's items between them; the factor
    is the mean of the posterior of a variance seen with that many degrees of freedom. Certified pairs add none.
    """
    free = np.asarray(held)
    items = MACHINING_ITEMS_UP + MACHINING_ITEMS_DOWN
    if not free.any():
        return np.zeros(3)
    item = np.sum((p**2 / items[:, None])[free]) / max(2 * free.sum() - 2, 1)
    q = np.where(free, item * MACHINING_ITEMS_UP * MACHINING_ITEMS_DOWN / items, 0.0)
    return np.array([q[0] + q[1], q[0] + q[2], q[1] + q[2]])


def skew_jacobian(p: FloatArray, E: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return d(k)/k (3, 3) and dD (3, 3) [g] by the skews S_xy, S_xz, S_yz [rad]; rows are sensors in cube axes.

    ``p`` (3, 2) [rad] is the cube's parallelism, ``E`` (3, 3) the misalignment, sensors and columns in cube axes.
    ``|K_q|`` changes by ``k E_qa E_qc S_ac`` as the cube's skew turns misalignment into it.
    """
    pairs = ((0, 1), (0, 2), (1, 2))
    scale = np.stack([E[:, a] * E[:, c] for a, c in pairs], axis=1)
    table = np.zeros((3, 3))
    for pair, axis in enumerate(AXES):
        table[pair, list(cross_axes(f"{axis}_up"))] = p[pair]
    bias = np.zeros((3, 3))
    for k, (a, c) in enumerate(pairs):
        bias[a, k], bias[c, k] = -table[a, c] / 2, -table[c, a] / 2
    return scale, bias
