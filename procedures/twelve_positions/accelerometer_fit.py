"""The accelerometers' fit: twelve positions of a cube on a plate, the paper's formulas and the joint solve.

Yao, Hu and He 2018: ``N = k * (E u + D)``, eq. (1), (2); closed form (3)-(8), of perfect faces; two-direction
bias (9)-(11). Eq. (7) divides by k of the gyroscope; the accelerometer's own is meant. The joint solve estimates
face parallelism and slab tilt in addition to k, E and D.

With J turn-ons the bias of turn-on j is ``b + s_j``, the s_j summing to zero: J - 1 more parameters per axis, ``s
= Z t`` with orthonormal contrasts Z (Helmert) and a wide prior, which are profiled out (Frisch, Waugh 1933).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.campaign.campaign import Campaign
from procedures.campaign.observations import TriadDwells, TriadRests
from procedures.statistics.least_squares import Fit, joined_rows, minimise
from procedures.twelve_positions.bench_parameters import BenchParameters, Placement, cube_numbers
from procedures.units import STANDARD_GRAVITY

TurnOn = tuple[int, int]
"""Campaign and turn-on within it, from 1."""


@dataclass(frozen=True, slots=True, eq=False)
class TurnOnFit:
    """A fit without the steps; ``steps`` (n, 3) of the bias of every row's turn-on off the mean [output/s].

    ``spread`` (3,) is 1 sigma of the mean as an estimate of what the bias is at another turn-on's: the standard
    error of J turn-ons; zero where there is one. ``absorbed`` (m, q) are orthonormal columns of what the q steps
    that were fitted besides take of the whitened rows.
    """

    fit: Fit
    steps: FloatArray
    spread: FloatArray
    absorbed: FloatArray


def contrasts(turn_ons: Sequence[TurnOn]) -> FloatArray:
    """Return Z (n, m) [1] of the rows' turn-ons: steps are ``Z t``; no column where no campaign has a second."""
    columns = list[FloatArray]()
    for campaign in sorted({number for number, _ in turn_ons}):
        numbers = sorted({on for of, on in turn_ons if of == campaign})
        of_row = np.array([numbers.index(on) if of == campaign else -1 for of, on in turn_ons])
        for k in range(1, len(numbers)):
            column = np.concatenate((np.full(k, 1.0), [-k], np.zeros(len(numbers) - k - 1), [0.0]))
            columns.append(column[of_row] / np.sqrt(k * (k + 1)))
    return np.column_stack(columns) if columns else np.zeros((len(turn_ons), 0))


def fit_with_turn_ons(
    residual: Callable[[FloatArray, FloatArray], FloatArray], start: FloatArray, scale: FloatArray,
    turn_ons: Sequence[TurnOn], plausible: FloatArray,
) -> TurnOnFit:  # fmt: skip
    """Minimise ``residual(x, steps)`` and the steps of the turn-ons with it, all differences at once.

    Parameters
    ----------
    residual : takes x (..., p) and each row's step (..., n, 3) [output/s] to whitened residuals (..., m)
    start, scale : (p,), as `minimise` takes them
    turn_ons : of the n rows
    plausible : (3,) [output/s], 1 sigma of a step before the first count
    """
    Z, p = contrasts(turn_ons), len(start)
    m = 3 * Z.shape[1]
    if not m:
        none = np.zeros((len(turn_ons), 3))
        fit = minimise(lambda x: residual(x, none), start, scale, at_once=True)
        return TurnOnFit(fit, none, np.zeros(3), np.zeros((len(fit.residual), 0)))
    sigma = np.tile(plausible, Z.shape[1])

    def whole(x: FloatArray) -> FloatArray:
        steps = Z @ x[..., p:].reshape(*x.shape[:-1], -1, 3)
        return joined_rows(x, residual(x[..., :p], steps), x[..., p:] / sigma)

    fit = minimise(whole, np.concatenate((start, np.zeros(m))), np.concatenate((scale, sigma)), at_once=True)
    Q = np.linalg.qr(fit.jacobian[:, p:])[0]
    own = fit.jacobian[:, :p]
    profiled = (own - Q @ (Q.T @ own))[:-m]
    steps = Z @ fit.x[p:].reshape(-1, 3)
    left = Fit(fit.x[:p], fit.covariance[:p, :p], fit.residual[:-m], profiled)
    return TurnOnFit(left, steps, _spread(turn_ons, steps), Q[:-m])


