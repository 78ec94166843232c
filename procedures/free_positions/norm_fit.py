"""Three accelerometers from rests in unknown attitudes, by the norm ``|K^-1 (N - b)| = g``, or why it fails.

`NormFit` has E lower triangular: the frame's x axis is sensor x's input axis, its y axis lies in the plane of
sensors x and y. Source of the method: Tedaldi, Pretto, Menegatti, ICRA 2014, who take E upper triangular.

Six faces set by hand determine bias and scale factor of each axis; misalignment shows only by the tilt of the
rests. It has a prior; what that says more of than the rests do is not observable. `Undetermined` says which rest
is missing.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import partial

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.sample_records import Series
from procedures.frames import AXES
from procedures.free_positions.rest_detection import ScatterLevel
from procedures.statistics.least_squares import Fit, joined_rows, minimise_if_determined

OPPOSITE = 3.0  # times as far, in spans, as any other axis: the axis was turned over, as it is within 15 deg of it
NEVER_TURNED = 0.25  # of the largest span, below which an axis was never turned to the vertical
ONE_ATTITUDE = 0.5  # of the median norm: outputs that span less differ by a tilt, unless they have a large offset


class Lack(StrEnum):
    """What rests lack."""

    NO_RESTS = "no rests"
    FEW_RESTS = "few rests"
    SILENT = "a channel that does not respond"
    ONE_ATTITUDE = "one attitude"
    ONE_SIDED = "one side only"
    UNEQUAL = "specific forces of unequal length"
    UNCERTAIN = "too uncertain"


@dataclass(frozen=True, slots=True)
class Undetermined:
    """What ``rests``, so many, lack; of which ``axes``, or on which ``sides`` an axis was seen; ``excess`` [g]."""

    lack: Lack
    rests: int
    axes: tuple[str, ...] = ()
    sides: Mapping[str, str] = field(default_factory=dict)
    excess: float = 0.0

    @property
    def missing(self) -> list[str]:
        """Return what would determine the unit, with what was found, as phrases."""
        found = f"{self.rests} found"
        match self.lack:
            case Lack.NO_RESTS:
                return ["rests in which the unit is still for 2 s or longer (none found)"]
            case Lack.FEW_RESTS:
                return [f"6 rests, one on each face, or 10 that differ in attitude ({found})"]
            case Lack.SILENT:
                same = f"{', '.join(self.axes)}: the same in {self.rests} rests"
                return [f"accelerometer outputs that change with attitude ({same})"]
            case Lack.ONE_ATTITUDE:
                return [f"rests on all six faces ({found}, all in nearly one attitude)"]
            case Lack.ONE_SIDED:
                return [_turned_over(axis, side) for axis, side in self.sides.items()]
            case Lack.UNEQUAL:
                by = f": it differs by {self.excess:.2g} g" if self.excess > 0 else ""
                return [
                    f"rests whose specific force has equal length ({found}{by}): hold still, on a surface that "
                    f"does not move, and check the accelerometers' columns"
                ]
            case Lack.UNCERTAIN:
                which = f"accelerometer {', '.join(self.axes)}"
                return [f"longer rests, or more that turn {which} up and down ({found})"]


def _turned_over(axis: str, side: str) -> str:
    """Return which rest an axis lacks, seen on one ``side`` ("up only", "down only") or "neither"."""
    wanted = {"up only": "down", "down only": "up"}.get(side, "up, and one with it down")
    return f"a rest with accelerometer {axis} pointing {wanted} (found: {side})"


def plainly_lacking(rate: FloatArray, least: int) -> Undetermined | None:
    """Say what rests of mean outputs ``rate`` (n, 3) [output/s] plainly lack; None where a fit is worth trying."""
    n = len(rate)
    if n == 0:
        return Undetermined(Lack.NO_RESTS, 0)
    span = np.ptp(rate, axis=0)
    if n > 1 and np.any(span == 0):
        return Undetermined(Lack.SILENT, n, tuple(AXES[i] for i in np.flatnonzero(span == 0)))
    if n >= least:
        return None
    found = undetermined(rate, Lack.FEW_RESTS)  # of rests far too few every axis lacks a side
    return Undetermined(Lack.FEW_RESTS, n) if found.lack is Lack.ONE_SIDED and n < least - 1 else found


def undetermined(rate: FloatArray, lack: Lack, axes: Sequence[str] = (), excess: float = 0.0) -> Undetermined:
    """Say why a fit to rests with the mean outputs ``rate`` (n, 3) failed.

    What the outputs show by themselves is reported, else the ``lack``, ``axes`` and ``excess`` [g] that the fit
    found.
    """
    n, span = len(rate), np.ptp(rate, axis=0)
    if n > 1 and np.max(span) < ONE_ATTITUDE * np.median(np.linalg.norm(rate, axis=1)) and _is_one_tilted(span):
        return Undetermined(Lack.ONE_ATTITUDE, n)
    if n > 1 and (sides := _one_sided(rate, span)):
        return Undetermined(Lack.ONE_SIDED, n, tuple(sides), sides)
    return Undetermined(lack, n, tuple(axes), excess=excess)


def _is_one_tilted(span: FloatArray) -> bool:
    """Say whether the outputs change as about one attitude: along two axes by a tilt, along one by its square."""
    return int(np.sum(span < NEVER_TURNED * np.max(span))) == 1


def _one_sided(rate: FloatArray, span: FloatArray) -> dict[str, str]:
    """Return the axes that no two rests turn over, and on which side each was seen."""
    found = dict[str, str]()
    apart = np.abs(rate[:, None] - rate) / span
    for i, axis in enumerate(AXES):
        others = np.max(np.delete(apart, i, axis=2), axis=2)
        turned = span[i] >= NEVER_TURNED * np.max(span)
        if turned and np.any((apart[..., i] > 0.5) & (apart[..., i] > OPPOSITE * others)):
            continue
        above, below = np.max(rate[:, i]) - np.median(rate[:, i]), np.median(rate[:, i]) - np.min(rate[:, i])
        found[axis] = "neither" if not turned else "up only" if above > below else "down only"
    return found


LOWER_TRIANGLE = np.tril_indices(3)
OFF_DIAGONAL = (1, 3, 4)  # of the lower triangle: yx, zx, zy
MIN_RESTS = 6  # bias and scale factor of three axes
# rad, 1 sigma of an angle between two sensors less 90 deg: data sheets state cross-axis sensitivities of 1 to 2 %
NON_ORTHOGONALITY_STD = 0.015
MULTIPLIERS_TRIED = (1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0)  # of the variance of a quiet window
LOOSE_MULTIPLIERS = (50.0, 100.0, 200.0)  # where none of these gives rests enough: held by hand, never quite still
USUAL_MULTIPLIER = 3.0  # the multiplier where the rests are too few to choose one by
REWEIGHTINGS, MAX_NEWTON_STEPS = 4, 50  # of weighting again by the scatter found, and of finding it
MAX_ELLIPSOID_CONDITION = 1e8  # condition of an ellipsoid's matrix: axes as 1 to 10^4
MAX_RELATIVE_SCALE_STD = 0.1  # relative 1 sigma of k above which the rests are reported not to determine it
MAX_BEND = 0.3  # of a sigma, by which the second order moves bias or scale factor: beyond, no sigma holds
LEAST_FREE = 1e-6  # degrees of freedom that are none but for rounding


@dataclass(frozen=True, slots=True, eq=False)
class NormFit:
    """K (3, 3) [output/s per g], lower triangular, b (3,) [output/s], the fit behind them, residual (n,) [g].

    ``excess`` [g] is the scatter of the norm from rest to rest beyond noise, as in `excess_scatter`. The fit's
    rows are the norms and, last, the prior of the three angles between the sensors.
    """

    K: FloatArray
    b: FloatArray
    fit: Fit
    residual: FloatArray
    excess: float

    @property
    def spread(self) -> float:
        """Mean variance of k, relative, and of D [g]."""
        k = np.diag(self.K)
        return float(np.mean(np.diag(self.fit.covariance)[[0, 2, 5, 6, 7, 8]] / np.tile(k, 2) ** 2))

    @property
    def free(self) -> float:
        """Degrees of freedom that the norms leave."""
        return free_norms(self.fit, len(self.residual))

    def moved(self, by: FloatArray, covariance: FloatArray) -> "NormFit":
        """Return the fit with its parameters moved ``by`` (9,) and a ``covariance`` (9, 9) added to theirs."""
        x = self.fit.x + by
        return replace(
            self, K=_lower(x), b=x[6:], fit=replace(self.fit, x=x, covariance=self.fit.covariance + covariance)
        )

    @property
    def not_observable(self) -> tuple[str, ...]:
        """The misalignments that the prior says more of than the rests do, as ``misalignment.yx``."""
        return by_prior_alone(self.fit.leverage[-3:])

    def scale_and_bias(self) -> tuple[FloatArray, FloatArray]:
        """Return scale factor (3) [output/s per g] and bias (3) [g] in one (6,), and their covariance (6, 6)."""
        k = np.linalg.norm(self.K, axis=1)
        J = np.zeros((6, 9))
        for column, (i, j) in enumerate(zip(*LOWER_TRIANGLE, strict=True)):
            J[i, column] = self.K[i, j] / k[i]
        J[3:, :6] = -(self.b / k**2)[:, None] * J[:3, :6]
        J[3:, 6:] = np.diag(1 / k)
        return np.concatenate((k, self.b / k)), J @ self.fit.covariance @ J.T


def by_prior_alone(leverage: FloatArray) -> tuple[str, ...]:
    """Name the angles [rad] between sensors whose prior's ``leverage`` (3,) is more than one half."""
    names = ("misalignment.yx", "misalignment.zx", "misalignment.zy")
    return tuple(name for name, share in zip(names, leverage, strict=True) if share > 0.5)


