"""What the sensors would go through in a planned campaign: nodes of its dwells, turns and moves, in time."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray, IntArray
from procedures.campaign.campaign import Campaign
from procedures.earth.gravity_and_rate import earth_rate_n
from procedures.effects.effect import Columns, Excitation, ExcitationStep
from procedures.frames import AXES, face_normal, face_of, nominal_C_lb
from procedures.planning.campaign_design import TURNS, CampaignDesign, HandTimes, Placing
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
    for before, at in zip((None, *design.placings), design.placings, strict=False):
        t += 0.0 if at.turn is not None else hands.placing
        if before is not None and design.moves and at.is_carried:
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
    of_nodes: FloatArray = change[number]
    return of_nodes


def _stands(campaign: Campaign, position: int) -> FloatArray:
    C: FloatArray = campaign.fixture.C_sb @ nominal_C_lb(position).T
    return C


def _dwell(campaign: Campaign, at: Placing, begin: float) -> DesignStep:
    C = _stands(campaign, at.position)
    seconds = np.full(DWELL_NODES, at.seconds / DWELL_NODES)
    rate = np.tile(C @ np.degrees(earth_rate_n(campaign.site.latitude)), (DWELL_NODES, 1))
    return DesignStep("dwell", at.position, np.tile(C, (DWELL_NODES, 1, 1)), rate, _times(begin, seconds), seconds)


def _turn(campaign: Campaign, at: Placing, begin: float, seconds: float) -> DesignStep:
    """Return a turn at an even speed with a rest before and after it, a node each."""
    assert at.turn is not None
    step = TURNS[at.turn]
    up = face_normal(face_of(step.start_position))[AXES.index(step.axis)]
    angle = float((1 if step.direction == "+" else -1) * up * 2 * np.pi * step.revolutions)
    turning = abs(np.degrees(angle)) / TURN_SPEED_DEG_S
    rest = max((seconds - turning) / 2, 0.0)
    share = np.concatenate(([0.0], (np.arange(TURN_NODES) + 0.5) / TURN_NODES, [1.0]))
    lengths = np.concatenate(([rest], np.full(TURN_NODES, turning / TURN_NODES), [rest]))
    C = (
        _stands(campaign, step.start_position)
        @ Rotation.from_rotvec(np.outer(-angle * share, [0, 0, 1])).as_matrix()
    )
    vertical, moving = np.array([0.0, 0.0, 1.0]), (share > 0) & (share < 1)
    rate = C @ np.degrees(earth_rate_n(campaign.site.latitude))
    rate += np.outer(moving * np.degrees(angle) / turning, _stands(campaign, step.start_position) @ vertical)
    return DesignStep("turn", step.start_position, C, rate, _times(begin, lengths), lengths)


def _move(campaign: Campaign, before: Placing, after: Placing, begin: float, seconds: float) -> DesignStep:
    """Return the shortest way at an even speed."""
    C0, C1 = _stands(campaign, before.position), _stands(campaign, after.position)
    way = Rotation.from_matrix(C1 @ C0.T).as_rotvec()
    share = (np.arange(MOVE_NODES) + 0.5) / MOVE_NODES
    lengths = np.full(MOVE_NODES, seconds / MOVE_NODES)
    C = Rotation.from_rotvec(np.outer(share, way)).as_matrix() @ C0
    to_end = Rotation.from_rotvec(np.outer(1 - share, way)).as_matrix()
    rate = np.tile(-np.degrees(way) / seconds, (MOVE_NODES, 1))
    return DesignStep("move", after.position, C, rate, _times(begin, lengths), lengths, to_end)


def _times(begin: float, seconds: FloatArray) -> FloatArray:
    found: FloatArray = begin + np.cumsum(seconds) - seconds / 2
    return found
