"""A cube measured by the IMUs that were calibrated in it: parallelism and skew with an honest covariance.

Per campaign ``N = k (T R C u + D + K2 (C u)^2)``: u the specific force in cube axes, C the nominal mounting, R
how the IMU sat in it (three angles), T lower triangular with rows of unit length. k, R and D belong to a
campaign, T and K2 to the unit, the tilts to the cube. Twelve positions leave per axis one combination of D, K2
and parallelism open: K2 has a prior, common to all that a unit ever measures, which `UnitShare` keeps apart.
Units are joined by the square roots of their information (Bierman, Factorization Methods for Discrete Sequential
Estimation, 1977, ch. 4).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import stats

from procedures.arrays import FloatArray
from procedures.bench.position_checks import refuse_wrong_faces
from procedures.campaign.campaign import Campaign, MeasuredCube
from procedures.campaign.dead_channels import without_dead
from procedures.campaign.measured_cube import NAMES, SKEW, CubeMeasurement, UnitShare, from_tilts, turning
from procedures.campaign.observations import TriadDwells, TriadRests, dwell_rates, rest_rates
from procedures.errors import NotObservable
from procedures.frames import rotation
from procedures.statistics.least_squares import Fit, minimise
from procedures.twelve_positions.accelerometer_fit import MIN_RESPONSE_SIGMAS, is_determined
from procedures.twelve_positions.bench_parameters import (
    FACE_TILT_RANGE_RAD,
    SLAB_TILT_RANGE_RAD,
    BenchParameters,
    Placement,
)
from procedures.units import STANDARD_GRAVITY

K2_STD_G_PER_G2 = 5e-5  # g/g^2, 1 sigma: a servo accelerometer's K2 is some 10 to 100 ug/g^2
DOUBTFUL_P_VALUE = 0.01  # p-value of a test below which what it tests is reported as ambiguous
# rad: no range is assumed of parallelism, which would pull two measurements of a cube alike
PARALLELISM_RANGE_RAD = 1.0
# rad, 1 sigma: how far the cube's mean normals turn as a whole from the axes of its drawing
CUBE_TURN_STD_RAD = 1e-4
WEAK_SHARE_OF_RANGE = 0.1  # of a plausible range: what a unit knows no better is left to the range
MAX_SKEW_STD_RAD = FACE_TILT_RANGE_RAD / 3  # rad: a skew known no better than this comes from its plausible range
# rad: a parallelism known no better than this says nothing: a pair has two faces
MAX_PARALLELISM_STD_RAD = FACE_TILT_RANGE_RAD * np.sqrt(2)
CUBE, T, K2, CAMPAIGNS_FROM = slice(0, 12), slice(12, 15), slice(15, 18), 18  # where a unit's parameters stand
CUBE_AND_K2 = np.r_[CUBE, K2]
PER_CAMPAIGN = 11  # per campaign in addition to headings: k (relative), R, D, 3 each, slab 2


def measure_cube(campaigns: Sequence[Campaign], quadratic_std: float = K2_STD_G_PER_G2) -> CubeMeasurement:
    """Measure the cube that all ``campaigns``, of one unit or several, were recorded with.

    Raises
    ------
    NotObservable
        If a campaign's dwells do not determine its accelerometers, or no value of the cube is determined.
    WrongFace, FitsNoFace, WrongMounting
        If they contradict a dwell's position, or the way the IMU sits in the cube.
    """
    campaigns, left_out = without_dead(campaigns)
    dead = [text for text in left_out if text.startswith("accelerometer")]
    try:
        return _measured(campaigns, quadratic_std, dead)
    except NotObservable as error:
        raise NotObservable(error.what, [*error.missing, *dead]) from None


def _measured(campaigns: Sequence[Campaign], quadratic_std: float, dead: Sequence[str]) -> CubeMeasurement:
    by_unit: dict[str, list[Campaign]] = {}
    for campaign in campaigns:
        by_unit.setdefault(f"{campaign.model} {campaign.serial}", []).append(campaign)
    units = {name: _Unit(tuple(each)) for name, each in by_unit.items()}
    warnings, roots = list(dead), list[tuple[FloatArray, FloatArray]]()
    for name, unit in units.items():
        fit, p_value, factor = unit.solve(quadratic_std)
        roots.append(unit.root(fit, quadratic_std))
        if p_value < DOUBTFUL_P_VALUE:
            warnings.append(
                f"{name}: residuals exceed counting noise (p = {p_value:.2g}); its uncertainties were "
                f"multiplied by {factor:.2g}"
            )
    return _joined(list(units), roots, quadratic_std, warnings)


def _joined(
    names: Sequence[str],
    roots: Sequence[tuple[FloatArray, FloatArray]],
    quadratic_std: float,
    warnings: Sequence[str],
) -> CubeMeasurement:
    """Join the units' roots over (cube, K2 of each unit) and what is plausible."""
    size = 12 + 3 * len(names)
    blocks, means = [_plausible(len(names), quadratic_std)], [np.zeros(size)]
    for i, (root, mean) in enumerate(roots):
        block = np.zeros((len(root), size))
        block[:, :12], block[:, 12 + 3 * i : 15 + 3 * i] = root[:, 3:], root[:, :3]
        blocks.append(block)
        means.append(mean)
    A, z = np.vstack(blocks), np.concatenate(means)
    inverse = np.linalg.inv(np.linalg.qr(A, mode="r"))
    covariance = inverse @ inverse.T
    x = np.asarray(np.linalg.lstsq(A, z, rcond=None)[0], dtype=np.float64)
    G = np.hstack((from_tilts(), np.zeros((len(NAMES), size - 12))))
    kept = _seen(G @ covariance @ G.T)
    if not kept.any():
        raise NotObservable("the cube", ["dwells on both faces of a pair"])
    G = G[kept]
    shares = tuple(_share(name, i, G, covariance, quadratic_std) for i, name in enumerate(names))
    total: FloatArray = G @ covariance @ G.T
    noise = total - quadratic_std**2 * sum(
        (share.by_quadratic @ share.by_quadratic.T for share in shares), np.zeros(total.shape)
    )
    chi2, dof = _consistency(A, z, x, covariance)
    found = MeasuredCube(tuple(np.array(NAMES)[kept].tolist()), G @ x, total, tuple(names))
    p_value = float(stats.chi2.sf(chi2, dof)) if dof > 0 else 1.0
    measurement = CubeMeasurement(found, noise, shares, chi2, dof, p_value, tuple(warnings))
    if p_value >= DOUBTFUL_P_VALUE:
        return measurement
    text = f"the units, or K2 and its range, disagree: chi-square {chi2:.4g} at {dof} degrees of freedom"
    return replace(measurement, warnings=(*warnings, f"{text}, p {p_value:.2g}"))