def free_norms(fit: Fit, norms: int, first: int = 0) -> float:
    """Return the degrees of freedom that ``norms`` rows of a fit, from ``first`` on, leave; 0 where none."""
    free = float(np.sum(1 - fit.leverage[first : first + norms]))
    return free if free > LEAST_FREE else 0.0


def angle_std(angles: FloatArray) -> FloatArray:
    """Return the prior's 1 sigma (3,) [rad] of ``angles`` between sensors: at least as wide as they were found."""
    return np.maximum(NON_ORTHOGONALITY_STD, np.abs(angles))


def with_second_order(covariance: FloatArray, k: FloatArray, own: Sequence[int], angles: FloatArray) -> FloatArray:
    """Return a covariance in which scale factors are as wide as the squares of unknown angles leave them.

    On a face, a sensor that is m rad off it reads m^2 / 2 less and the two others m more: of squares that are not
    known the norm keeps the difference, which is of mean 0. With v the mean variance of the sensor's two angles
    its variance is v^2 / 2.

    Parameters
    ----------
    covariance : (p, p), of parameters of which ``own`` (3) are the diagonal of K
    k : (3,), the diagonal of K [output/s per g]
    angles : (3,) [rad^2], variance of the angles yx, zx, zy
    """
    wide = covariance.copy()
    yx, zx, zy = angles
    for at, scale, variance in zip(own, k, (yx + zx, yx + zy, zx + zy), strict=True):
        wide[at, at] += (scale * variance) ** 2 / 8
    return wide


