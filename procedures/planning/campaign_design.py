"""A campaign as it could be done: where the cube stands in turn, how long, which turns, and the hands' time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from procedures.campaign.plan_steps import USUAL_ORDER, Dwell, Step, turn_steps
from procedures.units import S_PER_MIN

USUAL_DWELL_S = 100.0
TURNS = turn_steps()


@dataclass(frozen=True, slots=True)
class HandTimes:
    """How long hands take [s]: a placement until its dwell begins, of that the move itself, and a turn."""

    placing: float = 45.0
    move: float = 25.0
    turn: float = 61.0


@dataclass(frozen=True, slots=True)
class Placement:
    """The cube in ``position`` 1..24 for ``seconds``; or the turn number ``turn`` of `TURNS`, from there.

    ``is_carried``: the move to it is recorded and whole.
    """

    position: int
    seconds: float
    turn: int | None = None
    is_carried: bool = True


@dataclass(frozen=True, slots=True)
class CampaignDesign:
    """Placements in their order."""

    placements: tuple[Placement, ...]

    @property
    def positions(self) -> tuple[int, ...]:
        """The positions of the dwells in their order."""
        return tuple(at.position for at in self.placements if at.turn is None)

    def seconds(self, hands: HandTimes) -> float:
        """How long it takes [s]; turns hold their own move."""
        return sum(hands.turn if at.turn is not None else hands.placing + at.seconds for at in self.placements)

    def minutes(self, hands: HandTimes) -> float:
        """How long it takes [min]."""
        return self.seconds(hands) / S_PER_MIN

    def lasting(self, seconds: Sequence[float]) -> "CampaignDesign":
        """Return the design with other lengths of its dwells."""
        left = iter(seconds)
        return CampaignDesign(
            tuple(at if at.turn is not None else replace(at, seconds=next(left)) for at in self.placements)
        )

    def steps(self) -> tuple[Step, ...]:
        """Return the steps of `plan/1`: a position that stood before is a repeat."""
        found, before = list[Step](), dict[int, int]()
        for at in self.placements:
            if at.turn is not None:
                found.append(TURNS[at.turn])
                continue
            repeat = before.get(at.position, 0)
            before[at.position] = repeat + 1
            found.append(Dwell(at.position, at.seconds, repeat))
        return tuple(found)


ROTATION_PLACEMENTS = tuple(Placement(step.start_position, 0.0, i) for i, step in enumerate(TURNS))


def of_positions(positions: Sequence[int], seconds: float, turns: bool = False) -> CampaignDesign:
    """Return dwells of ``seconds`` in ``positions``, and the six manual rotations after them where ``turns``."""
    placements = tuple(Placement(position, seconds) for position in positions)
    return CampaignDesign((*placements, *(ROTATION_PLACEMENTS if turns else ())))


def usual_design(seconds: float = USUAL_DWELL_S) -> CampaignDesign:
    """Return the twelve positions in the paper's order and six turns."""
    return of_positions(USUAL_ORDER, seconds, turns=True)