def _plausible(units: int, quadratic_std: float) -> FloatArray:
    """Return (n, n), n = 12 + 3 units: rows that whiten parallelism, skew, turning, and each unit's K2."""
    rows = np.zeros((12 + 3 * units, 12 + 3 * units))
    ranges = np.where([name in SKEW for name in NAMES], FACE_TILT_RANGE_RAD * np.sqrt(2), PARALLELISM_RANGE_RAD)
    rows[:9, :12] = from_tilts() / ranges[:, None]
    rows[9:12, :12] = turning() / (CUBE_TURN_STD_RAD * np.sqrt(2))
    rows[12:, 12:] = np.eye(3 * units) / quadratic_std
    return rows


def _seen(covariance: FloatArray) -> FloatArray:
    """Mark the values (9,) that are measured: those known better than is plausible."""
    std = np.sqrt(np.diag(covariance))
    most = np.array([MAX_SKEW_STD_RAD if name in SKEW else MAX_PARALLELISM_STD_RAD for name in NAMES])
    return np.asarray(std < most)


def _share(name: str, i: int, G: FloatArray, covariance: FloatArray, quadratic_std: float) -> UnitShare:
    """Return what a unit's K2 does: the posterior mean moves by -Cov(x, K2) / sigma^2 of it (prior mean 0)."""
    own = slice(12 + 3 * i, 15 + 3 * i)
    left = np.sqrt(np.diag(covariance)[own])
    return UnitShare(name, -(G @ covariance[:, own]) / quadratic_std**2, quadratic_std, left)


def _consistency(A: FloatArray, z: FloatArray, x: FloatArray, covariance: FloatArray) -> tuple[float, int]:
    """Return chi-square and degrees of freedom of the joined units, without the cube's plausible ranges."""
    residual, leverage = A @ x - z, np.einsum("ij,jk,ik->i", A, covariance, A)
    return float(np.sum(residual[12:] ** 2)), max(0, round(float(np.sum(1 - leverage[12:]))))


