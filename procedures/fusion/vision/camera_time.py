"""How far a camera's stamps are off the IMU's clock, from tracks and gyro alone.

What the camera saw at its stamp t happened at t + d of the IMU's clock (Li, Mourikis 2014; Qin, Shen 2018, who
estimate d within a filter and a window). Between frames stamped t0 and t1 it turned by

    R(d) = C_bc' C_b(t1 + d)' C_b(t0 + d) C_bc,   dR/dd = [C_bc' (R_b w(t0 + d) - w(t1 + d))]x R

with the gyro's rate w, and R_b = C_b(t1 + d)' C_b(t0 + d) (Kelly, Sukhatme 2014). `RotationMisfit` says how each
pair would turn R, with the translation between the frames free. The offset is fitted together with the gyro's bias
and where the camera sits (1 deg, 1 sigma): first on a grid, to find the valley, then by Gauss-Newton on all
points. A steady turn and straight on leave the sigma wide, and are refused.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import rotation
from procedures.fusion.feature_tracks import FeatureTracks, FramePairs, PinholeCamera, frame_pairs
from procedures.fusion.fusion_records import ImuSeries, Waiting
from procedures.fusion.preintegration import RATE_HALF_SPAN_S, GyroRotations, imu_gaps
from procedures.fusion.vision.two_view import TINY, EpipolarRotations, RotationMisfit

MAX_OFFSET_STD_S = 0.005  # s, 1 sigma with which an offset is accepted
RATE_CHANGE_QUANTILE = 0.95  # quantile of the changes of rate of which the residual counts
SEARCH_SIGMAS = 3.0  # of what is known before, that are searched
SEARCH_STEP_S = 0.02  # s of the search: a vehicle does not swing to and fro within a few of them
MIN_PAIRS, MAX_PAIRS = 20, 200  # pairs of frames
ROUGH_PAIRS, ROUGH_POINTS, ROUGH_LOSS, ROUGH_ROUNDS = 60, 40, 6.0, 2  # of the search
GYRO_BIAS_STD, MOUNTING_STD = 0.1, np.radians(1.0)  # rad/s, rad, of the gyro and of where the camera sits
PAIR_TURN_STD = 1e-3  # rad, of a pair's turn beyond the points' own noise: vibration, a lens, a rolling shutter
PAIR_OUTLIER_SIGMAS = 1.5  # sigmas (rms of three axes) from which a pair counts less
ITERATIONS_RANGE = (3, 10)  # at least, at most
STEP_TOLERANCE = 0.05  # of a sigma
SIGMA_FACTOR = 1.5  # on the sigma that the fit states: measured, docs/how-to/locate-vision.md
MIN_COST_RISE = 25.0  # by how much the cost rises away from the offset, in sigmas squared: else there are two
VALLEY_HALF_WIDTH_S = 0.06  # s from the offset that are away from it
MAX_MOUNTING_ANGLE = np.radians(10.0)  # from where the camera was specified to sit
MAX_MEAN_SQUARE = 6.0  # of 1, of the pairs that are used: beyond it these are not this camera's turns on this IMU
UNEVEN_TURNS = "rotate it unevenly: to and fro, about any axis, for some seconds"
CHECK_MOUNTING = "is imu_from_camera right?"


@dataclass(frozen=True, slots=True)
class CameraTimeOffset:
    """``offset`` [s], to be added to the camera's stamps, and 1 sigma ``std`` [s] of it."""

    offset: float
    std: float


def camera_offset(
    imu: ImuSeries, tracks: FeatureTracks, camera: PinholeCamera, prior: float = 0.0, std: float = 0.1,
    even_std: float = MAX_OFFSET_STD_S,
) -> CameraTimeOffset | Waiting:  # fmt: skip
    """Return the offset of the camera's stamps, or what is missing to know it.

    Known before is ``prior`` and 1 sigma ``std`` [s]. Where turns are so even that their residual is within their
    noise, 1 sigma up to ``even_std`` [s] is accepted.
    """
    pairs = _spanned(imu, frame_pairs(tracks, camera), prior, SEARCH_SIGMAS * std)
    if len(pairs) < MIN_PAIRS:
        why = f"{len(pairs)} pairs of frames within the IMU's time share features, {MIN_PAIRS} are needed"
        return Waiting(why)
    return _Fit(imu, pairs, camera, prior, std, even_std).offset()


