"""Which error terms of the instrument a design can identify, and which it cannot separate.

As in a diagnosis an effect's columns, at nominal attitudes, stand next to the joint fit's own, with what is known
of those. Dwells show their mean, turns and moves what they add up to; a move is the shortest way at an even speed,
its specific force gravity alone. Temperatures are not planned: their effects are left out.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.campaign.campaign import Campaign
from procedures.effects import EFFECTS
from procedures.effects.excitation import Columns, Excitation, ExcitationStep
from procedures.evidence.candidates import NAVIGATION_GRADE_STD
from procedures.frames import AXES
from procedures.geodesy import earth_rate_n
from procedures.planning.campaign_design import TURNS, CampaignDesign, HandTimes, Placement
from procedures.planning.design_sigmas import RIDGE, DesignSigmas
from procedures.planning.placement_rows import OWN, SHARED
from procedures.planning.step_information import NO_CLOSURE_STD_RAD
from procedures.positions import face_normal, face_of, nominal_C_lb
from procedures.units import STANDARD_GRAVITY

DWELL_NODES, MOVE_NODES, TURN_NODES = 16, 60, 72
TURN_SPEED_DEG_S = 35.0  # deg/s, of a hand


@dataclass(frozen=True, slots=True, eq=False)
class DesignStep:
    """A dwell, turn or move: of every node attitude ``C_sn`` (n, 3, 3), rate (n, 3) [deg/s], time and length [s].

    ``to_end`` (n, 3, 3) of a move takes the IMU's axes at a node to those at its end.
    """

    kind: str
    position: int
    C_sn: FloatArray
    rate: FloatArray
    t: FloatArray
    seconds: FloatArray
    to_end: FloatArray | None = None

    def rows(self, accel: FloatArray, gyro: FloatArray) -> FloatArray:
        """Return the rows (3 or 6, k) of a step as a joint fit has them, in g, deg/s, deg or rad.

        ``accel`` [g] and ``gyro`` [deg/s] (n, 3, k) are columns at its nodes.
        """
        total: FloatArray = np.einsum("n,nik->ik", self.seconds, gyro)
        if self.to_end is not None:
            turned: FloatArray = -np.radians(np.einsum("n,nij,njk->ik", self.seconds, self.to_end, gyro))
            return turned
        if self.kind == "turn":
            return total
        both = np.concatenate((np.einsum("n,nik->ik", self.seconds, accel), total))
        mean: FloatArray = both / self.seconds.sum()
        return mean


def design_steps(campaign: Campaign, hands: HandTimes, design: CampaignDesign) -> list[DesignStep]:
    """Return dwells and turns in their order, then the moves that are recorded."""
    found, moves, t = list[DesignStep](), list[DesignStep](), 0.0
    for before, at in zip((None, *design.placements), design.placements, strict=False):
        t += 0.0 if at.turn is not None else hands.placing
        if before is not None and at.is_carried:
            moves.append(_move(campaign, before, at, t - hands.move, hands.move))
        step = _dwell(campaign, at, t) if at.turn is None else _turn(campaign, at, t, hands.turn)
        found.append(step)
        t += float(step.seconds.sum())
    return [*found, *moves]


def excitation_of(campaign: Campaign, steps: list[DesignStep]) -> Excitation:
    """Return the coordinates of effects at all nodes; temperatures, vibration and auxiliary channels not known."""
    C_sn, omega = np.concatenate([s.C_sn for s in steps]), np.concatenate([s.rate for s in steps])
    number = np.repeat(np.arange(len(steps)), [len(s.t) for s in steps])
    n = len(number)
    f = C_sn @ np.array([0.0, 0.0, campaign.site.gravity / STANDARD_GRAVITY])
    field = np.full(3, np.nan) if campaign.site.magnetic is None else np.array(campaign.site.magnetic)
    unit, unknown = np.tile(np.eye(3), (n, 1, 1)), np.full(n, np.nan)
    return Excitation(
        f=f, omega=omega, magnetic=C_sn @ field, accel_output=f, gyro_output=omega,
        change=_changes(steps, f, number), t=np.concatenate([s.t for s in steps]),
        rest_s=np.concatenate([s.t - s.t[0] + s.seconds / 2 for s in steps]),
        temperature=unknown, temperature_rate=unknown, auxiliary={}, step=number,
        C_sb=np.tile(campaign.fixture.C_sb, (n, 1, 1)), E_accel=unit, E_gyro=unit,
        steps=tuple(
            ExcitationStep(f"{s.kind} {i}", s.kind, 0, s.position, face_of(s.position))
            for i, s in enumerate(steps)
        ),
        C_sn=C_sn,
    )  # fmt: skip


def rows_of(steps: list[DesignStep], excitation: Excitation, columns: Columns) -> FloatArray:
    """Return an effect's rows (r, k) in all steps, one after the other: g, deg/s, deg or rad per coefficient."""
    nothing = np.zeros((len(excitation.t), 3, len(columns.coefficients)))
    accel = nothing if columns.accel is None else columns.accel
    gyro = nothing if columns.gyro is None else columns.gyro
    found = [s.rows(accel[excitation.step == i], gyro[excitation.step == i]) for i, s in enumerate(steps)]
    return np.concatenate(found)


