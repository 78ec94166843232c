"""Errors of each estimator on cubes with tilted faces, exactly, and their distribution by Monte Carlo.

With ``u_f`` the up vector (unit, cube axes) on face f, and s and d half the sum and half the difference of a
pair's two, ``N = k (E u + D)`` put into Yao 2018 (3)-(11) gives for sensor q, U having the columns d_x, d_y, d_z,

    k~_q = k_q |E_q U|,    E~_q = E_q U / |E_q U|                        Yao 2018 (3)-(7)
    D~_q = k_q / k~_q (D_q + E_q (s_x + s_y + s_z) / 3)                  12 positions, Yao 2018 (13)
    D~_q = k_q / k~_q (D_q + E_q s_q)                                    two directions

Yao 2018's equations (14)-(17) are missing from the printed text: the last line written out for q = x, y, z is
(14)-(16), and (13) less D_q with k_q / k~_q = 1 is (17).

The joint solve (`procedures.twelve_positions.accelerometer_fit`) fits K', b' and the tilts of six faces, of which
the cube's perpendicularity is held at ``q = c p``. Without noise ``K' u'_f + b' = K w_f + b`` on every face, with
w_f the *apparent* up vector ``K^-1 (N_f - b)``: the true one, and what a model that lacks K2 makes of it. Hence
u'_f = M w_f + v with ``M = K'^-1 K`` and ``v = K'^-1 (b - b')``: twelve unknowns, and twelve conditions, that u'
has unit length (6) and that its tilts obey q' = c p' (6).

Monte Carlo: an item of one cube has any sign, uniform between plus and minus its tolerance, or normal with the
tolerance as two standard deviations. A face tilts by the signed sum of the items on the way to it, in any
direction, or in that of Yao 2018 table 3.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import AXES
from procedures.positions import FACES, cross_axes
from procedures.tolerance.drawing_items import P1_DIRECTION, STACK
from procedures.twelve_positions.bench_parameters import MACHINING_ITEMS_DOWN, MACHINING_ITEMS_UP

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
# Q / p of the likeliest cube, `procedures.twelve_positions.bench_parameters`
_SHARE = MACHINING_ITEMS_UP / (MACHINING_ITEMS_UP + MACHINING_ITEMS_DOWN) - 0.5


CROSS = np.array([cross_axes(face) for face in FACES])
ESTIMATOR_NAMES = ("twelve", "two", "joint")


@dataclass(frozen=True, slots=True, eq=False)
class ToleranceUnit:
    """An accelerometer triad in cube axes: E (3, 3) with rows of unit length, D (3,) [g], K2 (3,) [g/g^2].

    The scale factors cancel from every relative error and are left out.
    """

    E: FloatArray
    D: FloatArray
    K2: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class EstimatorErrors:
    """What the estimators find less what is true, for n cubes; sensors first.

    ``bias`` (3, 3, n) [g]: estimator (`ESTIMATOR_NAMES`), sensor. ``scale_factor`` (3, n): relative.
    ``misalignment`` (3, 3, n) [rad]: E~ - E, sensor and cube axis. Scale factor and misalignment are those of Yao
    2018 (6), (7).
    """

    bias: FloatArray
    scale_factor: FloatArray
    misalignment: FloatArray


def up_vectors(tilts: FloatArray) -> FloatArray:
    """Return up vectors (6, 3, ...), cube axes, of faces with ``tilts`` (6, 2, ...) [rad], as `face_rotation`."""
    angle = np.hypot(tilts[:, 0], tilts[:, 1])
    up = np.empty((6, 3, *tilts.shape[2:]))
    across = tilts * np.sinc(angle / np.pi)[:, None]
    for f in range(6):
        up[f, f // 2] = np.cos(angle[f]) * (1 - 2 * (f % 2))
        up[f, CROSS[f]] = across[f]
    return up


def outputs(up: FloatArray, unit: ToleranceUnit) -> FloatArray:
    """Return the output over k (6, 3, ...) [g], ``E u + D + K2 (E u)^2``, for ``up`` (6, 3, ...) on every face."""
    f: FloatArray = np.einsum("qa,fa...->fq...", unit.E, up)
    K2, D = (part.reshape(1, 3, *(1,) * (f.ndim - 2)) for part in (unit.K2, unit.D))
    return f + K2 * f**2 + D


def estimator_errors(tilts: FloatArray, unit: ToleranceUnit) -> EstimatorErrors:
    """Return the errors of all estimators on cubes whose faces are tilted by ``tilts`` (6, 2, n) [rad]."""
    N = outputs(up_vectors(tilts), unit)
    d, s = (N[::2] - N[1::2]) / 2, (N[::2] + N[1::2]) / 2  # (pair, sensor, n)
    k = np.sqrt(np.sum(d**2, axis=0))
    own = np.arange(3)
    D = unit.D[:, None]
    bias = np.stack((s.mean(axis=0) / k - D, s[own, own] / k - D, _joint(N, unit) - D))
    return EstimatorErrors(bias, k - 1, np.swapaxes(d / k, 0, 1) - unit.E[..., None])


def _joint(N: FloatArray, unit: ToleranceUnit) -> FloatArray:
    apparent: FloatArray = np.einsum("aq,fqn->fan", np.linalg.inv(unit.E), N - unit.D[:, None])
    inverse, shift, cube = apparent_fit(apparent)
    K: FloatArray = np.einsum("qa,abn->qbn", unit.E, inverse)
    b: FloatArray = unit.D[:, None] - np.einsum("qan,an->qn", K, shift)
    axes: FloatArray = np.einsum("qan,abn->qbn", K, cube)
    result: FloatArray = b / np.sqrt(np.sum(axes**2, axis=1))
    return result


CUBES_PER_BATCH = 8192  # cubes in one batch: stays in the processor's cache
ToleranceShape = Literal["uniform", "normal"]
Directions = Literal["any", "p1"]
DEVIATION = {"uniform": 1 / np.sqrt(3), "normal": 0.5}  # standard deviation over tolerance


@dataclass(frozen=True, slots=True, eq=False)
class DrawnErrors:
    """Errors of n drawn cubes.

    ``bias`` (3, 3, n) [g]: estimator, sensor. ``scale_factor`` (3, n): relative.
    ``misalignment`` (3, n) [rad]: the angle by which each row of E is off.
    """

    bias: FloatArray
    scale_factor: FloatArray
    misalignment: FloatArray


def draw_tilts(
    rng: np.random.Generator, item: FloatArray, n: int, shape: ToleranceShape = "uniform",
    directions: Directions = "any",
) -> FloatArray:  # fmt: skip
    """Return the face tilts (6, 2, n) [rad] of n cubes made to the items ``item`` (11,) [rad]."""
    if shape == "uniform":
        part = rng.uniform(-1.0, 1.0, (len(item), n))
    else:
        part = DEVIATION["normal"] * rng.standard_normal((len(item), n))
    size: FloatArray = STACK @ (item[:, None] * part)
    if directions == "p1":
        return size[:, None] * P1_DIRECTION[..., None]
    azimuth = rng.uniform(0.0, 2 * np.pi, (6, n))
    return np.stack((size * np.cos(azimuth), size * np.sin(azimuth)), axis=1)


def tilt_std(item: FloatArray, shape: ToleranceShape = "uniform") -> FloatArray:
    """Return 1 sigma (6,) [rad] of a face's two tilts by ``item`` (11,) [rad], directions being any."""
    size: FloatArray = np.sqrt(STACK @ item**2 / 2) * DEVIATION[shape]
    return size


def draw_errors(
    item: FloatArray, unit: ToleranceUnit, n: int, seed: int, shape: ToleranceShape = "uniform",
    directions: Directions = "any",
) -> DrawnErrors:  # fmt: skip
    """Draw n cubes made to ``item`` (11,) [rad], return the errors on each; equal seeds give equal cubes."""
    rng = np.random.default_rng(seed)
    bias, scale, angle = np.empty((3, 3, n)), np.empty((3, n)), np.empty((3, n))
    for begin in range(0, n, CUBES_PER_BATCH):
        part = slice(begin, min(begin + CUBES_PER_BATCH, n))
        found = estimator_errors(draw_tilts(rng, item, part.stop - begin, shape, directions), unit)
        bias[..., part], scale[:, part] = found.bias, found.scale_factor
        angle[:, part] = np.sqrt(np.sum(found.misalignment**2, axis=1))
    return DrawnErrors(bias, scale, angle)
