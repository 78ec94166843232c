"""What a face certificate, a re-mounted IMU or free positions would buy: 1 sigma with and without them.

The joint model of `procedures.twelve_positions.accelerometer_fit`, but that each tilt of each face is known as the
items on the way to it, and the certificate, say, and that K2 may be open. Free positions add their norm,
``|K^-1 (N - b)| = g``, one row each. An IMU turned in the cube does not sit as before: three angles within
`SEATING_STD_RAD` for each mounting but the first.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from procedures.arrays import FloatArray
from procedures.calibration.triad_calibration import scale_misalignment_bias
from procedures.campaign.campaign import Campaign, Fixture, ProcedureSigma, Site
from procedures.frames import rotation
from procedures.statistics.least_squares import minimise
from procedures.tolerance.estimator_errors import ToleranceShape, ToleranceUnit, tilt_std
from procedures.twelve_positions.accelerometer_fit import gravity_n
from procedures.twelve_positions.bench_parameters import (
    HELD_STD_RAD,
    SLAB_TILT_RANGE_RAD,
    BenchParameters,
    Placement,
)
from procedures.units import STANDARD_GRAVITY

# Neither latitude nor gravity's sigma matters to bias or misalignment
ANY_SITE = Site(0.5, STANDARD_GRAVITY, 1e-5)
MOUNTINGS = np.array([np.eye(3), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], [[1, 0, 0], [0, 0, 1], [0, -1, 0]]])
"""The IMU as it sits, turned by 90 deg about z, about x: one turn leaves one combination of K2 and faces."""
SEATING_STD_RAD = 2e-5  # rad, 1 sigma: how well the IMU finds its seat again in the cube
HEADING_STD_RAD = 1e-3  # rad, 1 sigma of a position's heading
K2_STD_G_PER_G2 = 1e-3  # g/g^2, 1 sigma: ten times what quartz accelerometers have
CUBE_EDGES = np.array([u for u in itertools.product((-1.0, 0.0, 1.0), repeat=3) if np.dot(u, u) == 2])  # (12, 3)


@dataclass(frozen=True, slots=True)
class Remedy:
    """What is at hand in addition to twelve positions.

    ``certificate`` is 1 sigma [rad] of every certified tilt, None without a certificate. ``turns`` (0..2): so
    often twelve more positions are taken with the IMU turned in the cube (`MOUNTINGS`). Free positions:
    `CUBE_EDGES`.
    """

    name: str
    certificate: float | None = None
    turns: int = 0
    free_positions: bool = False


@dataclass(frozen=True, slots=True)
class RemedyGain:
    """1 sigma of the worst sensor: bias [g], bias and K2 [g, g/g^2] with K2 open, misalignment [rad]."""

    help: Remedy
    bias: float
    bias_open: float
    K2: float
    misalignment: float


def remedies(certificate: float) -> tuple[Remedy, ...]:
    """Return the cases worth comparing, with certificates of 1 sigma ``certificate`` [rad]."""
    return (
        Remedy("12 positions, the cube as drawn"),
        Remedy("with a face certificate", certificate),
        Remedy("IMU turned once in the cube, 12 more positions", turns=1),
        Remedy("IMU turned twice, 24 more positions", turns=2),
        Remedy("with 12 free positions", free_positions=True),
        Remedy("certificate and free positions", certificate, free_positions=True),
        Remedy("IMU turned twice and free positions", turns=2, free_positions=True),
    )


def remedy_gain(
    help_: Remedy, item: FloatArray, unit: ToleranceUnit, noise: float, shape: ToleranceShape = "uniform"
) -> RemedyGain:
    """Return the sigmas of a campaign of a cube made to the items ``item`` (11,) [rad].

    ``noise`` [g] is 1 sigma of a dwell's mean.
    """
    closed, opened = (_sigma(help_, item, unit, noise, shape, is_open) for is_open in (False, True))
    misaligned = closed[3:12].reshape(3, 3)[~np.eye(3, dtype=bool)]
    worst = (closed[12:15], opened[12:15], opened[15:], misaligned)
    return RemedyGain(help_, *(float(each.max()) for each in worst))


def _sigma(
    help_: Remedy, item: FloatArray, unit: ToleranceUnit, noise: float, shape: ToleranceShape, is_open: bool
) -> FloatArray:
    """Return 1 sigma (18,) of k, E, D and K2."""
    edges = CUBE_EDGES[: len(CUBE_EDGES) * help_.free_positions] / np.sqrt(2)
    model = _RemedyModel(_bench(help_.turns), unit, edges)
    spread = np.maximum(tilt_std(item, shape), HELD_STD_RAD)
    if help_.certificate is not None:
        spread = 1 / np.hypot(1 / spread, 1 / help_.certificate)
    ranges = np.full(3 + 3 * help_.turns, SEATING_STD_RAD)
    ranges[:3] = K2_STD_G_PER_G2 if is_open else HELD_STD_RAD
    prior, start = _prior(model.bench, spread, ranges), model.truth(help_.turns)
    seen = model.outputs(start)

    def residual(x: FloatArray) -> FloatArray:
        return np.concatenate(((seen - model.outputs(x)) / noise, prior @ (x - start)[12:]))

    fit = minimise(residual, start, np.concatenate((np.ones(12), np.full(len(start) - 12, 0.1))))
    _, J = scale_misalignment_bias(unit.E, unit.D, 1.0)
    own, n = np.diag(J @ fit.covariance[:12, :12] @ J.T), 12 + model.bench.size
    return np.sqrt(np.concatenate((own, np.diag(fit.covariance)[n : n + 3])))


@dataclass(frozen=True, slots=True, eq=False)
class _RemedyModel:
    """What is seen of parameters x: K (9), b (3), the bench's, K2 (3), three angles of each turned IMU's seat."""

    bench: BenchParameters
    unit: ToleranceUnit
    edges: FloatArray

    def truth(self, turns: int) -> FloatArray:
        return np.concatenate(
            (self.unit.E.ravel(), self.unit.D, np.zeros(self.bench.size), self.unit.K2, np.zeros(3 * turns))
        )

    def outputs(self, x: FloatArray) -> FloatArray:
        """Return the rates over k of all positions, then the norms less g of the free ones."""
        n = 12 + self.bench.size
        K, b, K2 = x[:9].reshape(3, 3), x[9:12], x[n : n + 3]
        seat = rotation(np.concatenate((np.zeros(3), x[n + 3 :])).reshape(-1, 3))
        C_sb = seat[[at.campaign for at in self.bench.placements]] @ self.bench.C_sb
        up = self.bench.seen(x[12:n], gravity_n(self.bench, x[12:n]))
        f = (C_sb @ up[..., None])[..., 0] @ K.T
        free = self.edges @ self.unit.E.T
        u = (free + self.unit.D + self.unit.K2 * free**2 - b - K2 * (self.edges @ K.T) ** 2) @ np.linalg.inv(K).T
        norm = np.linalg.norm(u, axis=1) - self.bench.gravity(x[12:n], 0)
        return np.concatenate(((f + b + K2 * f**2).ravel(), norm))


def _bench(turns: int) -> BenchParameters:
    campaigns = tuple(
        Campaign("", "", False, ANY_SITE, (), (), ProcedureSigma(HEADING_STD_RAD), Fixture({}, C_sb, "CUBE"))
        for C_sb in MOUNTINGS[: 1 + turns]
    )
    places = itertools.product(range(len(campaigns)), range(1, 13))
    return BenchParameters(
        tuple(Placement(number, 0, position, HEADING_STD_RAD) for number, position in places), campaigns, 1
    )


def _prior(bench: BenchParameters, spread: FloatArray, ranges: FloatArray) -> FloatArray:
    """Return whitened rows: slab, gravity, face tilts by ``spread`` (6,), headings, ``ranges`` of the rest."""
    rows = np.zeros((bench.size, bench.size))
    slabs, faces = 2 * len(bench.campaigns), bench.cube_slice(0)
    np.fill_diagonal(rows[:slabs, :slabs], 1 / SLAB_TILT_RANGE_RAD)
    rows[slabs, slabs] = ANY_SITE.gravity / ANY_SITE.gravity_std
    for row in range(6):
        up, down = spread[row // 2 * 2 : row // 2 * 2 + 2]
        p, q = faces.start + row, faces.start + row + 6
        rows[p, [p, q]] = np.array([0.5, 1.0]) / up
        rows[q, [p, q]] = np.array([0.5, -1.0]) / down
    for i, at in enumerate(bench.placements):
        rows[bench.heading_index(i), bench.heading_index(i)] = 1 / at.heading_std
    return block_diag(rows, np.diag(1 / ranges))