def _changes(steps: list[DesignStep], f: FloatArray, number: IntArray) -> FloatArray:
    """Return by how much f (n, 3) [g] differs from the step before, in the order of time; nan for the first."""
    change = np.full((len(steps), 3), np.nan)
    order = sorted((i for i, s in enumerate(steps) if s.to_end is None), key=lambda i: float(steps[i].t[0]))
    for before, after in pairwise(order):
        change[after] = f[number == after][0] - f[number == before][-1]
    return change[number]


def _standing_attitude(campaign: Campaign, position: int) -> FloatArray:
    return campaign.fixture.C_sb @ nominal_C_lb(position).T


def _dwell(campaign: Campaign, at: Placement, begin: float) -> DesignStep:
    C = _standing_attitude(campaign, at.position)
    seconds = np.full(DWELL_NODES, at.seconds / DWELL_NODES)
    rate = np.tile(C @ np.degrees(earth_rate_n(campaign.site.latitude)), (DWELL_NODES, 1))
    return DesignStep("dwell", at.position, np.tile(C, (DWELL_NODES, 1, 1)), rate, _times(begin, seconds), seconds)


def _turn(campaign: Campaign, at: Placement, begin: float, seconds: float) -> DesignStep:
    """Return a turn at an even speed with a rest before and after it, a node each."""
    assert at.turn is not None
    step = TURNS[at.turn]
    up = face_normal(face_of(step.start_position))[AXES.index(step.axis)]
    angle = float((1 if step.direction == "+" else -1) * up * 2 * np.pi * step.revolutions)
    turning = abs(np.degrees(angle)) / TURN_SPEED_DEG_S
    rest = max((seconds - turning) / 2, 0.0)
    share = np.concatenate(([0.0], (np.arange(TURN_NODES) + 0.5) / TURN_NODES, [1.0]))
    lengths = np.concatenate(([rest], np.full(TURN_NODES, turning / TURN_NODES), [rest]))
    C0, vertical = _standing_attitude(campaign, step.start_position), np.array([0.0, 0.0, 1.0])
    C = C0 @ Rotation.from_rotvec(np.outer(-angle * share, vertical)).as_matrix()
    rate = C @ np.degrees(earth_rate_n(campaign.site.latitude))
    rate += np.outer(((share > 0) & (share < 1)) * np.degrees(angle) / turning, C0 @ vertical)
    return DesignStep("turn", step.start_position, C, rate, _times(begin, lengths), lengths)


def _move(campaign: Campaign, before: Placement, after: Placement, begin: float, seconds: float) -> DesignStep:
    """Return the shortest way at an even speed."""
    C0, C1 = _standing_attitude(campaign, before.position), _standing_attitude(campaign, after.position)
    way = Rotation.from_matrix(C1 @ C0.T).as_rotvec()
    share = (np.arange(MOVE_NODES) + 0.5) / MOVE_NODES
    lengths = np.full(MOVE_NODES, seconds / MOVE_NODES)
    C = Rotation.from_rotvec(np.outer(share, way)).as_matrix() @ C0
    to_end = Rotation.from_rotvec(np.outer(1 - share, way)).as_matrix()
    rate = np.tile(-np.degrees(way) / seconds, (MOVE_NODES, 1))
    return DesignStep("move", after.position, C, rate, _times(begin, lengths), lengths, to_end)


def _times(begin: float, seconds: FloatArray) -> FloatArray:
    return begin + np.cumsum(seconds) - seconds / 2


STANDS_SIGMAS = 3.0  # of a coefficient of its plausible size
NOTHING = 1e-9  # of information in what nothing excites


@dataclass(frozen=True, slots=True)
class IdentifiableEffect:
    """An effect, whether it would show where it has its plausible size, and which others could take its place."""

    name: str
    is_identified: bool
    not_apart: tuple[str, ...] = ()


def identifiable_effects(sigmas: DesignSigmas, design: CampaignDesign) -> list[IdentifiableEffect]:
    """Return every effect of the instrument of which a design's steps can speak, in the catalogue's order."""
    campaign, hands = sigmas.steps.campaign, sigmas.steps.hands
    steps = design_steps(campaign, hands, design)
    A, known, std = _base(sigmas, design, steps)
    columns = _columns(steps, excitation_of(campaign, steps), std)
    names, edges = list(columns), np.cumsum([0, *(H.shape[1] for H in columns.values())])
    M = _left(np.concatenate(list(columns.values()), axis=1), A, known)
    at = {name: slice(*edges[i : i + 2]) for i, name in enumerate(names)}
    return [_identified(name, M, at) for name in names]


