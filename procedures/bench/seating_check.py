"""Whether the cube is seated as in earlier dwells, and whether rotations return to their start.

Seating: one Bayesian fit of ``N = K u + b`` (Yao, Hu, He 2018, eq. 1, 2) to the rates of the accepted dwells,
with the bench's priors and wide ones for K and b. The dwell in question takes part with next to no weight: its
residual and its row of the Jacobian are what the others predict of it, ``cov = J P J'``, widened by the Birge
ratio where they contradict each other (Birge, Phys. Rev. 40, 1932). Dwells before a turn-on have a bias step of
their own.

Rotations: both turns of a pair have one k, so that their ratio less one is ``closure_a / A_a - closure_b / A_b``,
of variance ``(closure_std^2 + std^2) / A^2`` summed over both. A third turn says which of two is off.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, Fixture, ProcedureSigma, Site
from procedures.frames import AXES
from procedures.positions import cross_axes, face_normal, face_of
from procedures.statistics.least_squares import Fit, joined_rows, minimise_if_determined
from procedures.twelve_positions.accelerometer_fit import TURN_ON_STEP_STD_G, specific_force
from procedures.twelve_positions.bench_parameters import BenchParameters, Placement
from procedures.units import RAD_PER_ARCSEC, STANDARD_GRAVITY

SCALE_STD = 0.1  # 1 sigma of k about what a vertical accelerometer counts, or the others do
MISALIGNMENT_STD_RAD = 1e-2  # 1 sigma
BIAS_STD_G = 2e-2  # g, 1 sigma
GRAVITY_STD_M_S2 = 1e-6  # m/s2: g and k are one factor here
JUDGED_DWELL_STD_G = 1e3  # g, 1 sigma of the dwell in question

MIN_TILT_SIGMAS = 5.0  # sigma
MIN_TILT_RAD = 3 * RAD_PER_ARCSEC  # as well as a clean cube comes back to a clean slab
GROSS_TILT_RAD, GROSS_TILT_MAX_STD_RAD = 60 * RAD_PER_ARCSEC, 15 * RAD_PER_ARCSEC
CONTRADICTION_P_VALUE = 1e-4  # probability of a chi2 above which the dwells before contradict each other
MAX_TILT_RAD = 0.1  # rad: a cube whose face passed for upright is not tilted by more; such a fit has failed
# rad: what a cube's own faces may be tilted by, as `bench_parameters.FACE_TILT_RANGE_RAD`
PLAUSIBLE_FACE_TILT_RAD = 1e-3

PositionRates = tuple[int, FloatArray, FloatArray]
"""Position 1..12, accelerometer rates (3,) and 1 sigma (3,) [count/s], IMU axes, raw."""


@dataclass(frozen=True, slots=True, eq=False)
class Seating:
    """How far the cube is tilted from where the dwells before put it [rad], each (2,).

    Measured less predicted up vector along the face's two other cube axes, in x, y, z order; 1 sigma of the
    prediction and of the measurement.
    """

    off: FloatArray
    predicted_std: FloatArray
    measured_std: FloatArray
    axes: str

    @property
    def std(self) -> FloatArray:
        """1 sigma (2,) [rad] of prediction and measurement together."""
        return np.hypot(self.predicted_std, self.measured_std)


def seating(
    accepted: Sequence[PositionRates], now: PositionRates, fixture: Fixture, heading_std: float, *,
    turn_ons: Sequence[int] = (), is_again: bool = True,
) -> Seating | None:  # fmt: skip
    """Compare a dwell, while it is being recorded, with what the accepted ones predict of it.

    None while no other dwell has this face up, or where the dwells before contradict each other so much that they
    predict nothing. Dwells in the position of ``now`` are left out where it ``is_again`` one: they are what is
    being done again; so should be those that are known to sit badly. ``heading_std`` [rad] is how well a
    position's heading is set. ``turn_ons`` says of each accepted dwell at which turn-on it was, 0 being that of
    ``now``; empty: all are of that one.
    """
    position, _, std = now
    face = face_of(position)
    known = zip(accepted, turn_ons or [0] * len(accepted), strict=True)
    used = [(each, on) for each, on in known if on or not is_again or each[0] != position]
    before = [each for each, _ in used]
    if not any(face_of(each[0]) == face for each in before):
        return None
    k = _scale(before, fixture.C_sb)
    fit = _fit(before, now, fixture, heading_std, [on for _, on in used])
    if fit is None or not _is_plausible(fit.x[:9].reshape(3, 3), k):
        return None
    row = slice(3 * len(before), 3 * len(before) + 3)
    to_tilt = (fixture.C_sb.T @ np.linalg.inv(fit.x[:9].reshape(3, 3)))[list(cross_axes(face))]
    J = JUDGED_DWELL_STD_G * to_tilt @ (k[:, None] * fit.jacobian[row])
    predicted: FloatArray = np.sqrt(np.einsum("ip,pq,iq->i", J, fit.covariance, J))
    off: FloatArray = JUDGED_DWELL_STD_G * to_tilt @ (k * fit.residual[row])
    if not np.all(np.abs(off) < MAX_TILT_RAD):
        return None
    return Seating(
        off=off,
        predicted_std=fit.birge_ratio(3 * len(before), CONTRADICTION_P_VALUE) * predicted,
        measured_std=np.sqrt(to_tilt**2 @ std**2),
        axes="".join(AXES[i] for i in cross_axes(face)),
    )


def judge(seating: Seating) -> str:
    """Say why the cube should be lifted; empty if it sits well.

    Off is an axis by more than five sigma of prediction and measurement together, but not by less than 3 arcsec:
    a good cube on a clean slab comes back no better, and nobody should wipe for nothing. Sigma shrinks while
    the dwell lasts; so that a gross tilt need not wait for it, 60 arcsec are enough where sigma is at most 15.
    Chance passes five sigma once in 1.7e6 looks and that second rule's four once in 16000; the latter applies in
    the few seconds only in which sigma falls from 15 to 12 arcsec.
    """
    limit = np.maximum(MIN_TILT_SIGMAS * seating.std, MIN_TILT_RAD)
    limit = np.where(seating.std <= GROSS_TILT_MAX_STD_RAD, np.minimum(limit, GROSS_TILT_RAD), limit)
    worst = int(np.argmax(np.abs(seating.off) / limit))
    if abs(seating.off[worst]) <= limit[worst]:
        return ""
    off, most = seating.off[worst] / RAD_PER_ARCSEC, limit[worst] / RAD_PER_ARCSEC
    way = ("-" if off < 0 else "+") + seating.axes[worst]
    return f"tilted by {abs(off):.0f} arcsec along {way}, limit {most:.0f}"


def _is_plausible(K: FloatArray, k: FloatArray) -> bool:
    """Say whether K is the scale factors ``k`` but for what units differ by; five sigma are granted."""
    off = np.abs(K / k[:, None] - np.eye(3))
    return bool(np.all(off < 5 * np.where(np.eye(3), SCALE_STD, MISALIGNMENT_STD_RAD)))


def _fit(
    before: Sequence[PositionRates], now: PositionRates, fixture: Fixture, heading_std: float,
    turn_ons: Sequence[int] = (),
) -> Fit | None:  # fmt: skip
    """Fit K (9), b (3), bench and other turn-ons' steps; the last dwell's three rows carry no weight."""
    site = Site(0.0, STANDARD_GRAVITY, GRAVITY_STD_M_S2)
    campaign = Campaign("", "", True, site, (), (), ProcedureSigma(heading_std), fixture)
    bench = BenchParameters(
        tuple(Placement(0, 0, each[0], heading_std) for each in (*before, now)), (campaign,), 1
    )
    prior, k = bench.priors(), _scale(before, fixture.C_sb)
    others = sorted(set(turn_ons) - {0})
    of_step = np.array([[on == other for other in others] for on in (*turn_ons, 0)], dtype=float)
    steps = slice(12 + bench.size, None)
    rate = np.array([*(each[1] for each in before), now[1]])
    sigma = np.array([*(each[2] for each in before), JUDGED_DWELL_STD_G * k])
    centre = np.diag(k)
    ranges = np.abs(k)[:, None] * np.where(np.eye(3), SCALE_STD, MISALIGNMENT_STD_RAD)

    def residual(x: FloatArray) -> FloatArray:
        K, b, at = x[..., :9].reshape(*x.shape[:-1], 3, 3), x[..., 9:12], x[..., 12 : steps.start]
        step = x[..., steps].reshape(*x.shape[:-1], -1, 3)
        model = specific_force(bench, at) @ np.swapaxes(K, -1, -2) + b[..., None, :] + of_step @ step
        return joined_rows(
            x,
            (rate - model) / sigma,
            (K - centre) / ranges,
            b / (BIAS_STD_G * k),
            at @ prior.matrix.T - prior.mean,
            step / (TURN_ON_STEP_STD_G * k),
        )

    start = np.concatenate((centre.ravel(), np.zeros(3 + bench.size + 3 * len(others))))
    size = np.abs(k).max()
    scale = np.concatenate((np.full(12, size), np.full(bench.size, 0.1), np.full(3 * len(others), size)))
    return minimise_if_determined(residual, start, scale, at_once=True)


def _scale(dwells: Sequence[PositionRates], C_sb: FloatArray) -> FloatArray:
    """Return what 1 g counts (3,) per second, from the dwells that have a sensor upright.

    A sensor that was never upright is taken to be like the others, and to count forwards.
    """
    up = np.array([C_sb @ face_normal(face_of(position)) for position, _, _ in dwells])
    rate = np.array([rate for _, rate, _ in dwells])
    upright = np.abs(up).sum(axis=0)
    k = (up * rate).sum(axis=0) / np.maximum(upright, 1)
    like: FloatArray = np.where(upright > 0, k, np.mean(np.abs(k[upright > 0])))
    return like


MAX_PAIR_SIGMAS = 3.0  # chance passes it in 0.27 % of honest pairs
MAX_TURNS_PER_AXIS = 6  # turns about an axis after which more of them decide nothing


@dataclass(frozen=True, slots=True)
class TurnCounts:
    """A turn in ``direction`` + or -: counts per revolution, angle [rad], 1 sigma of its noise [rad]."""

    direction: str
    counts: float
    angle: float
    std: float


class Closing(Enum):
    """What the turns about one axis say together, the last two directions standing."""

    ALONE = auto()  # there is no pair yet
    CLOSED = auto()
    ONCE_MORE = auto()  # the last one, or its partner, is off: another of the last one's direction decides
    OTHER = auto()  # the last one is confirmed, its partner is not: that is to be done again
    REPEATS = auto()  # each direction agrees with itself, not with the other
    APART = auto()  # nothing agrees with anything


def pair_difference(one: TurnCounts, other: TurnCounts) -> float:
    """Return by how much more ``one`` turned than ``other`` [rad], as shares of its own angle."""
    return (one.counts / other.counts - 1) * one.angle


def pair_limit(one: TurnCounts, other: TurnCounts, closure_std: float) -> float:
    """Return how far apart [rad] two turns may be whose closures are ``closure_std`` [rad], 1 sigma."""
    share = [np.hypot(closure_std, each.std) / each.angle for each in (one, other)]
    return float(MAX_PAIR_SIGMAS * np.hypot(*share) * one.angle)


def judge_closing(turns: Sequence[TurnCounts], closure_std: float) -> Closing:
    """Judge the turns about one axis in the order in which they were done; the last of each direction stand."""
    last = turns[-1]
    partners = [turn for turn in turns if turn.direction != last.direction]
    if not partners:
        return Closing.ALONE
    partner = partners[-1]

    def agree(one: TurnCounts, other: TurnCounts) -> bool:
        return abs(pair_difference(one, other)) <= pair_limit(one, other, closure_std)

    if agree(last, partner):
        return Closing.CLOSED
    is_sure = any(agree(last, turn) for turn in turns[:-1] if turn.direction == last.direction)
    is_partner_sure = any(agree(partner, turn) for turn in partners[:-1])
    if is_sure and is_partner_sure:
        return Closing.REPEATS
    if len(turns) >= MAX_TURNS_PER_AXIS or (len(turns) > 2 and not is_sure and not is_partner_sure):
        return Closing.APART
    return Closing.OTHER if is_sure else Closing.ONCE_MORE


def closure_scatter(turns: Sequence[TurnCounts]) -> float:
    """Return the closure's 1 sigma [rad] that two or more turns show by how they scatter."""
    counts = np.array([turn.counts for turn in turns])
    angle = float(np.mean([turn.angle for turn in turns]))
    return float(np.std(counts / counts.mean(), ddof=1) * angle)