@np.errstate(all="ignore")  # outputs beyond all bounds determine nothing
def fit_norm(rate: FloatArray, std: FloatArray, gravity: float) -> NormFit | Undetermined:
    """Fit K and b to rests; where they do not determine bias and scale factor of each axis, say why.

    Parameters
    ----------
    rate, std : (n, 3) [output/s], mean outputs of the rests and their 1 sigma
    gravity : [g], the norm that they have
    """
    if (early := plainly_lacking(rate, MIN_RESTS)) is not None:
        return early
    start = _ellipsoid(rate, gravity, is_tilted=True) or _ellipsoid(rate, gravity, is_tilted=False)
    if start is None:
        return undetermined(rate, Lack.UNEQUAL)
    K, b = start
    noise, excess, angles = norm_sigma(K, b, rate, std), 0.0, np.zeros(3)
    x = np.concatenate((K[LOWER_TRIANGLE], b))
    for _ in range(REWEIGHTINGS):
        sigma = np.hypot(noise, excess)
        prior = angle_std(angles) * np.abs(x[[2, 5, 5]])
        misfit = partial(_misfit, rate, gravity, sigma, prior)
        found = minimise_if_determined(misfit, x, np.full(9, np.max(np.abs(K)) * 0.1), at_once=True)
        if found is None:
            return undetermined(rate, Lack.UNEQUAL)
        fit = found
        x, free = fit.x, free_norms(fit, len(rate))
        angles = x[[1, 3, 4]] / x[[2, 5, 5]]
        excess = excess_scatter(fit.residual[:-3] * sigma, noise, free) if free else 0.0
    K, b = _lower(x), x[6:]
    k = np.diag(K)
    uncertain = np.sqrt(np.diag(fit.covariance)[[0, 2, 5]]) > MAX_RELATIVE_SCALE_STD * np.abs(k)
    if (is_open := uncertain | (_bend(misfit, fit) > MAX_BEND)).any():
        lack = Lack.UNEQUAL if excess > np.max(noise) else Lack.UNCERTAIN
        return undetermined(rate, lack, [AXES[i] for i in np.flatnonzero(is_open)], excess)
    variance = np.diag(fit.covariance)[list(OFF_DIAGONAL)] / k[[1, 2, 2]] ** 2
    wide = with_second_order(fit.covariance, k, (0, 2, 5), variance)
    return NormFit(K, b, replace(fit, covariance=wide), fit.residual[:-3] * sigma, excess)


