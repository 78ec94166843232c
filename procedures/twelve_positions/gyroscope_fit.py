"""The gyroscopes' joint fit: dwells, manual rotations and transfers between placements in one least squares.

A dwell gives a rate, a manual rotation a total, a transfer a rotation. Plate and faces come from the
accelerometers' fit with its covariance; where transfers show the faces' perpendicularity, only a rotation of the
cube as a whole is constrained.

*Latitude.* With ``w = Omega (0, cos L, sin L)`` (Titterton and Weston, 3.5.3) an error changes dwells by ``K C
w'`` and turns by ``K C M w'``, ``w' = Omega (0, -sin L, cos L)``. The latitude measured by the dwells is one
linear step, ``min | r + J dx + R (dh, G) |^2``: dh the change of the horizontal rate, G (3, 3) a bias per
specific force, of which ``tr G / 3`` is one with the vertical rate, and the rest the 1 sigma.

*Clock.* Of a second too short by the part e: counting accelerometers scale (k, not E and D). Of counting
gyroscopes dwells scale, and a turn's bias and Earth's rate; of a rate output the integral of a turn but for
these.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.campaign.observations import TriadDwells, TurnTotal
from procedures.geodesy import EARTH_RATE, earth_rate_n
from procedures.positions import face_normal, face_of
from procedures.twelve_positions.accelerometer_fit import MIN_RESPONSE_SIGMAS, TriadFit, dwell_bench
from procedures.twelve_positions.gyroscope_model import GyroscopeModel, MovesSeen, gyroscope_bench
from procedures.twelve_positions.manual_rotations import (
    RotationGeometry,
    geometry,
    heading_history,
    is_broken,
    nominal_angle,
    refuse_disagreeing,
)
from procedures.twelve_positions.placement_transfers import (
    MovesModel,
    PlacementTransfers,
    first_guess,
    placement_transfers,
    refuse_contradicting,
    without_fast,
)
from procedures.twelve_positions.rotation_tilt import RotationTilt
from procedures.units import RAD_S_PER_DEG_H


@dataclass(frozen=True, slots=True, eq=False)
class GyroscopeFit:
    """The gyroscopes' joint fit, the turns in it and 1 sigma (t, 3) of their totals, closure not in it.

    ``broken`` names turns left out for a gap while turning; ``moves`` is what the moves between placements show;
    ``tilts`` (t) how the cube tilted in each turn, None where nothing determines it.
    """

    joint: TriadFit
    turns: tuple[TurnTotal, ...]
    turn_sigma: FloatArray
    geometry: tuple[RotationGeometry, ...]
    broken: tuple[str, ...]
    moves: MovesSeen | None = None
    tilts: tuple[RotationTilt | None, ...] = ()


def solve_gyroscope(
    campaigns: Sequence[Campaign],
    seen: TriadDwells,
    turns: Sequence[TurnTotal],
    accelerometer: TriadFit | None,
    tilts: Sequence[RotationTilt | None] = (),
) -> GyroscopeFit | None:
    """Solve k, E and D of the gyroscopes; None if dwells, turns and moves do not determine them.

    Face and slab tilts come from the accelerometers' fit, with its covariance, where there is one. ``tilts`` are
    those of the turns as the accelerometers saw them; none: the cube sat well in all.
    """
    refuse_disagreeing(campaigns, turns)
    guess = _guess(campaigns, seen, turns)
    if guess is None:
        return None
    K, b = guess
    histories = [_history(campaigns, turn, K, b) for turn in turns]
    turned = list(zip(turns, histories, tilts or [None] * len(turns), strict=True))
    broken = tuple(turn.record.name for turn, heading, _ in turned if is_broken(turn, heading))
    turned = [each for each in turned if not is_broken(*each[:2])]
    turns, kept = [turn for turn, _, _ in turned], tuple(tilt for _, _, tilt in turned)
    if broken and _guess(campaigns, seen, turns) is None:
        return None
    shapes = tuple(geometry(turn, heading, campaigns[turn.campaign].sigma.closure) for turn, heading, _ in turned)
    moves = _moves(campaigns, seen, turns)
    if moves is not None:
        moves = without_fast(moves, K, b)
        if moves is None and not turns:
            return None
    model = GyroscopeModel(campaigns, seen, turns, shapes, accelerometer, moves, kept)
    k = np.linalg.norm(K, axis=1)
    start = np.concatenate((K.ravel(), b, np.zeros(model.size - 12)))
    if moves is not None:
        refuse_contradicting(MovesModel(moves, start[:12], seen.noise), model.carried(start))
    parted = model.fit(start, np.zeros(3), k)
    excess = model.excess(parted.fit)
    if np.any(excess > 0) or moves is not None:
        parted = model.fit(parted.fit.x, excess, k)
    n, steps = len(seen.dwells), parted.steps
    turns = [replace(t, total=t.total - t.seconds * s) for t, s in zip(turns, steps[n:], strict=True)]
    seen = replace(seen, rate=seen.rate - steps[:n])
    loose, unsettled = model.prior.bench.loose, model.unsettled(k)[:n]
    joint = TriadFit(
        parted.fit, model.bench, seen, excess, unsettled, loose, spread=parted.spread, absorbed=parted.absorbed
    )
    carried = model.moved(parted, excess, k) if moves is not None else None
    return GyroscopeFit(joint, tuple(turns), model.sigma(excess, k)[n:], shapes, broken, carried, kept)


def _moves(
    campaigns: Sequence[Campaign], seen: TriadDwells, turns: Sequence[TurnTotal]
) -> PlacementTransfers | None:
    steps = [(number, dwell.name) for number, dwell in seen.dwells]
    steps += [(turn.campaign, turn.record.name) for turn in turns]
    return placement_transfers(
        campaigns, steps, len(seen.dwells), [earth_rate_n(c.site.latitude) for c in campaigns]
    )


def _guess(
    campaigns: Sequence[Campaign], seen: TriadDwells, turns: Sequence[TurnTotal]
) -> tuple[FloatArray, FloatArray] | None:
    """Solve K and b on a nominal bench, by the turns, or by the moves where these do not determine them."""
    found = _guess_from_turns(campaigns, seen, turns)
    moves = _moves(campaigns, seen, ()) if found is None else None
    if moves is None:
        return found
    bench = gyroscope_bench(campaigns, seen, (), False)
    level = np.zeros(bench.size)
    earth = [np.degrees(earth_rate_n(c.site.latitude)) for c in campaigns]
    carried = moves.carried(bench.attitudes(level), np.zeros((0, 3, 3)))
    return first_guess(moves, carried, bench.seen_by_imu(level, earth), seen)


def _history(campaigns: Sequence[Campaign], turn: TurnTotal, K: FloatArray, b: FloatArray) -> FloatArray:
    campaign = campaigns[turn.campaign]
    vertical = float(np.degrees(earth_rate_n(campaign.site.latitude)[2]))
    return heading_history(turn, campaign.fixture.C_sb, K, b, vertical)


def _guess_from_turns(
    campaigns: Sequence[Campaign], seen: TriadDwells, turns: Sequence[TurnTotal]
) -> tuple[FloatArray, FloatArray] | None:
    """Solve K and b linearly on a nominal bench by the turns, Earth rate left out of the turns."""
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


def latitude_rows(gyroscope: GyroscopeFit) -> FloatArray:
    """Return the change of the whitened rows (n,) per radian of latitude."""
    campaigns = gyroscope.joint.bench.campaigns
    change = [
        np.degrees(EARTH_RATE) * np.array([0.0, -np.sin(c.site.latitude), np.cos(c.site.latitude)])
        for c in campaigns
    ]
    return _whitened(gyroscope, _felt(gyroscope, change) @ gyroscope.joint.K.T)


def clock_rows(gyroscope: GyroscopeFit, rate_output: bool) -> FloatArray:
    """Return the change of the whitened rows (n,) per relative error of the time base."""
    joint = gyroscope.joint
    earth = [np.degrees(earth_rate_n(c.site.latitude)) for c in joint.bench.campaigns]
    n = len(joint.seen.dwells)
    seconds = np.concatenate((np.ones(n), [turn.seconds for turn in gyroscope.turns]))
    timed = _felt(gyroscope, earth) @ joint.K.T + seconds[:, None] * joint.b
    if rate_output:
        timed[:n] = 0.0
        timed[n:] -= np.array([turn.total for turn in gyroscope.turns]).reshape(-1, 3)
    return _whitened(gyroscope, timed)


def _felt(gyroscope: GyroscopeFit, vector_n: list[FloatArray]) -> FloatArray:
    """Return (m, 3) what every dwell, then every turn's integral, has of each campaign's vector, IMU axes."""
    joint = gyroscope.joint
    bench, n = joint.bench, len(joint.seen.dwells)
    motion = np.stack([np.eye(3)] * n + [shape.motion for shape in gyroscope.geometry])
    return bench.seen_by_imu(joint.fit.x[12 : 12 + bench.size], vector_n, motion)


def _whitened(gyroscope: GyroscopeFit, change: FloatArray) -> FloatArray:
    sigma = np.concatenate((gyroscope.joint.sigma, gyroscope.turn_sigma))
    rows = np.zeros(len(gyroscope.joint.fit.residual))
    rows[: change.size] = (change / sigma).ravel()
    return rows


def clock_on_accelerometer(value: FloatArray, counts: bool) -> FloatArray:
    """Return the change of k, E, D, ``value`` (15,), per relative error of the time base."""
    return np.concatenate((value[:3] * counts, np.zeros(12)))


def clock_on_moves(value: FloatArray, counts: bool) -> FloatArray:
    """Return the change of gyroscopes' k, E, D by moves, ``value`` (15,): D of counts, k (and so D) of rates."""
    k, D = (np.zeros(3), value[12:]) if counts else (value[:3], value[12:])
    return np.concatenate((k, np.zeros(9), D))