def _left(H: FloatArray, A: FloatArray, known: FloatArray) -> FloatArray:
    """Return the information (k, k) on the coefficients of H (r, k) that the base model A (r, p) leaves."""
    N = A.T @ A + known
    scale = 1 / np.sqrt(np.maximum(np.diag(N), NOTHING))
    whole = N * np.outer(scale, scale) + RIDGE * np.eye(len(N))
    across = scale[:, None] * (A.T @ H)
    return H.T @ H - across.T @ np.linalg.solve(whole, across)


def _identified(name: str, M: FloatArray, at: Mapping[str, slice]) -> IdentifiableEffect:
    own = at[name]
    alone = _is_determined(M[own, own])
    if not alone.any():
        return IdentifiableEffect(name, False)
    alike = list[str]()
    for other, theirs in at.items():
        information = M[theirs, theirs] + np.eye(theirs.stop - theirs.start)  # held to its plausible size
        shared = M[theirs, own]
        left = M[own, own] - shared.T @ np.linalg.solve(information, shared)
        if other != name and not _is_determined(left)[alone].any():
            alike.append(other)
    return IdentifiableEffect(name, True, tuple(alike))


def _is_determined(information: FloatArray) -> BoolArray:
    """Say of each coefficient (k,) whether one of its plausible size stands, by the information on such sizes."""
    variance = np.diag(np.linalg.inv(information + NOTHING * np.eye(len(information))))
    return STANDS_SIGMAS**2 * variance < 1


def _columns(steps: list[DesignStep], excitation: Excitation, std: FloatArray) -> dict[str, FloatArray]:
    """Return whitened columns (r, k), for coefficients of plausible size, of effects that have one way to act."""
    grades = _grades(steps, std)
    found = dict[str, FloatArray]()
    for effect in EFFECTS:
        if effect.kind != "instrument" or effect.is_scatter:
            continue
        ways = effect.columns(excitation)
        if len(ways) != 1 or ways[0].nonlinear:
            continue
        sizes = grades[effect.name.startswith("gyroscope")] * effect.plausible_of(ways[0])
        H = rows_of(steps, excitation, ways[0]) * sizes / std[:, None]
        if np.all(np.isfinite(H)) and H.any():
            found[effect.name] = H
    return found


def _grades(steps: list[DesignStep], std: FloatArray) -> tuple[float, float]:
    """Return by how much plausible sizes of effects are wider than of navigation grade, of each triad."""
    kinds = np.concatenate([np.repeat((0, 1) if s.kind == "dwell" else (2,), 3) for s in steps])
    median = [float(np.median(std[kinds == triad])) for triad in (0, 1)]
    accel, gyro = (max(one / usual, 1.0) for one, usual in zip(median, NAVIGATION_GRADE_STD, strict=True))
    return accel, gyro


def _base(
    sigmas: DesignSigmas, design: CampaignDesign, steps: list[DesignStep]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the base model's whitened rows (r, p), what is known (p, p), and 1 sigma (r,) of every row."""
    info, places = sigmas.steps, design.placements
    n, noise, hands, care = len(places), info.noise, info.hands, info.campaign.sigma
    shared = OWN * n + np.arange(SHARED)
    known = np.zeros((OWN * n + SHARED,) * 2)
    known[np.ix_(shared, shared)] = sigmas.known
    parts = list[tuple[FloatArray, FloatArray, FloatArray]]()  # rows, their columns, variance
    for i, at in enumerate(places):
        own = np.arange(OWN * i, OWN * (i + 1))
        closure = NO_CLOSURE_STD_RAD if at.turn is None else care.closure
        known[own, own] = 1 / np.square([care.heading, care.seat, care.seat, closure])
        if at.turn is not None:
            rows = [(info.rows.turn[at.turn], noise.turn_variance(hands.turn))]
        else:
            seconds = np.array([at.seconds])
            rows = [(info.rows.accel[at.position - 1], noise.accel_variance(seconds)[0]),
                    (info.rows.gyro[at.position - 1], noise.gyro_variance(seconds)[0])]  # fmt: skip
        parts += [(each, np.r_[own, shared], variance) for each, variance in rows]
    for i, at in enumerate(places[1:]):
        if at.is_carried:
            rows_of_move = info.rows.move[places[i].position - 1, at.position - 1]
            columns = np.r_[OWN * i : OWN * (i + 2), shared]
            parts.append((rows_of_move, columns, np.full(3, noise.move_variance(hands.move))))
    std = np.sqrt(np.concatenate([variance for _, _, variance in parts]))
    A = np.zeros((len(std), len(known)))
    for i, (rows_of_part, columns, _) in enumerate(parts):
        A[3 * i : 3 * i + 3, columns] = rows_of_part
    return A / std[:, None], known, std