def _bend(misfit: Callable[[FloatArray], FloatArray], fit: Fit) -> FloatArray:
    """Return by how much of its sigma (3,) the second order moves b, one sigma off the minimum."""
    std = np.sqrt(np.diag(fit.covariance))[6:]
    step = fit.covariance[6:] / std[:, None]
    second = (misfit(fit.x + step) + misfit(fit.x - step)) / 2 - fit.residual
    moved = fit.covariance[6:] @ fit.jacobian.T @ second.T
    bend: FloatArray = np.max(np.abs(moved) / std[:, None], axis=1)
    return np.where(np.isfinite(bend), bend, np.inf)


def excess_scatter(residual: FloatArray, noise: FloatArray, free: float) -> float:
    """Return the scatter common to all rows that brings their weighted squares to the ``free`` degrees of freedom.

    ``residual`` and ``noise``, 1 sigma, are (n,). Source: Mandel and Paule, Anal. Chem. 42, 1970.
    """
    variance = 0.0
    for _ in range(MAX_NEWTON_STEPS):
        weight = 1 / (noise**2 + variance)
        over = float(np.sum(weight * residual**2)) - free
        if over <= 0:
            break
        variance += over / float(np.sum((weight * residual) ** 2))
    return float(np.sqrt(variance))


def _lower(x: FloatArray) -> FloatArray:
    K = np.zeros((*x.shape[:-1], 3, 3))
    K[..., *LOWER_TRIANGLE] = x[..., :6]
    return K


def _misfit(rate: FloatArray, gravity: float, sigma: FloatArray, prior: FloatArray, x: FloatArray) -> FloatArray:
    u = np.linalg.solve(_lower(x), np.swapaxes(rate - x[..., None, 6:], -1, -2))
    norm = (np.linalg.norm(u, axis=-2) - gravity) / sigma
    return joined_rows(x, norm, x[..., OFF_DIAGONAL] / prior)