def _spanned(imu: ImuSeries, pairs: FramePairs, prior: float, reach: float) -> FramePairs:
    """Return the pairs that the IMU spans without a gap, wherever they are tried; of many the best."""
    if len(imu.t) < 2:
        return pairs.part(slice(0, 0))
    first, last = pairs.t0 + prior - reach - 2 * RATE_HALF_SPAN_S, pairs.t1 + prior + reach + 2 * RATE_HALF_SPAN_S
    good = (first >= imu.t[0]) & (last <= imu.t[-1])
    for gap in imu_gaps(imu):
        good &= (last < gap.first) | (first > gap.last)
    return _most_decisive(imu, pairs.part(np.flatnonzero(good)), prior, reach, MAX_PAIRS)


def _most_decisive(imu: ImuSeries, pairs: FramePairs, prior: float, reach: float, most: int) -> FramePairs:
    """Return those pairs over which the rate changes most, for that is what an offset shows by."""
    if len(pairs) <= most:
        return pairs
    gyro, tried = GyroRotations(imu, np.zeros(3)), (prior - reach / 2, prior, prior + reach / 2)
    change = [np.linalg.norm(gyro.rate(pairs.t1 + d) - gyro.rate(pairs.t0 + d), axis=1) for d in tried]
    return pairs.part(np.sort(np.max(change, axis=0).argsort()[-most:]))


@dataclass(frozen=True, slots=True, eq=False)
class _Normal:
    """``A`` (7, 7), ``b`` (7,), each pair's part of b (p, 7), how far off its turn is (p,), mean square, and the
    mean of that over the pairs as they determine the offset.
    """  # noqa: D205

    A: FloatArray
    b: FloatArray
    parts: FloatArray
    off: FloatArray
    misfit: float


@dataclass(frozen=True, slots=True, eq=False)
class _Fitted:
    """What was fitted from a valley, ``x`` (7,), and its cost in sigmas squared."""

    x: FloatArray
    normal: _Normal
    cost: float


