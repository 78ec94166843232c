"""Did hand turns about an axis come back to where they began? Judged from pairs, + and -, of one scale factor.

A turn of nominal angle A counts ``k (A + closure)`` along its axis once the rate at rest is taken off. Both
turns of a pair have the same k, so that their ratio less one is ``closure_a / A_a - closure_b / A_b``: normal
about zero, with the variance ``(closure_std^2 + std^2) / A^2`` summed over both; ``std`` is what noise makes of a
turn's angle. Two turns do not say which of them is off: a third does, by agreeing with one of them. Where each
direction agrees with itself and not with the other, no chance closure explains it: the scale factor differs by
direction, or the stops do.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

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