def norm_sigma(K: FloatArray, b: FloatArray, rate: FloatArray, std: FloatArray) -> FloatArray:
    """Return 1 sigma (n,) [g] of the norm of ``K^-1 (rate - b)``.

    Parameters
    ----------
    K, b : (3, 3) [output/s per g], (3,) [output/s]
    rate, std : (n, 3) [output/s], 1 sigma
    """
    u = np.linalg.solve(K, (rate - b).T).T
    weight = np.linalg.solve(K.T, (u / np.linalg.norm(u, axis=1)[:, None]).T).T
    sigma: FloatArray = np.linalg.norm(weight * std, axis=1)
    return sigma


def _ellipsoid(rate: FloatArray, gravity: float, *, is_tilted: bool) -> tuple[FloatArray, FloatArray] | None:
    """Fit the quadric ``v' M v + 2 m' v = 1`` to the outputs; None unless it is an ellipsoid.

    One that is not tilted has the sensors' axes: for rests too few or too near the faces for a tilted one.
    """
    middle, size = (np.asarray(f(rate, axis=0), dtype=np.float64) for f in (np.mean, np.std))
    if np.any(size <= 0) or (is_tilted and len(rate) < 9):
        return None
    v = (rate - middle) / size
    if is_tilted:
        x, y, z = v.T
        A = np.stack((x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, 2 * x, 2 * y, 2 * z), axis=1)
        xx, yy, zz, xy, xz, yz, *rest = np.linalg.lstsq(A, np.ones(len(v)), rcond=None)[0]
        M = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    else:
        xx, yy, zz, *rest = np.linalg.lstsq(np.hstack((v**2, 2 * v)), np.ones(len(v)), rcond=None)[0]
        M = np.diag([xx, yy, zz])
    m, is_finite = np.array(rest), np.all(np.isfinite(M))
    if not is_finite or np.linalg.cond(M) > MAX_ELLIPSOID_CONDITION or np.any(np.linalg.eigvalsh(M) <= 0):
        return None
    centre = -np.linalg.solve(M, m)
    inverse = np.linalg.inv(M / (1 + centre @ M @ centre)) / gravity**2
    return np.asarray(np.linalg.cholesky(inverse * np.outer(size, size)), dtype=np.float64), middle + centre * size


def choose_rests(activity: ScatterLevel, gravity: float) -> tuple[float, list[slice]]:
    """Return the threshold's multiplier and the rests that leave k and D least uncertain.

    A multiplier too small throws rests away, one too large lets movement in: both make the fit's covariance grow.
    Where the rests are just enough the usual multiplier is taken, or the least above it that determines the unit.
    """
    for multipliers in (MULTIPLIERS_TRIED, LOOSE_MULTIPLIERS):
        found: list[tuple[float, float, list[slice]]] = []
        for multiplier in multipliers:
            rests = activity.rests(multiplier)
            fit = _quick_fit(activity.series, rests, gravity)
            if isinstance(fit, NormFit):
                found.append((fit.spread if fit.free >= 1 else np.inf, multiplier, rests))
        if found:
            usual = [each for each in found if each[1] >= USUAL_MULTIPLIER] or found
            is_any_judged = any(np.isfinite(each[0]) for each in found)
            _, multiplier, rests = min(found if is_any_judged else usual, key=lambda each: each[:2])
            return multiplier, rests
    return USUAL_MULTIPLIER, activity.rests(USUAL_MULTIPLIER)


def _quick_fit(series: Series, rests: Sequence[slice], gravity: float) -> NormFit | Undetermined | None:
    if series.accel is None or len(rests) < MIN_RESTS:
        return None
    parts = [np.asarray(series.accel[rest], dtype=np.float64) for rest in rests]
    mean = np.array([samples.mean(axis=0) for samples in parts])
    noise = np.sqrt(np.mean([np.var(np.diff(samples, axis=0), axis=0) / 2 for samples in parts], axis=0))
    std = np.maximum(noise, np.spacing(np.abs(mean).max())) / np.sqrt([[len(samples)] for samples in parts])
    return fit_norm(mean, std, gravity)