class _Fit:
    """Pairs of frames and the gyro; what is fitted is offset, bias (3,) and the camera's turn (3,)."""

    def __init__(
        self, imu: ImuSeries, pairs: FramePairs, camera: PinholeCamera, prior: float, std: float, even_std: float
    ) -> None:
        self.imu, self.pairs, self.camera, self.prior_offset, self.known = imu, pairs, camera, prior, std
        self._even_std = even_std
        self.std = camera.std / np.array([camera.fx, camera.fy])
        span = np.median(pairs.t1 - pairs.t0) + RATE_HALF_SPAN_S
        self._overlapping = np.abs(pairs.t0[:, None] - pairs.t0) <= span
        self._overlap = max(1.0, float(self._overlapping.sum(axis=1).mean()) / 2)
        self.prior = np.r_[std, np.full(3, GYRO_BIAS_STD), np.full(3, MOUNTING_STD)] ** -2

    def offset(self) -> CameraTimeOffset | Waiting:
        """Return the offset, or why there is none."""
        x = np.r_[self.prior_offset, np.zeros(6)]
        for last in (False, True):  # a bias that is far off blurs the first search
            grid, cost = self._search(x)
            fits = [self._refined(np.r_[d, x[1:]]) for d in _valleys(grid, cost)]
            fits.sort(key=lambda each: each.cost)
            x, sigma = fits[0].x, self._sigma(fits[0].normal)
            if (doubt := self._doubt(fits[0], sigma)) is not None:
                return doubt
            other = _as_good(fits, grid, cost, sigma)
            if other is None or last:
                break
        return CameraTimeOffset(float(x[0]), sigma) if other is None else other

    def _doubt(self, fit: _Fitted, sigma: float) -> Waiting | None:
        away = float(np.linalg.norm(fit.x[4:]))
        if fit.normal.misfit > MAX_MEAN_SQUARE or away > MAX_MOUNTING_ANGLE:
            return Waiting(
                f"no time offset makes the camera's rotations match the gyro's (mean square "
                f"{fit.normal.misfit:.1f}, at most {MAX_MEAN_SQUARE:g}, with the camera turned by "
                f"{np.degrees(away):.0f} deg): {CHECK_MOUNTING}"
            )
        if sigma > (needed := self._needed(fit.x)):
            return Waiting(
                f"its clock is known to {sigma * 1e3:.0f} ms, needed {needed * 1e3:.0f}: {UNEVEN_TURNS}"
            )
        if abs(fit.x[0] - self.prior_offset) > SEARCH_SIGMAS * self.known:
            return Waiting(
                f"its clock seems {fit.x[0] * 1e3:.0f} ms wrong, beyond the search range: state time_offset_s"
            )
        return None

    def _needed(self, x: FloatArray) -> float:
        """Return 1 sigma [s] of the offset that suffices: what it leaves of turns is within `PAIR_TURN_STD`."""
        gyro, t0, t1 = GyroRotations(self.imu, x[1:4]), self.pairs.t0 + x[0], self.pairs.t1 + x[0]
        change = np.linalg.norm(gyro.rate(t1) - gyro.rate(t0), axis=1)
        changed = max(float(np.quantile(change, RATE_CHANGE_QUANTILE)), TINY)
        return float(np.clip(PAIR_TURN_STD / changed, MAX_OFFSET_STD_S, self._even_std))

    def _search(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return offsets (n,), and what each costs with the best bias and mount for it, in sigmas squared."""
        reach = SEARCH_SIGMAS * self.known
        some = _most_decisive(self.imu, self.pairs, self.prior_offset, reach, ROUGH_PAIRS)
        some = some.part(slice(None), ROUGH_POINTS)
        seen, gyro = EpipolarRotations(some, self.std, ROUGH_LOSS, ROUGH_ROUNDS), GyroRotations(self.imu, x[1:4])
        half = int(np.ceil(reach / SEARCH_STEP_S - STEP_TOLERANCE))
        grid = self.prior_offset + np.linspace(-reach, reach, 2 * half + 1)
        costs = [self._rough(seen, gyro, np.r_[d, x[1:]]) for d in grid]
        return grid, np.array([_total(each) for each in costs])

    def _rough(self, seen: EpipolarRotations, gyro: GyroRotations, x: FloatArray) -> FloatArray:
        """Return the mean squares (p,) of the turns at an offset, bias and mount fitted."""
        R, J = self._turns(gyro, seen.pairs, x)
        misfit = seen.misfit(R)
        normal = self._normal(misfit, J, x)
        step = np.r_[0.0, np.linalg.solve(normal.A[1:, 1:], -normal.b[1:])]
        return _off(misfit, (J @ step[:, None])[:, :, 0])

    def _refined(self, x: FloatArray) -> _Fitted:
        seen = EpipolarRotations(self.pairs, self.std)
        for made in range(ITERATIONS_RANGE[1]):
            R, J = self._turns(GyroRotations(self.imu, x[1:4]), self.pairs, x)
            normal = self._normal(seen.misfit(R), J, x)
            step = np.linalg.solve(normal.A, -normal.b)
            x = x + np.clip(step, -SEARCH_STEP_S, SEARCH_STEP_S)
            if made + 1 >= ITERATIONS_RANGE[0] and step @ normal.A @ step < STEP_TOLERANCE**2:
                break
        return _Fitted(x, normal, _total(normal.off) / self._overlap)

    def _turns(self, gyro: GyroRotations, pairs: FramePairs, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return R (p, 3, 3) in c, and its left turn by what is fitted (p, 3, 7)."""
        t0, t1, C_bc = pairs.t0 + x[0], pairs.t1 + x[0], self.camera.C_bc @ rotation(x[4:])
        R_b, by_bias = gyro.turned(t0, t1)
        by_time = (R_b @ gyro.rate(t0)[:, :, None])[:, :, 0] - gyro.rate(t1)
        by_b = C_bc.T @ np.concatenate((by_time[:, :, None], by_bias), axis=2)
        R = C_bc.T @ R_b @ C_bc
        return R, np.concatenate((by_b, R - np.eye(3)), axis=2)

    def _normal(self, misfit: RotationMisfit, J: FloatArray, x: FloatArray) -> _Normal:
        """Weigh the pairs' turns, each with the noise `PAIR_TURN_STD` in addition to its own, and sum them up."""
        off = _off(misfit, np.zeros((len(J), 3)))
        trust = np.minimum(1, PAIR_OUTLIER_SIGMAS / np.sqrt(off + TINY))
        less = np.linalg.inv(np.eye(3) + PAIR_TURN_STD**2 * misfit.H)
        back = np.swapaxes(J, 1, 2)
        parts = (back @ less @ misfit.g[:, :, None])[:, :, 0] * trust[:, None]
        each = back @ less @ misfit.H @ J
        A = np.einsum("p,pij->ij", trust, each + np.swapaxes(each, 1, 2)) / 2 + np.diag(self.prior)
        b = parts.sum(axis=0) + self.prior * np.concatenate(([x[0] - self.prior_offset], x[1:]))
        decisive = float(np.average(np.minimum(off, ROUGH_LOSS**2), weights=each[:, 0, 0] + TINY))
        return _Normal(A, b, parts, off, decisive)

    def _sigma(self, normal: _Normal) -> float:
        """Return 1 sigma [s]: as the weights have it, or as the pairs scatter, those that overlap together."""
        P = np.linalg.inv(normal.A)
        moved = normal.parts @ P[0]
        scatter = float(moved @ self._overlapping @ moved)
        return SIGMA_FACTOR * float(np.sqrt(max(P[0, 0], scatter)))


def _valleys(grid: FloatArray, cost: FloatArray) -> list[float]:
    """Return the offset of least cost, and that of another valley where one is more than half as deep."""
    padded, best = np.r_[np.inf, cost, np.inf], int(cost.argmin())
    low = (cost <= padded[:-2]) & (cost <= padded[2:]) & (np.abs(grid - grid[best]) > VALLEY_HALF_WIDTH_S)
    low &= cost < (cost[best] + np.median(cost)) / 2
    others = np.flatnonzero(low)
    return [float(grid[best]), *(float(grid[k]) for k in others[cost[others].argsort()][:1])]


def _as_good(fits: list[_Fitted], grid: FloatArray, cost: FloatArray, sigma: float) -> Waiting | None:
    """Return that another offset fits nearly as well, if one does: another valley, or what lies about the best."""
    best, scale = fits[0], max(1.0, fits[0].normal.misfit)
    offset = float(best.x[0])
    others = [(c - cost.min(), d) for d, c in zip(grid.tolist(), cost.tolist(), strict=True)]
    others += [(fit.cost - best.cost, float(fit.x[0])) for fit in fits[1:]]
    away = max(VALLEY_HALF_WIDTH_S, 5 * sigma)
    rise, other = min((each for each in others if abs(each[1] - offset) > away), default=(np.inf, np.inf))
    rise /= scale
    if rise >= MIN_COST_RISE:
        return None
    return Waiting(
        f"offsets of {offset * 1e3:.0f} and {other * 1e3:.0f} ms fit alike (chi2 {rise:.0f} apart): {UNEVEN_TURNS}"
    )


def _total(off: FloatArray) -> float:
    """Return the cost of the mean squares (p,) of turns, in sigmas squared; one that is far off counts no more."""
    return float(3 * np.sum(off / (1 + off / ROUGH_LOSS**2))) / SIGMA_FACTOR**2


def _off(misfit: RotationMisfit, moved: FloatArray) -> FloatArray:
    """Return how far the pairs' turns are off, mean square (p,), once they have been ``moved`` (p, 3) [rad]."""
    less = np.linalg.inv(np.eye(3) + PAIR_TURN_STD**2 * misfit.H)
    H = misfit.H + 1e-3 * np.eye(3)
    away = np.linalg.solve(H, misfit.g[:, :, None]) + moved[:, :, None]
    off: FloatArray = (np.swapaxes(away, 1, 2) @ less @ H @ away)[:, 0, 0] / 3
    return np.maximum(off, 0.0)