class _Unit:
    """One unit's campaigns; parameters: cube (12), T (3), K2 (3), per campaign `PER_CAMPAIGN` and headings."""

    def __init__(self, campaigns: tuple[Campaign, ...]) -> None:
        seen = [dwell_rates([campaign], "accelerometer") for campaign in campaigns]
        if any(each is None for each in seen):
            raise NotObservable("the cube", ["dwells of the accelerometers in face positions"])
        self.stands = [
            _CampaignOnCube(campaign, each) for campaign, each in zip(campaigns, seen, strict=True) if each
        ]
        self.T = self.stands[0].T

    def solve(self, quadratic_std: float) -> tuple[Fit, float, float]:
        """Return the fit, its p-value, and the factor that every sigma was then multiplied by."""
        size = CAMPAIGNS_FROM + sum(stand.size for stand in self.stands)
        start = np.zeros(size)
        start[T] = self.T
        scale = np.full(size, 0.1)
        plausible = _plausible(1, quadratic_std)
        fit = minimise(lambda x: self._residual(x, plausible), start, scale)
        chi2, dof = self._fit_quality(fit)
        p_value = float(stats.chi2.sf(chi2, dof)) if dof > 0 else 1.0
        if p_value >= DOUBTFUL_P_VALUE:
            return fit, p_value, 1.0
        factor = float(np.sqrt(chi2 / dof))
        for stand in self.stands:
            stand.factor = factor
        return minimise(lambda x: self._residual(x, plausible), fit.x, scale), p_value, factor

    def root(self, fit: Fit, quadratic_std: float) -> tuple[FloatArray, FloatArray]:
        """Return the square root (r, 15) of the information on K2 (3) and cube (12), and its mean (r,).

        Everything else is eliminated; the rows of what is plausible are left out. So is what the unit hardly
        knows: to second order it depends on where the unit's own fit stands.
        """
        columns = np.r_[np.arange(12, 15), np.arange(CAMPAIGNS_FROM, len(fit.x)), np.arange(15, 18), np.arange(12)]
        J = fit.jacobian[15:]
        rows = np.column_stack((J[:, columns], J @ fit.x - fit.residual[15:]))
        whole = np.asarray(np.linalg.qr(rows, mode="r"), dtype=np.float64)
        R = whole[len(columns) - 15 : len(columns), len(columns) - 15 :]
        ranges = np.concatenate((np.full(3, quadratic_std), np.full(12, FACE_TILT_RANGE_RAD)))
        U, known, _ = np.linalg.svd(R[:, :-1] * ranges)
        R = U[:, known > 1 / WEAK_SHARE_OF_RANGE].T @ R
        return R[:, :-1], R[:, -1]

    def _residual(self, x: FloatArray, plausible: FloatArray) -> FloatArray:
        """Return priors of cube and K2 (15 rows), then each campaign's dwells, rests and priors, whitened."""
        parts, at = [plausible @ x[CUBE_AND_K2]], CAMPAIGNS_FROM
        for stand in self.stands:
            parts.append(stand.residual(x[CUBE], x[T], x[K2], x[at : at + stand.size]))
            at += stand.size
        return np.concatenate(parts)

    def _fit_quality(self, fit: Fit) -> tuple[float, int]:
        rows = np.concatenate([np.zeros(15, dtype=bool), *(stand.observed for stand in self.stands)])
        return float(np.sum(fit.residual[rows] ** 2)), round(float(np.sum((1 - fit.leverage)[rows])))


