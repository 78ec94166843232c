"""Hand-turned whole revolutions, + and - about each vertical axis: the gyroscopes' scale factor and misalignment.

A closed turn of R revolutions about the slab's normal integrates to ``2 pi R`` along the resting face's normal,
however uneven the hand, plus what the Earth added. Its vertical part grows with time; its horizontal part is seen
from every heading in turn, so it is integrated over the heading actually turned, which the gyroscope itself
measured. Yao 2018 names the method ("rate method") and prints no equation for it; with K = diag(k) E, b = k D:

    total = K (theta n_b + C_b M w_n) + b T,   M = integral of Rz(-psi(t)) dt,   theta = +-2 pi R + closure

Bias comes from the dwells, in which the horizontal Earth rate cancels between the two headings of a pair.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.campaign.observations import TriadDwells, TurnTotal, channel
from procedures.dwells_and_turns.bench_parameters import BenchParameters, BenchPrior, Placement, cube_numbers
from procedures.dwells_and_turns.turn_ons import TurnOnFit, fit_with_turn_ons
from procedures.dwells_and_turns.twelve_position import MIN_RESPONSE_SIGMAS, TriadFit, dwell_bench
from procedures.earth.gravity_and_rate import earth_rate_n
from procedures.errors import TurnsDisagree
from procedures.frames import AXES, face_normal, face_of
from procedures.statistics.least_squares import Fit
from procedures.units import DEG_H_PER_DEG_S

MAX_SCALE_DISAGREEMENT = 0.1  # of the scale factor: far above any bias, far below a missing revolution
END_REST_S = 2.0  # of rest wanted at each end
MAX_REST_RATE_DEG_S = 0.5  # deg/s
OPEN_CLOSURE_STD_RAD = float(np.radians(0.1))  # 1 sigma of a turn that was not at rest at both ends, at the least
# deg/s, 1 sigma of what a bias may step by as a unit is switched off and on
TURN_ON_STEP_STD_DEG_S = 30 / DEG_H_PER_DEG_S
TILT_FLOOR_RAD = 1e-12  # rad, of what the accelerometers did not leave open


@dataclass(frozen=True, slots=True, eq=False)
class TurnGeometry:
    """A turn's angle about the slab's normal [rad], closure sigma [rad], and M (3, 3) [s]; ``open_ends`` warns."""

    angle: float
    closure_std: float
    motion: FloatArray
    open_ends: bool


def nominal_angle(turn: TurnTotal) -> float:
    """Return the angle [rad] turned about the slab's normal, counter-clockwise seen from above."""
    record = turn.record
    up = face_normal(face_of(record.start_position))[AXES.index(record.axis)]
    return float((1 if record.direction == "+" else -1) * up * 2 * np.pi * record.revolutions)


def heading_history(
    turn: TurnTotal, C_sb: FloatArray, K: FloatArray, b: FloatArray, vertical: float
) -> FloatArray:
    """Return (n,) the angle [rad] turned up to the middle of each sample, scaled to the nominal whole.

    Parameters
    ----------
    turn : of n samples
    C_sb : (3, 3), takes the cube's axes to the IMU's
    K, b : (3, 3) [output/deg], (3,) [output/s]
    vertical : deg/s, the Earth rate's vertical part
    """
    samples = np.asarray(channel(turn.record.series, "gyroscope"), dtype=float)
    rate = samples / turn.record.series.period if turn.counts else samples
    up = C_sb @ face_normal(face_of(turn.record.start_position))
    angle = np.cumsum((rate - b) @ np.linalg.solve(K.T, up) - vertical)
    half = np.diff(angle, prepend=0.0) / 2
    scaled: FloatArray = (angle - half) * nominal_angle(turn) / angle[-1]
    return scaled


