"""A table of means, a row a pose, as a calibration: bias, scale factor and misalignment by the norm of gravity.

The fit is that of rests in unknown attitudes (`procedures.free_positions.norm_fit`). Standard uncertainties by the
poses' scatter are widened for few degrees of freedom (Student's t, JCGM 100, G.3), and no less than the
jackknife's.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from procedures.arrays import FloatArray
from procedures.free_positions.norm_fit import LOWER_TRIANGLE, NormFit, Undetermined, fit_norm, norm_sigma

MAX_POSES = 100  # rows: more are samples of a log
MIN_POSES = 4  # rows that show that they differ
MAX_LENGTH_SPREAD = 0.2  # relative, of the vectors' lengths: bias and scale factor errors of any sensor worth it
MIN_TURN_DEG = 25.0  # between rows, half of which are at least so far apart: no log turns so from row to row
REGULAR = 0.05  # relative scatter of the steps of a time that a logger wrote
ONE_SIGMA = 0.8413447460685429  # probability of the normal distribution below one sigma


@dataclass(frozen=True, slots=True, eq=False)
class SubtractedEffects:
    """What effects that were subtracted from the outputs leave open of the fit to these.

    It moves the fit's parameters by ``moved`` (9,) and adds ``covariance`` (9, 9); ``coefficients`` is how many
    numbers the poses determine of the effects.
    """

    moved: FloatArray
    covariance: FloatArray
    coefficients: float


@dataclass(frozen=True, slots=True, eq=False)
class MeansCalibration:
    """What the means of n poses say.

    ``k`` (3,) [output per g], ``bias`` (3,) [g] and ``E`` (3, 3), lower triangular of unit rows, with standard
    uncertainties; these are nan where nothing shows them: as many numbers as poses, and no scatter stated.
    ``residual`` (n,) [g] is the norm's, ``noise`` (n,) [g] its standard uncertainty by that of the means,
    ``held_out`` (n,) [g] the residual of each pose by the fit to all others, nan where these do not determine it.
    ``free`` are the degrees of freedom.
    """

    k: FloatArray
    k_std: FloatArray
    bias: FloatArray
    bias_std: FloatArray
    E: FloatArray
    E_std: FloatArray
    residual: FloatArray
    noise: FloatArray
    held_out: FloatArray
    free: float
    not_observable: tuple[str, ...]

    @property
    def chi2(self) -> float:
        """Sum of squares of the residuals over their noise."""
        return float(np.sum((self.residual / self.noise) ** 2))


def differ_like_poses(accel: FloatArray, t: FloatArray | None) -> bool:
    """Say whether the rows of ``accel`` (n, 3) are means of poses: few, equally long, pointing anywhere.

    ``accel`` is in the unit of the table. ``t`` (n,) is the time column, if there is one: one that rises regularly
    is a logger's.
    """
    n = len(accel)
    length = np.linalg.norm(accel, axis=1)
    if not MIN_POSES <= n <= MAX_POSES or not np.all(np.isfinite(length)) or not np.all(length > 0):
        return False
    if t is not None and np.all((steps := np.diff(t)) > 0) and np.std(steps) < REGULAR * np.mean(steps):
        return False
    if np.sort(np.abs(length / np.median(length) - 1))[-2] > MAX_LENGTH_SPREAD:  # one may be a typing error
        return False
    up = accel / length[:, None]
    turned = np.degrees(np.arccos(np.clip(np.sum(up[1:] * up[:-1], axis=1), -1, 1)))
    return bool(np.median(turned) > MIN_TURN_DEG)


def calibrate_means(
    accel: FloatArray,
    std: FloatArray,
    gravity: float,
    gravity_std: float,
    *,
    is_std_stated: bool,
    effects: SubtractedEffects | None = None,
) -> MeansCalibration | Undetermined:
    """Calibrate accelerometers by the means of poses.

    Parameters
    ----------
    accel, std : (n, 3) [output], means and their standard uncertainties
    gravity, gravity_std : [g], the specific force in every pose
    is_std_stated : whether ``std`` holds noise that was measured; else it is the rounding of the table at most
    effects : what effects leave open that were subtracted from ``accel``
    """
    fit = fit_norm(accel, std, gravity)
    if isinstance(fit, Undetermined):
        return fit
    free = fit.free
    if effects is not None:
        fit, free = fit.moved(effects.moved, effects.covariance), max(free - effects.coefficients, 0.0)
    value, covariance = fit.scale_and_bias()
    noise = norm_sigma(fit.K, fit.b, accel, std)
    scatter = float(np.mean(fit.excess**2 / (noise**2 + fit.excess**2))) if is_std_stated else 1.0
    widening = widened(free, scatter)
    sigma = np.sqrt(np.diag(covariance)) * widening
    k, bias = value[:3], value[3:]
    relative = gravity_std / gravity  # common to all poses: k falls as gravity rises, b / k with it
    E, E_std = _misalignment(fit)
    held_out, others = _without_each(accel, std, gravity)
    if len(others) > 1:
        sigma = np.maximum(sigma, _jackknife([each.scale_and_bias()[0] for each in others]))
        E_std = np.maximum(E_std * widening, _jackknife([_misalignment(each)[0] for each in others]) * (E_std > 0))
    return MeansCalibration(
        k, np.hypot(sigma[:3], relative * k), bias, np.hypot(sigma[3:], relative * bias), E, E_std,
        fit.residual, noise, held_out, free, fit.not_observable,
    )  # fmt: skip


def widened(free: float, scatter: float) -> float:
    """Return by how much a sigma of ``free`` degrees of freedom is wider than it looks.

    ``scatter`` is the share of the variance that the poses' scatter showed. The rest is noise that was stated, and
    stays as it is. Where all of it is scatter fewer degrees of freedom than one show nothing: nan.
    """
    if scatter == 1 and free < 1 - 1e-6:
        return np.nan
    return float(np.sqrt(1 + scatter * (stdtrit(max(free, 1.0), ONE_SIGMA) ** 2 - 1)))


def _misalignment(fit: NormFit) -> tuple[FloatArray, FloatArray]:
    """Return K by its rows' lengths, and the standard uncertainty of what is below the diagonal; else 0."""
    k = np.linalg.norm(fit.K, axis=1)
    std = np.zeros((3, 3))
    std[LOWER_TRIANGLE] = np.sqrt(np.diag(fit.fit.covariance)[:6])
    std /= k[:, None]
    np.fill_diagonal(std, 0.0)
    return fit.K / k[:, None], std