def _spread(turn_ons: Sequence[TurnOn], steps: FloatArray) -> FloatArray:
    """Return the standard error (3,) of the mean over turn-ons; of several campaigns the root mean square."""
    found = list[FloatArray]()
    for campaign in {number for number, _ in turn_ons}:
        of = {on: steps[i] for i, (number, on) in enumerate(turn_ons) if number == campaign}
        if len(of) > 1:
            found.append(np.sum(np.square(list(of.values())), axis=0) / (len(of) * (len(of) - 1)))
    return np.sqrt(np.mean(found, axis=0)) if found else np.zeros(3)


TURN_ON_STEP_STD_G = 5e-3  # g, 1 sigma of what a bias may step by as a unit is switched off and on
MIN_RESPONSE_SIGMAS = 10.0  # sigmas of a dwell's rate that one g must move a channel


@dataclass(frozen=True, slots=True, eq=False)
class ClosedForm:
    """Estimators of Yao 2018: scale factor (3,), misalignment (3, 3), both biases (3,), 1 sigma by counting."""

    scale_factor: FloatArray
    misalignment: FloatArray
    bias_12_position: FloatArray
    bias_12_position_std: FloatArray
    bias_two_direction: FloatArray
    bias_two_direction_std: FloatArray


def closed_form(rate: FloatArray, std: FloatArray) -> ClosedForm:
    """Solve Yao 2018 (3)-(11) from count rates in positions 1..12; specific force in units of local gravity.

    ``rate`` and ``std`` (12, 3) [count/s], 1 sigma, are of sensors in the order of the cube's axes.
    """
    pairs = rate.reshape(3, 2, 2, 3)  # face axis, up or down, heading, sensor
    K = (pairs[:, 0] - pairs[:, 1]).sum(axis=1).T / 4  # (3)-(5)
    k = np.linalg.norm(K, axis=1)  # (6)
    own = np.arange(3)
    two = rate.reshape(3, 4, 3).mean(axis=1)[own, own]  # (9)-(11)
    two_std = np.sqrt((std**2).reshape(3, 4, 3).sum(axis=1)[own, own]) / 4
    twelve_std = np.sqrt(np.sum(std**2, axis=0)) / 12
    return ClosedForm(k, K / k[:, None], rate.mean(axis=0) / k, twelve_std / k, two / k, two_std / k)