def geometry(turn: TurnTotal, heading: FloatArray, closure_std: float) -> TurnGeometry:
    """Integrate the rotation over the ``heading`` (n,) [rad] turned and look whether the ends are at rest."""
    period = turn.record.series.period
    c, s = np.cos(heading).sum() * period, np.sin(heading).sum() * period
    motion = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, len(heading) * period]])
    n = max(round(END_REST_S / period), 1)
    moved = max(np.ptp(heading[:n]), np.ptp(heading[-n:]))
    open_ends = len(heading) < 2 * n or bool(moved > np.radians(MAX_REST_RATE_DEG_S) * END_REST_S)
    wide = max(10 * closure_std, OPEN_CLOSURE_STD_RAD)
    return TurnGeometry(nominal_angle(turn), wide if open_ends else closure_std, motion, open_ends)


def is_broken(turn: TurnTotal, heading: FloatArray) -> bool:
    """Say whether samples were lost while ``heading`` (n,) [rad] changed: the angle in the gap is unknown."""
    gaps = turn.record.series.starts[1:]
    n = max(round(0.1 / turn.record.series.period), 1)
    return any(
        np.ptp(heading[max(g - n, 0) : g + n])
        > np.radians(MAX_REST_RATE_DEG_S) * 2 * n * turn.record.series.period
        for g in gaps
    )


@dataclass(frozen=True, slots=True, eq=False)
class GyroscopeFit:
    """The gyroscopes' joint fit, the turns in it and 1 sigma (t, 3) of their totals, closure not in it.

    ``broken`` names turns left out for a gap while turning.
    """

    joint: TriadFit
    turns: tuple[TurnTotal, ...]
    turn_sigma: FloatArray
    geometry: tuple[TurnGeometry, ...]
    broken: tuple[str, ...]


def solve_gyroscope(
    campaigns: Sequence[Campaign], seen: TriadDwells, turns: Sequence[TurnTotal], accelerometer: TriadFit | None
) -> GyroscopeFit | None:
    """Solve k, E and D of the gyroscopes; None if the dwells and turns do not determine them.

    Face and slab tilts come from the accelerometers' fit, with its covariance, where there is one.
    """
    guess = _first_guess(campaigns, seen, turns)
    if guess is None:
        return None
    refuse_disagreeing(campaigns, turns)
    K, b = guess
    histories = [_history(campaigns, turn, K, b) for turn in turns]
    turned = list(zip(turns, histories, strict=True))
    broken = tuple(turn.record.name for turn, heading in turned if is_broken(turn, heading))
    turned = [(turn, heading) for turn, heading in turned if not is_broken(turn, heading)]
    turns = [turn for turn, _ in turned]
    if broken and _first_guess(campaigns, seen, turns) is None:
        return None
    shapes = tuple(geometry(turn, heading, campaigns[turn.campaign].sigma.closure) for turn, heading in turned)
    model = _GyroscopeModel(campaigns, seen, turns, shapes, accelerometer, np.linalg.norm(K, axis=1))
    start = np.concatenate((K.ravel(), b, np.zeros(model.bench.size + len(turns))))
    parted = model.fit(start, np.zeros(3))
    excess = model.excess(parted.fit)
    if np.any(excess > 0):
        parted = model.fit(parted.fit.x, excess)
    n, steps = len(seen.dwells), parted.steps
    turns = [replace(t, total=t.total - t.seconds * s) for t, s in zip(turns, steps[n:], strict=True)]
    seen = replace(seen, rate=seen.rate - steps[:n])
    loose, unsettled = model.prior.loose, model.unsettled[:n]
    joint = TriadFit(
        parted.fit, model.bench, seen, excess, unsettled, loose, spread=parted.spread, profiled=parted.profiled
    )
    return GyroscopeFit(joint, tuple(turns), model.sigma(excess)[n:], shapes, broken)


def _history(campaigns: Sequence[Campaign], turn: TurnTotal, K: FloatArray, b: FloatArray) -> FloatArray:
    campaign = campaigns[turn.campaign]
    vertical = float(np.degrees(earth_rate_n(campaign.site.latitude)[2]))
    return heading_history(turn, campaign.fixture.C_sb, K, b, vertical)


