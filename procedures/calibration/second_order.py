"""What tilts that a campaign leaves open move k, E and D by in second order.

Where slab or faces are only known to be level within a plausible range, as the slab is with one heading a face, k,
E and D hang on the tilt that was found. Solved anew for each tilt ``z`` they are ``f(0) + g z + z H z / 2``. The
fit's covariance holds g; where g is small at the tilt that was found, H is what is left. For z of unit normals
``E[(z H z / 2)^2] = tr(H H) / 2 + (tr H)^2 / 4`` (moments of a quadratic form; JCGM 100:2008, 5.1.2, note).
"""

from collections.abc import Callable

import numpy as np

from procedures.arrays import FloatArray
from procedures.dwells_and_turns.twelve_position import TriadFit, specific_force

OPEN_TILT_RAD = 3e-4  # rad, 1 sigma: half its square is 0.05 ppm


def second_order(joint: TriadFit, value: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Return the covariance (15, 15) that open tilts add in second order; zero where none is open.

    ``value`` takes parameters (p,) as the fit's to k (3), E (9), D (3). A fit with rests in free attitudes knows K
    without the bench: nothing is added.
    """
    bench, x = joint.bench, joint.fit.x
    none = np.zeros((15, 15))
    if not joint.seen.dwells or joint.rests is not None or joint.quadratic or joint.is_turned_freely:
        return none
    shared = slice(12, 12 + bench.shared)
    variance, ways = np.linalg.eigh(joint.fit.covariance[shared, shared])
    is_open = variance > OPEN_TILT_RAD**2
    if not is_open.any():
        return none
    steps = (np.sqrt(variance[is_open]) * ways[:, is_open]).T

    def at(step: FloatArray) -> FloatArray:
        moved = x.copy()
        moved[shared] += step
        moved[:12] = _solved(joint, moved[12 : 12 + bench.size])
        return value(moved)

    level = at(np.zeros(bench.shared))

    def bend(step: FloatArray) -> FloatArray:
        return (at(step) + at(-step)) / 2 - level

    own = [bend(step) for step in steps]
    H = np.array([
        [bend(a + b) - own[i] - own[j] if i != j else 2 * own[i] for j, b in enumerate(steps)]
        for i, a in enumerate(steps)
    ])  # fmt: skip
    trace = np.einsum("iia->a", H)
    found: FloatArray = np.einsum("ija,ijb->ab", H, H) / 2 + np.outer(trace, trace) / 4
    return found


def _solved(joint: TriadFit, bench: FloatArray) -> FloatArray:
    """Return K (9) and b (3) that the dwells' rates give on a bench with these parameters (p,)."""
    u = specific_force(joint.bench, bench)
    A = np.column_stack((u, np.ones(len(u))))
    weight = 1 / joint.sigma
    channels = zip(weight.T, joint.seen.rate.T, strict=True)
    rows = [np.linalg.lstsq(A * w[:, None], r * w, rcond=None)[0] for w, r in channels]
    return np.concatenate((*(row[:3] for row in rows), [row[3] for row in rows]))