OTHER_BIAS_STD = 0.1 * RAD_S_PER_DEG_H  # rad/s: what the Earth's magnetic field does to a gyroscope unnoticed
CONTRADICTION = 4.5  # sigma
LEAST_FREE = 6  # degrees of freedom that judge the scatter
GRID = np.radians(np.linspace(-90.0, 90.0, 3601))


@dataclass(frozen=True, slots=True)
class MeasuredLatitude:
    """The latitude measured and its 1 sigma, that stated [rad], and by how many sigma the rates contradict it."""

    value: float
    std: float
    stated: float
    sigmas: float

    @property
    def contradicts(self) -> bool:
        """Whether the stated site is not where the gyroscopes were."""
        return self.sigmas > CONTRADICTION


def measured_latitude(gyroscope: GyroscopeFit) -> MeasuredLatitude | None:
    """Return the latitude that a joint fit's residual shows; None where campaigns differ in it or rows are few."""
    joint = gyroscope.joint
    campaigns = joint.bench.campaigns
    stated = {campaign.site.latitude for campaign in campaigns}
    if len(stated) != 1:
        return None
    latitude = stated.pop()
    n = joint.sigma.size
    weight = np.ones(len(joint.fit.residual))
    weight[:n] = (joint.sigma / joint.expected).ravel()  # without the scatter that a wrong latitude itself makes
    added = np.stack([_rows(gyroscope, rate) for rate in _rates(gyroscope)], axis=1)
    absorbed = np.zeros((len(weight), joint.profiled))
    absorbed[: len(joint.absorbed)] = joint.absorbed
    A = np.hstack([added, joint.fit.jacobian, absorbed]) * weight[:, None]
    size = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
    U, s, Vt = np.linalg.svd(A / size, full_matrices=False)
    seen = s > 1e-9 * s[0]
    free = len(weight) - int(seen.sum())
    if free < LEAST_FREE or not seen.all():
        return None
    r = joint.fit.residual * weight
    found = -(Vt.T / s) @ (U.T @ r)
    left = r + (A / size) @ found
    scale = max(float(left @ left) / free, 1.0)
    cov = scale * (Vt.T / s**2) @ Vt / np.outer(size, size)
    found = found / size
    G = found[1:10].reshape(3, 3)
    c = float(np.trace(G)) / 3
    pick = np.zeros(len(found))
    pick[[1, 5, 9]] = 1 / 3
    others = float(np.sqrt(np.sum((G - c * np.eye(3)) ** 2) / 8))
    std_h = float(np.hypot(np.radians(np.sqrt(cov[0, 0])), OTHER_BIAS_STD))
    std_v = float(np.hypot(np.hypot(np.radians(np.sqrt(pick @ cov @ pick)), np.radians(others)), OTHER_BIAS_STD))
    h = EARTH_RATE * np.cos(latitude) + np.radians(found[0])
    v = EARTH_RATE * np.sin(latitude) + np.radians(c)
    return _latitude(float(h), float(v), std_h, std_v, latitude)