def _first_guess(
    campaigns: Sequence[Campaign], seen: TriadDwells, turns: Sequence[TurnTotal]
) -> tuple[FloatArray, FloatArray] | None:
    """Solve K and b linearly on a nominal bench, Earth rate left out of the turns."""
    bench = dwell_bench(campaigns, seen)
    earth = [np.degrees(earth_rate_n(c.site.latitude)) for c in campaigns]
    dwell = bench.seen_by_imu(np.zeros(bench.size), earth)
    if not turns:
        return None
    angle = np.array(
        [
            (np.degrees(nominal_angle(t)) + earth[t.campaign][2] * t.seconds)
            * (campaigns[t.campaign].fixture.C_sb @ face_normal(face_of(t.record.start_position)))
            for t in turns
        ]
    )
    if np.linalg.matrix_rank(angle / np.max(np.abs(angle)), tol=0.1) < 3:
        return None
    seconds = np.array([t.seconds for t in turns])
    A = np.vstack((np.hstack((dwell, np.ones((len(dwell), 1)))), np.hstack((angle, seconds[:, None]))))
    y = np.vstack((seen.rate, np.array([t.total for t in turns])))
    solution, *_ = np.linalg.lstsq(A, y, rcond=None)
    swing = np.linalg.norm(solution[:3], axis=0) * np.max(np.abs(angle))
    if np.any(swing < MIN_RESPONSE_SIGMAS * np.median([t.std for t in turns], axis=0)):
        return None
    return solution[:3].T, solution[3]


def refuse_disagreeing(campaigns: Sequence[Campaign], turns: Sequence[TurnTotal]) -> None:
    """Raise `TurnsDisagree` where turns about one axis imply scale factors `MAX_SCALE_DISAGREEMENT` apart."""
    per_turn: dict[int, list[tuple[str, float]]] = {}
    for turn in turns:
        up = campaigns[turn.campaign].fixture.C_sb @ face_normal(face_of(turn.record.start_position))
        sensor = int(np.argmax(np.abs(up)))
        per = float(turn.total[sensor] / up[sensor] / (nominal_angle(turn) / (2 * np.pi)))
        per_turn.setdefault(sensor, []).append((turn.record.name, per))
    for found in per_turn.values():
        first, other = min(found, key=lambda each: each[1]), max(found, key=lambda each: each[1])
        if other[1] - first[1] > MAX_SCALE_DISAGREEMENT * max(abs(other[1]), abs(first[1])):
            raise TurnsDisagree(*first, *other)


