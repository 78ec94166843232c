"""Accelerometers fitted to rests in any attitude, alone or together with the twelve positions.

A rest is one row, ``|u| = g`` with ``u`` from ``N = K u + b``. A rest on a known face at an unknown heading says
besides where up is, but for the slab's tilt: two rows as wide as a slab may plausibly tilt.

- Where known faces tie the frame, E refers to it. Attitudes between the faces show the skew of the cube's mean
  normals (q_xy + q_yx), which faces alone leave open, and E then refers to the orthogonal axes nearest to them.
- Where none do, every rest counts by its norm alone, and E is lower triangular, with a prior of the angles between
  the sensors (`procedures.free_positions.norm_fit`).
- ``quadratic`` adds K2 per axis, ``N = k (E u + D + K2 u^2)``: on faces it is one with bias and parallelism.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, RestRecord
from procedures.campaign.observations import TriadDwells, TriadRests
from procedures.frames import AXES
from procedures.free_positions.norm_fit import (
    MAX_RELATIVE_SCALE_STD,
    Lack,
    NormFit,
    Undetermined,
    angle_std,
    by_prior_alone,
    excess_scatter,
    fit_norm,
    free_norms,
    norm_sigma,
    with_second_order,
)
from procedures.gyrocompass import first_position
from procedures.positions import cross_axes, face_normal
from procedures.statistics.least_squares import Fit, minimise_if_determined
from procedures.twelve_positions.accelerometer_fit import (
    MIN_RESPONSE_SIGMAS,
    RestFit,
    TriadFit,
    dwell_bench,
    is_determined,
    specific_force,
)
from procedures.twelve_positions.bench_parameters import (
    HELD_STD_RAD,
    SLAB_TILT_RANGE_RAD,
    BenchParameters,
    BenchPrior,
    cube_numbers,
)
from procedures.units import STANDARD_GRAVITY

REWEIGHTINGS = 3  # of weighting again by the scatter found
MAX_CONDITION_OF_K = 1e3  # condition of K: sensors all but in one plane
QUADRATIC_INVERSIONS = 4  # of the quadratic term, each a thousand times smaller than the last
UPPER_TRIANGLE = ((0, 1), (0, 2), (1, 2))  # of K: nothing there where no face ties the frame
ANGLES, ANGLES_OF = [3, 6, 7], [4, 8, 8]  # of K by rows: yx, zx, zy, which then have a prior; yy, zz, zz


def solve_with_rests(
    campaigns: Sequence[Campaign], seen: TriadDwells | None, rests: TriadRests | None, quadratic: bool = False
) -> TriadFit | None:
    """Solve k, E and D of the accelerometers from dwells in positions and rests; None if not determined."""
    guess = _tied_guess(campaigns, seen, rests)
    if guess is None:
        seen, rests = None, _all_as_rests(seen, rests)
        free = None if rests is None else _free_guess(campaigns, rests)
        guess = None if free is None or isinstance(free, Undetermined) else (free.K, free.b)
    if guess is None:
        return None
    tied = is_determined(_nominal(campaigns, seen, rests)[0])  # by the faces known, the frame and K and b in it
    seen = seen or no_dwells()
    bench = dwell_bench(campaigns, seen)
    between = rests is not None and any(rest.up is None for _, rest in rests.rests)
    bench = replace(bench, cubes=bench.cubes if tied else 0, skew_seen=between or not tied)
    model = _AccelerometerModel(bench, seen, rests, tied, quadratic, *guess)
    solved = model.solve()
    if solved is None:
        return None
    k, k_std = np.linalg.norm(guess[0], axis=1), np.sqrt(np.diag(solved[0].covariance)[[0, 4, 8]])
    return None if np.any(k_std > MAX_RELATIVE_SCALE_STD * k) else model.joint(*solved)


def no_dwells() -> TriadDwells:
    """Return no dwells."""
    none = np.zeros((0, 3))
    return TriadDwells((), none, none, np.zeros(3), ())


def with_known_faces(seen: TriadDwells | None, rests: TriadRests | None) -> TriadDwells | None:
    """Return dwells and the rests on a known face as if at that face's first position: for comparing faces."""
    on_face = [i for i, (_, rest) in enumerate(rests.rests) if rest.up is not None] if rests else []
    if rests is None or not on_face:
        return seen
    seen = seen or no_dwells()
    steps = [rests.rests[i] for i in on_face]
    dwells = [(n, DwellRecord(rest.name, first_position(rest.up or ""), rest.series)) for n, rest in steps]
    rate, std = (np.concatenate((a, b[on_face])) for a, b in ((seen.rate, rests.rate), (seen.std, rests.std)))
    return TriadDwells((*seen.dwells, *dwells), rate, std, rests.noise, ())