def _latitude(h: float, v: float, std_h: float, std_v: float, stated: float) -> MeasuredLatitude:
    """Return the latitude whose Earth rate is nearest to ``h`` and ``v`` [rad/s], by their 1 sigma."""

    def chi2(at: FloatArray) -> FloatArray:
        return np.asarray(
            ((h - EARTH_RATE * np.cos(at)) / std_h) ** 2 + ((v - EARTH_RATE * np.sin(at)) / std_v) ** 2
        )

    best = float(GRID[int(np.argmin(chi2(GRID)))])
    size = EARTH_RATE**2 * (np.sin(best) ** 2 / std_h**2 + np.cos(best) ** 2 / std_v**2)
    more = float(chi2(np.array(stated)) - chi2(GRID).min())
    return MeasuredLatitude(best, float(1 / np.sqrt(size)), stated, float(np.sqrt(max(more, 0.0))))


def _rates(gyroscope: GyroscopeFit) -> list[FloatArray]:
    """Return ten rates (m, 3) [deg/s; of a turn deg], IMU axes: 1 deg/s to the north, then 1 deg/s/g of each G."""
    joint = gyroscope.joint
    bench, dwells = joint.bench, len(joint.seen.dwells)
    motion = np.stack([np.eye(3)] * dwells + [shape.motion for shape in gyroscope.geometry])
    x = joint.fit.x[12 : 12 + bench.size]
    north, up = (
        bench.seen_by_imu(x, [vector] * len(bench.campaigns), motion)
        for vector in (np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    )
    found = [north]
    for i in range(3):
        for j in range(3):
            rate = np.zeros_like(up)
            rate[:, i] = up[:, j]
            found.append(rate)
    return found


def _rows(gyroscope: GyroscopeFit, rate: FloatArray) -> FloatArray:
    """Return the change of the whitened residual (n,) by modelled rates (m, 3) of dwells, integrals of turns."""
    sigma = np.concatenate((gyroscope.joint.sigma, gyroscope.turn_sigma))
    rows = np.zeros(len(gyroscope.joint.fit.residual))
    change = -rate @ gyroscope.joint.K.T / sigma  # the residual is observed less modelled
    rows[: change.size] = change.ravel()
    return rows