class _GyroscopeModel:
    """The residual of dwells, turns and priors; parameters K (9), b (3), the bench's, and a closure per turn."""

    def __init__(
        self,
        campaigns: Sequence[Campaign],
        seen: TriadDwells,
        turns: Sequence[TurnTotal],
        shapes: Sequence[TurnGeometry],
        accelerometer: TriadFit | None,
        k: FloatArray,
    ) -> None:
        cubes = cube_numbers(campaigns)
        steps = [(n, d.position) for n, d in seen.dwells]
        steps += [(t.campaign, t.record.start_position) for t in turns]
        placements = tuple(Placement(n, int(cubes[n]), p, campaigns[n].sigma.heading) for n, p in steps)
        self.bench = BenchParameters(placements, tuple(campaigns), int(cubes.max()) + 1)
        self.seen, self.turns = seen, turns
        self.motion = np.stack([np.eye(3)] * len(seen.dwells) + [s.motion for s in shapes])
        self.angle = np.degrees([s.angle for s in shapes])
        self.closure = np.degrees([s.closure_std for s in shapes])
        self.earth = [np.degrees(earth_rate_n(c.site.latitude)) for c in campaigns]
        self.prior = _tilt_prior(self.bench, accelerometer)
        self.k = k
        # (m, 1): a dwell is known by its rate, a turn by its total
        self.seconds = np.array([1.0] * len(seen.dwells) + [turn.seconds for turn in turns])[:, None]
        self.unsettled = np.outer([np.degrees(campaigns[n].sigma.unsettled_gyro) for n, _ in steps], k)

    def output(self, x: FloatArray) -> FloatArray:
        """Modelled rate of every dwell, then total of every turn, (m, 3)."""
        n, size = len(self.seen.dwells), self.bench.size
        bench = x[12 : 12 + size]
        u = self.bench.seen(bench, self.earth, self.motion)
        normal = self.bench.to_cube(bench)[n:, :, 2]
        u[n:] += (self.angle + x[12 + size :])[:, None] * normal
        K, b = x[:9].reshape(3, 3), x[9:12]
        return (self.bench.C_sb @ u[..., None])[..., 0] @ K.T + self.seconds * b

    def sigma(self, excess: FloatArray) -> FloatArray:
        """1 sigma of every dwell's rate and every turn's total, (m, 3)."""
        std = np.vstack((self.seen.std, np.array([t.std for t in self.turns])))
        expected = np.hypot(std, self.unsettled * self.seconds)
        total: FloatArray = np.sqrt(expected**2 + (excess * self.seconds) ** 2)
        return total

    def fit(self, start: FloatArray, excess: FloatArray) -> TurnOnFit:
        """Minimise with a given scatter of the bias from step to step (3,) [output/s], turn-ons apart."""
        observed = np.vstack((self.seen.rate, np.array([t.total for t in self.turns])))
        sigma, size = self.sigma(excess), self.bench.size
        turn_ons = [(number, dwell.turn_on) for number, dwell in self.seen.dwells]
        turn_ons += [(turn.campaign, turn.record.turn_on) for turn in self.turns]

        def residual(x: FloatArray, steps: FloatArray) -> FloatArray:
            bench, closure = x[12 : 12 + size], x[12 + size :]
            return np.concatenate(
                (
                    ((observed - steps * self.seconds - self.output(x)) / sigma).ravel(),
                    self.prior.matrix @ bench - self.prior.mean,
                    closure / self.closure,
                )
            )

        typical = np.max(np.abs(start[:9]))
        scale = np.concatenate(
            (np.full(9, typical), np.full(3, typical * 1e-2), np.full(size, 0.1), np.full(len(self.turns), 1.0))
        )
        return fit_with_turn_ons(residual, start, scale, turn_ons, TURN_ON_STEP_STD_DEG_S * self.k)

    def excess(self, fit: Fit) -> FloatArray:
        """Return the scatter (3,) of the bias from dwell to dwell beyond what is expected of it [output/s].

        One relative scatter for the triad: the dwells' weighted squares are brought to what the fit leaves free
        (the moment estimator of Mandel and Paule, Anal. Chem. 42, 1970).
        """
        n = len(self.seen.dwells)
        squares = (fit.residual[: 3 * n] ** 2).reshape(n, 3)
        free = (1 - fit.leverage[: 3 * n]).reshape(n, 3)
        k = np.linalg.norm(fit.x[:9].reshape(3, 3), axis=1)
        ratio = float(squares.sum() / free.sum())
        expected = np.hypot(self.seen.std, self.unsettled[:n])
        scatter: FloatArray = k * np.median(expected / k) * np.sqrt(max(ratio - 1, 0.0))
        return scatter


def _tilt_prior(bench: BenchParameters, accelerometer: TriadFit | None) -> BenchPrior:
    """Return the bench's priors with slab and faces replaced by what the accelerometers found."""
    prior = bench.priors()
    if accelerometer is None or accelerometer.is_turned_freely:
        return prior
    shared = bench.shared
    own = accelerometer.fit.covariance[12 : 12 + shared, 12 : 12 + shared]
    white = np.linalg.inv(np.linalg.cholesky(own + TILT_FLOOR_RAD**2 * np.eye(shared)))
    rows = np.zeros((shared, bench.size))
    rows[:, :shared] = white
    headings = prior.matrix[-len(bench.placements) :]
    values = np.concatenate((white @ accelerometer.fit.x[12 : 12 + shared], np.zeros(len(headings))))
    return BenchPrior(values, np.vstack((rows, headings)), np.zeros(len(values), dtype=bool))