def _without_each(accel: FloatArray, std: FloatArray, gravity: float) -> tuple[FloatArray, list[NormFit]]:
    """Return by how much the norm (n,) [g] of each pose is off gravity by the fit to all others; these fits."""
    found, fits = np.full(len(accel), np.nan), list[NormFit]()
    for i in range(len(accel)):
        others = np.arange(len(accel)) != i
        fit = fit_norm(accel[others], std[others], gravity)
        if isinstance(fit, NormFit):
            fits.append(fit)
            found[i] = np.linalg.norm(np.linalg.solve(fit.K, accel[i] - fit.b)) - gravity
    return found, fits


def _jackknife(without_each: Sequence[FloatArray]) -> FloatArray:
    """Return the 1 sigma of parameters by how far they move as each pose is left out.

    Source: Efron and Stein, The jackknife estimate of variance, Ann. Statist. 9, 1981.
    """
    values, n = np.stack(without_each), len(without_each)
    found: FloatArray = np.sqrt((n - 1) * np.var(values, axis=0))
    return found


def gyro_bias(gyro: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the mean (3,) of ``gyro`` (n, 3) over poses and its standard uncertainty, in the unit of ``gyro``.

    The Earth's rate is not corrected: the poses' scatter, where it is larger than ``std`` (n, 3), holds it.
    """
    n = len(gyro)
    stated = np.sqrt(np.mean(std**2, axis=0) / n)
    scatter = np.std(gyro, axis=0, ddof=1) / np.sqrt(n) if n > 1 else np.full(3, np.inf)
    return np.mean(gyro, axis=0), np.maximum(stated, scatter)
