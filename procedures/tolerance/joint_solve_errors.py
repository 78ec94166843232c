"""What the joint solve finds without noise, for many cubes at once.

The solve (`procedures.dwells_and_turns.twelve_position`) fits K', b' and the tilts of six faces to the means of
six position pairs: 18 rates, 12 + 12 unknowns, of which the cube's perpendicularity is held at ``q = c p``. It can
meet every rate, so that without noise ``K' u'_f + b' = K w_f + b`` on every face, with w_f the *apparent* up
vector ``K^-1 (N_f - b)``: the true one, and what a model that lacks K2 makes of it. Hence u'_f = M w_f + v with
``M = K'^-1 K`` and ``v = K'^-1 (b - b')``: twelve unknowns of the cube alone, and twelve conditions, that u' has
unit length (6) and that its tilts obey q' = c p' (6). To first order m_ca = c p_ac - q_ac, v = 0: the cube's
perpendicularity goes into the misalignment, its parallelism nowhere. To second order v is the skew times the
parallelism (`procedures.dwells_and_turns.bench_parameters.skew_jacobian`).
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.dwells_and_turns.bench_parameters import MACHINING_ITEMS_DOWN, MACHINING_ITEMS_UP
from procedures.frames import AXES, cross_axes

MEAN_CUBE_ITERATIONS = 4  # each leaves a tilt's part of the error: 1e-3 rad of tilt ends below 1e-15


def apparent_fit(w: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return M^-1 (3, 3, n), v (3, n) and the mean cube (3, 3, n) for apparent up vectors ``w`` (6, 3, n).

    ``K' = K M^-1``, ``b' = b - K' v``; the columns of the mean cube are the unit normals E is referred to.
    """
    n = w.shape[2]
    M, v = np.repeat(np.eye(3)[..., None], n, axis=2), np.zeros((3, n))
    for _ in range(MEAN_CUBE_ITERATIONS):
        z: FloatArray = np.einsum("ijn,fjn->fin", M, w, optimize=False)
        z += v
        for pair, (a, first, second) in enumerate(_PAIRS):
            up, down = z[2 * pair], z[2 * pair + 1]
            own_up = np.sqrt(1 - up[first] ** 2 - up[second] ** 2) - up[a]
            own_down = -np.sqrt(1 - down[first] ** 2 - down[second] ** 2) - down[a]
            v[a] += (own_up + own_down) / 2
            M[a, a] += (own_up - own_down) / 2
            for c in (first, second):
                M[c, a] += _SHARE[pair] * (up[c] + down[c]) - (up[c] - down[c]) / 2
    inverse: FloatArray = np.moveaxis(np.linalg.inv(np.ascontiguousarray(np.moveaxis(M, 2, 0))), 0, 2)
    return inverse, v, _mean_cube(z)


def _mean_cube(z: FloatArray) -> FloatArray:
    cube = np.empty((3, 3, z.shape[2]))
    for pair, (a, first, second) in enumerate(_PAIRS):
        q = (z[2 * pair] - z[2 * pair + 1]) / 2
        length = np.sqrt(1 + q[first] ** 2 + q[second] ** 2)
        cube[a, pair] = 1 / length
        for c in (first, second):
            cube[c, pair] = q[c] / length
    return cube


_PAIRS = tuple((i, *cross_axes(f"{axis}_up")) for i, axis in enumerate(AXES))
# Q / p of the likeliest cube, `procedures.dwells_and_turns.bench_parameters`
_SHARE = MACHINING_ITEMS_UP / (MACHINING_ITEMS_UP + MACHINING_ITEMS_DOWN) - 0.5