class _CampaignOnCube:
    """One campaign on the cube: its dwells, its rests outside the positions, and what belongs to it alone."""

    def __init__(self, campaign: Campaign, seen: TriadDwells) -> None:
        refuse_wrong_faces(seen, [campaign.fixture.C_sb])
        at = tuple(Placement(0, 0, dwell.position, campaign.sigma.heading) for _, dwell in seen.dwells)
        self.bench = BenchParameters(at, (campaign,), 1)
        self.campaign, self.seen, self.factor = campaign, seen, 1.0
        self.gravity = campaign.site.gravity / STANDARD_GRAVITY
        self.size = PER_CAMPAIGN + len(at)
        self.C_sb = campaign.fixture.C_sb
        K, b = self._affine()
        self.k = np.linalg.norm(K, axis=1)
        self.D, self.T, self.Q = b / self.k, *_lower_and_turn(K / self.k[:, None])
        unsettled = campaign.sigma.unsettled_accelerometer / STANDARD_GRAVITY
        self.std = np.hypot(seen.std / self.k, unsettled)
        self.rests = rest_rates([(0, rest) for rest in campaign.rests], "accelerometer")
        self._last: tuple[bytes, FloatArray] = b"", np.zeros(0)

    @property
    def observed(self) -> FloatArray:
        rests = 0 if self.rests is None else len(self.rests.rests)
        n = len(self.seen.dwells)
        return np.repeat([True, False], [3 * n + rests, 2 + n])

    def _affine(self) -> tuple[FloatArray, FloatArray]:
        """Return K (3, 3) and b (3,) of perfect faces."""
        up = np.array([0.0, 0.0, self.gravity])
        u = self.bench.seen(np.zeros(self.bench.size), [up]) @ self.C_sb.T
        if not is_determined(u):
            raise NotObservable("the cube", ["dwells in the twelve positions"])
        linear = np.asarray(np.linalg.lstsq(np.hstack((u, np.ones((len(u), 1)))), self.seen.rate, rcond=None)[0])
        if np.any(np.linalg.norm(linear[:3], axis=0) < MIN_RESPONSE_SIGMAS * np.median(self.seen.std, axis=0)):
            raise NotObservable("the cube", ["accelerometers that respond to gravity on every axis"])
        return linear[:3].T, linear[3]

    def residual(self, cube: FloatArray, t: FloatArray, K2: FloatArray, own: FloatArray) -> FloatArray:
        """Return dwells, norms of rests, then slab and headings against their priors, whitened.

        What was made last is kept: most parameters that a Jacobian moves are another campaign's.
        """
        key = np.concatenate((cube, t, K2, own, [self.factor])).tobytes()
        if key != self._last[0]:
            self._last = key, self._residual(cube, t, K2, own)
        return self._last[1]

    def _residual(self, cube: FloatArray, t: FloatArray, K2: FloatArray, own: FloatArray) -> FloatArray:
        gain, turn, bias, tilt = 1 + own[:3], rotation(own[3:6]) @ self.Q, self.D + own[6:9], own[9:11]
        E = _lower(t) @ turn
        x = np.concatenate((tilt, [0.0], cube, own[PER_CAMPAIGN:]))
        u = self.bench.seen(x, [np.array([0.0, 0.0, self.gravity])]) @ self.C_sb.T
        model = gain * (u @ E.T + bias + K2 * u**2)
        parts = [((self.seen.rate / self.k - model) / (self.factor * self.std)).ravel()]
        if self.rests is not None:
            parts.append(self._norms(self.rests, gain, E, bias, K2))
        parts += [tilt / SLAB_TILT_RANGE_RAD, own[PER_CAMPAIGN:] / self.campaign.sigma.heading]
        return np.concatenate(parts)

    def _norms(
        self, rests: TriadRests, gain: FloatArray, E: FloatArray, bias: FloatArray, K2: FloatArray
    ) -> FloatArray:
        """Return how much longer than gravity the specific force of each rest is, whitened."""
        inverse = np.linalg.inv(E).T
        y = rests.rate / self.k / gain - bias
        u = y @ inverse
        for _ in range(3):  # each a thousand times nearer
            u = (y - K2 * u**2) @ inverse
        norm = np.linalg.norm(u, axis=1)
        std = np.linalg.norm(u @ inverse.T / norm[:, None] * rests.std / self.k, axis=1)
        whitened: FloatArray = (norm - self.gravity) / (self.factor * std)
        return whitened


def _lower(t: FloatArray) -> FloatArray:
    """Return T (3, 3): lower triangular, rows of unit length, ``t`` (3,) below its diagonal."""
    T = np.array([[1.0, 0.0, 0.0], [t[0], 0.0, 0.0], [t[1], t[2], 0.0]])
    T[1, 1], T[2, 2] = np.sqrt(1 - t[0] ** 2), np.sqrt(1 - t[1] ** 2 - t[2] ** 2)
    return T


def _lower_and_turn(E: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return t (3,) and Q (3, 3) orthogonal with ``E = T Q``; E has rows of unit length."""
    Q, R = np.linalg.qr(E.T)
    sign = np.sign(np.diag(R))
    L = (R * sign[:, None]).T
    return L[[1, 2, 2], [0, 0, 1]], (Q * sign).T
