"""The gyroscopes' joint fit: dwells, hand turns and moves between placings in one least-squares problem.

A dwell says a rate, a turn a total (`procedures.dwells_and_turns.hand_turns`), a move a rotation (`procedures.
dwells_and_turns.placing_moves`). Slab and faces come from the accelerometers' fit with its covariance; moves show
how perpendicular the faces are besides, so that then only the cube's turning as a whole is held.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.campaign.observations import TriadDwells, TurnTotal
from procedures.dwells_and_turns.brisk_moves import without_brisk
from procedures.dwells_and_turns.gyroscope_model import GyroscopeModel, MovesSeen, gyroscope_bench
from procedures.dwells_and_turns.hand_turns import (
    TurnGeometry,
    geometry,
    heading_history,
    is_broken,
    nominal_angle,
    refuse_disagreeing,
)
from procedures.dwells_and_turns.placing_moves import (
    MovesModel,
    PlacingMoves,
    first_guess,
    placing_moves,
    refuse_contradicting,
)
from procedures.dwells_and_turns.turn_leans import TurnLean
from procedures.dwells_and_turns.twelve_position import MIN_RESPONSE_SIGMAS, TriadFit, dwell_bench
from procedures.earth.gravity_and_rate import earth_rate_n
from procedures.frames import face_normal, face_of


@dataclass(frozen=True, slots=True, eq=False)
class GyroscopeFit:
    """The gyroscopes' joint fit, the turns in it and 1 sigma (t, 3) of their totals, closure not in it.

    ``broken`` names turns left out for a gap while turning; ``moves`` is what the moves between placings show;
    ``leans`` (t) how the cube leant in each turn, None where nothing tells.
    """

    joint: TriadFit
    turns: tuple[TurnTotal, ...]
    turn_sigma: FloatArray
    geometry: tuple[TurnGeometry, ...]
    broken: tuple[str, ...]
    moves: MovesSeen | None = None
    leans: tuple[TurnLean | None, ...] = ()


def solve_gyroscope(
    campaigns: Sequence[Campaign],
    seen: TriadDwells,
    turns: Sequence[TurnTotal],
    accelerometer: TriadFit | None,
    leans: Sequence[TurnLean | None] = (),
) -> GyroscopeFit | None:
    """Solve k, E and D of the gyroscopes; None if dwells, turns and moves do not determine them.

    Face and slab tilts come from the accelerometers' fit, with its covariance, where there is one. ``leans`` are
    those of the turns as the accelerometers saw them; none: the cube sat well in all.
    """
    refuse_disagreeing(campaigns, turns)
    guess = _guess(campaigns, seen, turns)
    if guess is None:
        return None
    K, b = guess
    histories = [_history(campaigns, turn, K, b) for turn in turns]
    turned = list(zip(turns, histories, leans or [None] * len(turns), strict=True))
    broken = tuple(turn.record.name for turn, heading, _ in turned if is_broken(turn, heading))
    turned = [each for each in turned if not is_broken(*each[:2])]
    turns, kept = [turn for turn, _, _ in turned], tuple(lean for _, _, lean in turned)
    if broken and _guess(campaigns, seen, turns) is None:
        return None
    shapes = tuple(geometry(turn, heading, campaigns[turn.campaign].sigma.closure) for turn, heading, _ in turned)
    moves = _moves(campaigns, seen, turns)
    if moves is not None:
        moves = without_brisk(moves, K, b)
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


def _moves(campaigns: Sequence[Campaign], seen: TriadDwells, turns: Sequence[TurnTotal]) -> PlacingMoves | None:
    steps = [(number, dwell.name) for number, dwell in seen.dwells]
    steps += [(turn.campaign, turn.record.name) for turn in turns]
    return placing_moves(campaigns, steps, len(seen.dwells), [earth_rate_n(c.site.latitude) for c in campaigns])


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
