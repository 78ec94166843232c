"""The error of every estimator on a cube whose faces are tilted, exactly: the full formulas on noise-free rates.

With ``u_f`` the up vector (unit, cube axes) on face f, and s and d half the sum and half the difference of a
pair's two, ``N = k (E u + D)`` put into Yao 2018 (3)-(11) gives for sensor q, U having the columns d_x, d_y, d_z,

    k~_q = k_q |E_q U|,    E~_q = E_q U / |E_q U|                        Yao 2018 (3)-(7)
    D~_q = k_q / k~_q (D_q + E_q (s_x + s_y + s_z) / 3)                  12 positions, Yao 2018 (13)
    D~_q = k_q / k~_q (D_q + E_q s_q)                                    two directions

Yao 2018's equations (14)-(17) are missing from the printed text. By what stands around them, the last line written
out for q = x, y, z is (14)-(16), and (13) less D_q with k_q / k~_q = 1 is (17). With every item t (table 3)

    s_x = (cos t - cos 3t, sin t, sin 3t) / 2        d_x = (cos t + cos 3t, sin t, -sin 3t) / 2
    s_y = (sin 5t, cos 3t - cos 5t, sin 3t) / 2      d_y = (-sin 5t, cos 3t + cos 5t, sin 3t) / 2
    s_z = (sin 5t, sin 3t, cos 3t - cos 5t) / 2      d_z = (-sin 5t, sin 3t, cos 3t + cos 5t) / 2

so that (14)-(16) are ``D~_q = k_q / k~_q (D_q + E_q s_q)`` with these rows, (17) is ``E_q (s_x + s_y + s_z) / 3``,
and with sin nt = n sin t follow (13) as printed, (18), (19) and (20).
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import FACES, cross_axes
from procedures.tolerance.joint_solve_errors import apparent_fit

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

    @classmethod
    def ideal(cls) -> "ToleranceUnit":
        """Return the unit that has nothing but its axes."""
        return cls(np.eye(3), np.zeros(3), np.zeros(3))


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