def _nominal(
    campaigns: Sequence[Campaign], seen: TriadDwells | None, rests: TriadRests | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return nominal specific force [g], output and 1 sigma, each (m, 3), of all steps on known faces."""
    found = [np.zeros((3, 0, 3))]
    if seen is not None and seen.dwells:
        bench = dwell_bench(campaigns, seen)
        found.append(np.array([specific_force(bench, np.zeros(bench.size)), seen.rate, seen.std]))
    for i, (number, rest) in enumerate(rests.rests if rests else ()):
        if rests is not None and rest.up is not None:
            g = campaigns[number].site.gravity / STANDARD_GRAVITY
            u = g * (campaigns[number].fixture.C_sb @ face_normal(rest.up))
            found.append(np.array([[u], rests.rate[i : i + 1], rests.std[i : i + 1]]))
    u, rate, std = np.concatenate(found, axis=1)
    return u, rate, std


def _tied_guess(
    campaigns: Sequence[Campaign], seen: TriadDwells | None, rests: TriadRests | None
) -> tuple[FloatArray, FloatArray] | None:
    u, rate, std = _nominal(campaigns, seen, rests)
    if not is_determined(u):
        return None
    A = np.hstack((u, np.ones((len(u), 1))))
    linear = np.asarray(np.linalg.lstsq(A, rate, rcond=None)[0], dtype=np.float64)
    if np.any(np.linalg.norm(linear[:3], axis=0) < MIN_RESPONSE_SIGMAS * np.median(std, axis=0)):
        return None
    return None if np.linalg.cond(linear[:3]) > MAX_CONDITION_OF_K else (linear[:3].T, linear[3])


def _free_guess(campaigns: Sequence[Campaign], rests: TriadRests) -> NormFit | Undetermined:
    gravity = np.mean([campaigns[n].site.gravity for n, _ in rests.rests]) / STANDARD_GRAVITY
    return fit_norm(rests.rate, rests.std, float(gravity))


def why_not_by_rests(
    campaigns: Sequence[Campaign], seen: TriadDwells | None, rests: TriadRests | None
) -> Undetermined:
    """Say what rests lack that `solve_with_rests` determines no unit by."""
    every = _all_as_rests(seen, rests)
    if every is None or not every.rests:
        return Undetermined(Lack.NO_RESTS, 0)
    found = _free_guess(campaigns, every)
    return found if isinstance(found, Undetermined) else Undetermined(Lack.UNCERTAIN, len(every.rests), AXES)


def _all_as_rests(seen: TriadDwells | None, rests: TriadRests | None) -> TriadRests | None:
    """Return dwells in positions and rests alike as rests in attitudes unknown."""
    parts: list[TriadDwells | TriadRests] = [part for part in (seen, rests) if part is not None]
    if not parts:
        return None
    records = tuple(
        (number, RestRecord(step.name, None, step.series))
        for part in parts
        for number, step in (part.dwells if isinstance(part, TriadDwells) else part.rests)
    )
    rate, std = (np.concatenate([getattr(part, name) for part in parts]) for name in ("rate", "std"))
    return TriadRests(records, rate, std, parts[-1].noise)


@dataclass(frozen=True, eq=False)
class _AccelerometerModel:
    """The residual of dwells, priors and rests; parameters K (9), b (3), the bench's, and K2 (3) if asked for."""

    bench: BenchParameters
    seen: TriadDwells
    rests: TriadRests | None
    tied: bool
    quadratic: bool
    K: FloatArray
    b: FloatArray

    def solve(self) -> tuple[Fit, FloatArray, float] | None:
        """Minimise, weighting the rests by what the minimum before showed; return 1 sigma (n,), scatter [g]."""
        x = np.concatenate((self.K.ravel(), self.b, np.zeros(self.bench.size + 3 * self.quadratic)))
        bends = np.full(self.bench.size + 3 * self.quadratic, 0.1)
        scale = np.concatenate((np.full(12, np.max(np.abs(self.K))), bends))
        noise, excess, angles = self.noise, 0.0, np.zeros(3)
        for _ in range(REWEIGHTINGS if self.rests else 1):
            used = noise, excess
            residual = partial(self.residual, np.hypot(*used), angle_std(angles))
            found = minimise_if_determined(residual, x, scale)
            if found is None:
                return None
            fit = found
            x, noise = fit.x, np.hypot(self.noise, self._second_order(fit))
            angles = x[ANGLES] / x[ANGLES_OF]
            excess = self._scatter(fit, *used)
        return fit, *used

    def _scatter(self, fit: Fit, noise: FloatArray, excess: float) -> float:
        """Return the norms' scatter [g] beyond ``noise`` that a fit weighted by it and ``excess`` shows."""
        free = free_norms(fit, self.rows.stop - self.rows.start, self.rows.start)
        longer = fit.residual[self.rows] * np.hypot(noise, excess)
        return excess_scatter(longer, noise, free) if free else 0.0

    def _second_order(self, fit: Fit) -> FloatArray:
        """Return what E, where only tilted faces give it, leaves open of the norm of a rest on a face (n,) [g].

        A change of E moves u by d across itself, and the norm by as much as d^2.
        """
        if self.rests is None:
            return np.zeros(0)
        u, inverse = self.force(fit.x, self.rests.rate), np.linalg.inv(fit.x[:9].reshape(3, 3))
        moved = np.einsum("ab,nj->nabj", inverse, u).reshape(len(u), 3, 9)
        variance = np.einsum("nap,pq,naq->na", moved, fit.covariance[:9, :9], moved)
        on_face = np.array([rest.up is not None for _, rest in self.rests.rests])
        wide: FloatArray = on_face * variance.sum(axis=1)
        return wide

    @cached_property
    def prior(self) -> BenchPrior:
        return self.bench.priors()

    @cached_property
    def noise(self) -> FloatArray:
        """1 sigma (n,) of the norms by noise [g]."""
        if self.rests is None:
            return np.zeros(0)
        return norm_sigma(self.K, self.b, self.rests.rate, self.rests.std)

    @property
    def rows(self) -> slice:
        begin = 3 * len(self.seen.dwells) + len(self.prior.mean) + len(self.frame)
        return slice(begin, begin + (len(self.rests.rests) if self.rests else 0))

    @property
    def frame(self) -> BoolArray:
        """Mark the priors of K, where no face ties the frame, that are plausible ranges: the angles', the last."""
        return np.repeat([False, True], 0 if self.tied else 3)

    def force(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        """Return the specific force (n, 3) [g], IMU axes, behind outputs (n, 3)."""
        K, b = x[:9].reshape(3, 3), x[9:12]
        linear = u = np.asarray(np.linalg.solve(K, (rate - b).T).T, dtype=np.float64)
        bend = np.linalg.norm(K, axis=1) * x[-3:]
        for _ in range(QUADRATIC_INVERSIONS if self.quadratic else 0):
            u = np.asarray(linear - np.linalg.solve(K, (bend * u**2).T).T, dtype=np.float64)
        return u

    def residual(self, sigma: FloatArray, angle: FloatArray, x: FloatArray) -> FloatArray:
        """Return dwells, priors, what holds the frame, norms, and ups of the rests on known faces, whitened.

        ``sigma`` (n,) [g] is the norms', ``angle`` (3,) [rad] that of the angles between the sensors.
        """
        bench = x[12 : 12 + self.bench.size]
        parts = [self._dwells(x), self.prior.matrix @ bench - self.prior.mean]
        if not self.tied:
            upper = np.array([x[3 * i + j] for i, j in UPPER_TRIANGLE])
            parts += [upper / (HELD_STD_RAD * np.max(np.abs(self.K))), x[ANGLES] / x[ANGLES_OF] / angle]
        if self.rests is not None:
            u = self.force(x, self.rests.rate)
            g = np.array([self.bench.gravity(bench, n) for n, _ in self.rests.rests])
            parts += [(np.linalg.norm(u, axis=1) - g) / sigma, self._ups(u, bench)]
        return np.concatenate(parts)

    def _dwells(self, x: FloatArray) -> FloatArray:
        if not self.seen.dwells:
            return np.zeros(0)
        K, u = x[:9].reshape(3, 3), specific_force(self.bench, x[12 : 12 + self.bench.size])
        model = u @ K.T + x[9:12]
        if self.quadratic:
            model += np.linalg.norm(K, axis=1) * x[-3:] * u**2
        return ((self.seen.rate - model) / np.hypot(self.seen.std, self.unsettled)).ravel()

    @cached_property
    def unsettled(self) -> FloatArray:
        """What the campaigns state of dwells not settled (n, 3) [output/s], 1 sigma."""
        stated = [self.bench.campaigns[n].sigma.unsettled_accelerometer for n, _ in self.seen.dwells]
        return np.outer(np.array(stated) / STANDARD_GRAVITY, np.linalg.norm(self.K, axis=1))

    def _ups(self, u: FloatArray, bench: FloatArray) -> FloatArray:
        """Return how far up tilts more than the face's own tilt, whitened by how far a slab may: 2 rows a rest."""
        assert self.rests is not None
        cubes, found = cube_numbers(self.bench.campaigns), [np.zeros(0)]
        for row, (number, rest) in zip(u, self.rests.rests, strict=True):
            if rest.up is None:
                continue
            up = self.bench.campaigns[number].fixture.C_sb.T @ row
            pair, cube = AXES.index(rest.up[0]), int(cubes[number])
            p, q = self.bench.parallelism(bench, cube)[pair], self.bench.perpendicularity(bench, cube)[pair]
            tilt = p / 2 + (q if rest.up.endswith("up") else -q)
            found.append((up[list(cross_axes(rest.up))] / np.linalg.norm(up) - tilt) / SLAB_TILT_RANGE_RAD)
        return np.concatenate(found)

    def loose(self, rows: int) -> BoolArray:
        """Mark the plausible ranges among the rows after the dwells'; the ups of rests come last."""
        prior = self.prior.loose
        ups = rows - self.rows.stop
        norms = np.zeros(self.rows.stop - self.rows.start, dtype=bool)
        return np.concatenate((prior, self.frame, norms, np.ones(ups, dtype=bool)))

    def joint(self, fit: Fit, noise: FloatArray, excess: float) -> TriadFit:
        rests = None
        if self.rests is not None:
            u = self.force(fit.x, self.rests.rate)
            up = u / np.linalg.norm(u, axis=1)[:, None]
            assumed = () if self.tied else by_prior_alone(fit.leverage[self.rows.start - 3 : self.rows.start])
            rests = RestFit(self.rests, self.rows, noise, excess, up, assumed)
        if not self.tied:
            own = [0, 4, 8]
            variance = np.diag(fit.covariance)[ANGLES] / fit.x[ANGLES_OF] ** 2
            wide = with_second_order(fit.covariance, fit.x[own], own, variance)
            if rests is not None:
                rests = replace(rests, open_scale=np.diag(wide - fit.covariance)[own])
            fit = replace(fit, covariance=wide)
        loose = self.loose(len(fit.residual))
        return TriadFit(fit, self.bench, self.seen, np.zeros(3), self.unsettled, loose, rests, self.quadratic)