def by_position(
    campaigns: Sequence[Campaign], seen: TriadDwells, C_sb: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Return rates and sigmas (12, 3), sensors named by the cube axis they lie along; None if a position lacks.

    Only campaigns with the IMU mounted as ``C_sb`` (3, 3), cube to IMU axes, are looked at; repeats are averaged.
    Reordering the sensors to cube axes makes Yao 2018's formulas hold for an IMU that sits turned in its cube; one
    that points along a cube axis backwards keeps its own sign.
    """
    order = np.argmax(np.abs(C_sb), axis=0)
    mounted = [n for n, campaign in enumerate(campaigns) if np.array_equal(campaign.fixture.C_sb, C_sb)]
    rows, sigmas = [], []
    for position in range(1, 13):
        here = [i for i, (n, d) in enumerate(seen.dwells) if d.position == position and n in mounted]
        if not here:
            return None
        rows.append(seen.rate[here].mean(axis=0)[order])
        sigmas.append(np.sqrt(np.sum(seen.std[here] ** 2, axis=0))[order] / len(here))
    return np.array(rows), np.array(sigmas)


@dataclass(frozen=True, slots=True, eq=False)
class RestFit:
    """The rests' part of a fit: their ``rows``, the norm's 1 sigma (n,) by noise and its ``excess`` [g].

    ``up`` (n, 3) are the up vectors found, of unit length, in IMU axes; ``rows`` hold one norm each. ``assumed``
    names the misalignments that a prior says more of than the rests do. ``open_scale`` (3,) is what the squares of
    angles that the rests do not determine add to the variance of K's diagonal [(output/s per g)^2].
    """

    rests: TriadRests
    rows: slice
    noise: FloatArray
    excess: float
    up: FloatArray
    assumed: tuple[str, ...] = ()
    open_scale: FloatArray = field(default_factory=lambda: np.zeros(3))

    @property
    def sigma(self) -> FloatArray:
        """1 sigma (n,) of the norm [g]."""
        return np.hypot(self.noise, self.excess)


@dataclass(frozen=True, slots=True, eq=False)
class TriadFit:
    """A joint fit: the parameters are K (9) = diag(k) E by rows, b (3) = k D, then the bench's.

    ``fit`` is the whole; to the sigma of every dwell were added ``excess`` (3,), the scatter from dwell to dwell
    that was found beyond counting noise, and ``unsettled`` (n, 3), what the campaign states of it [output/s].
    ``rests`` are the rows of rests outside the twelve positions; with ``quadratic`` K2 (3) stands last in x.
    ``spread`` (3,) is 1 sigma of b as the mean over turn-ons [output/s]; the dwells' rates are freed of its steps,
    which take ``absorbed`` (m, q) of the whitened rows, q of them fitted in addition.
    """

    fit: Fit
    bench: BenchParameters
    seen: TriadDwells
    excess: FloatArray
    unsettled: FloatArray
    loose: BoolArray  # of the rows that follow the dwells'
    rests: RestFit | None = None
    quadratic: bool = False
    spread: FloatArray = field(default_factory=lambda: np.zeros(3))
    absorbed: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def profiled(self) -> int:
        """How many steps of the bias were fitted in addition."""
        return len(self.absorbed.T)

    @property
    def expected(self) -> FloatArray:
        """1 sigma (n, 3) of every dwell without the excess [output/s]."""
        return np.hypot(self.seen.std, self.unsettled)

    @property
    def sigma(self) -> FloatArray:
        """1 sigma (n, 3) of every dwell [output/s]."""
        return np.sqrt(self.expected**2 + self.excess**2)

    @property
    def dof(self) -> int:
        """Degrees of freedom: rows less parameters, less what plausible ranges only seem to add."""
        first = 3 * len(self.bench.placements)
        rows = slice(first, first + len(self.loose))
        idle = float(np.sum((1 - self.fit.leverage[rows])[self.loose]))
        return self.fit.dof - self.profiled - round(idle)

    @property
    def K2(self) -> FloatArray | None:
        """Quadratic coefficient (3,) [g/g^2], None where it was not asked for."""
        return self.fit.x[-3:] if self.quadratic else None

    @property
    def is_turned_freely(self) -> bool:
        """Say whether no known face ties the frame: E is then lower triangular, as in `norm_fit`."""
        return self.bench.cubes == 0

    @property
    def K(self) -> FloatArray:
        """Scale factor times misalignment (3, 3), rows sensors, columns IMU axes."""
        return self.fit.x[:9].reshape(3, 3)

    @property
    def k(self) -> FloatArray:
        """Scale factor (3,) [output/s per unit of the input]."""
        k: FloatArray = np.linalg.norm(self.K, axis=1)
        return k

    @property
    def b(self) -> FloatArray:
        """Scale factor times bias (3,)."""
        return self.fit.x[9:12]


def dwell_bench(campaigns: Sequence[Campaign], seen: TriadDwells) -> BenchParameters:
    """Lay out the bench's parameters for the dwells seen."""
    cubes = cube_numbers(campaigns)
    placements = tuple(
        Placement(number, int(cubes[number]), dwell.position, campaigns[number].sigma.heading)
        for number, dwell in seen.dwells
    )
    return BenchParameters(placements, tuple(campaigns), int(cubes.max()) + 1)


def specific_force(bench: BenchParameters, x: FloatArray) -> FloatArray:
    """Return (..., m, 3) [g] in IMU axes in every placement, for the bench's parameters ``x`` (..., p)."""
    return bench.seen_by_imu(x, gravity_n(bench, x))


def gravity_n(bench: BenchParameters, x: FloatArray) -> list[FloatArray]:
    """Return each campaign's specific force at rest (..., 3) [g], East-North-Up, for parameters ``x`` (..., p)."""
    return [bench.gravity(x, i)[..., None] * [0.0, 0.0, 1.0] for i in range(len(bench.campaigns))]


def missing_positions(seen: TriadDwells | None) -> list[str]:
    """Name the positions of 1..12 that no dwell holds."""
    there = {d.position for _, d in seen.dwells} if seen else set()
    return [f"position {p}" for p in range(1, 13) if p not in there]


def is_determined(u: FloatArray) -> bool:
    """Say whether dwells at the inputs ``u`` (m, 3), any unit, determine a full row of K and a bias."""
    if len(u) < 4:
        return False
    A = np.hstack((u, np.ones((len(u), 1)) * np.max(np.abs(u))))
    return bool(np.linalg.svd(A, compute_uv=False)[-1] > 0.1 * np.max(np.abs(u)))


def solve_accelerometer(campaigns: Sequence[Campaign], seen: TriadDwells) -> TriadFit | None:
    """Solve k, E and D of the accelerometers with slab tilt and face tilts; None if not determined."""
    bench = dwell_bench(campaigns, seen)
    u = specific_force(bench, np.zeros(bench.size))
    if not is_determined(u):
        return None
    linear, *_ = np.linalg.lstsq(np.hstack((u, np.ones((len(u), 1)))), seen.rate, rcond=None)
    if np.any(np.linalg.norm(linear[:3], axis=0) < MIN_RESPONSE_SIGMAS * np.median(seen.std, axis=0)):
        return None
    start = np.concatenate((linear[:3].T.ravel(), linear[3], np.zeros(bench.size)))
    prior = bench.priors()
    scale = np.concatenate((np.full(12, np.max(np.abs(linear))), np.full(bench.size, 0.1)))
    g = [campaigns[number].sigma.unsettled_accelerometer / STANDARD_GRAVITY for number, _ in seen.dwells]
    unsettled = np.outer(g, np.linalg.norm(linear[:3], axis=0))
    sigma = np.hypot(seen.std, unsettled)

    def residual(x: FloatArray, steps: FloatArray) -> FloatArray:
        K, b, of_bench = x[..., :9].reshape(*x.shape[:-1], 3, 3), x[..., None, 9:12], x[..., 12:]
        model = specific_force(bench, of_bench) @ np.swapaxes(K, -1, -2) + b
        off = (seen.rate - steps - model) / sigma
        return joined_rows(x, off, of_bench @ prior.matrix.T - prior.mean)

    turn_ons = [(number, dwell.turn_on) for number, dwell in seen.dwells]
    plausible = TURN_ON_STEP_STD_G * np.linalg.norm(linear[:3], axis=0)
    parted = fit_with_turn_ons(residual, start, scale, turn_ons, plausible)
    seen = replace(seen, rate=seen.rate - parted.steps)
    return TriadFit(
        parted.fit,
        bench,
        seen,
        np.zeros(3),
        unsettled,
        prior.loose,
        spread=parted.spread,
        absorbed=parted.absorbed,
    )
