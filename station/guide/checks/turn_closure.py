"""Closure of manual rotations: how a turn agrees with others about its axis, and what to repeat if it does not."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.seating_check import (
    Closing,
    TurnCounts,
    closure_scatter,
    judge_closing,
    pair_difference,
    pair_limit,
)
from procedures.campaign.plan_steps import Turn
from procedures.gyrocompass import CertainDwell, heading_change
from station.guide.setup_view import Choice
from station.guide.view import OperatorQuestion
from station.guide.wording import step_title

MAX_HEADING_STD_DEG = 5.0  # a wider sigma says nothing
GROSS_SIGMAS = 4.0  # of the horizontal Earth rate: chance passes it once in 16000 turns
MAX_TURN_ROUNDS = 2  # of turns of which no two agree, after which another one is vain
TURN_AGAIN, WIDEN_CLOSURE = "t", "w"


class TurnClosures:
    """The turns about each axis, what they say together, and ``closure_std`` [rad] as it is stated now."""

    def __init__(self, closure_std: float, before: Iterable[tuple[str, TurnCounts]] = ()) -> None:
        self.closure_std = closure_std
        self._turns: dict[str, list[TurnCounts]] = defaultdict(list)
        self._scatter: dict[str, float] = {}  # of the axes that have not closed
        self._verdict: dict[str, Closing] = {}
        self._rounds: dict[str, int] = defaultdict(int)
        for axis, seen in before:
            self.take(axis, seen)

    def take(self, axis: str, seen: TurnCounts) -> Closing:
        """Take a turn that was recorded; say what the turns about its axis say together."""
        turns = self._turns[axis]
        turns.append(seen)
        found = self._verdict[axis] = judge_closing(turns, self.closure_std)
        self._scatter.pop(axis, None)
        if found not in {Closing.ALONE, Closing.CLOSED}:
            self._scatter[axis] = closure_scatter(turns)
        if found in {Closing.APART, Closing.REPEATS}:
            self._rounds[axis] += 1
            turns.clear()
        return found

    def partner(self, axis: str, direction: str) -> TurnCounts | None:
        """Return the last turn the other way about an axis."""
        return next((turn for turn in reversed(self._turns[axis]) if turn.direction != direction), None)

    def is_unresolvable(self, axis: str) -> bool:
        """Say whether more turns about an axis would decide nothing."""
        found = self._verdict.get(axis)
        return found is Closing.REPEATS or (found is Closing.APART and self._rounds[axis] >= MAX_TURN_ROUNDS)

    def is_open(self, axis: str) -> bool:
        """Say whether the turns about an axis have not closed."""
        return axis in self._scatter

    def undecided(self, axis: str) -> str:
        """Return the direction of the last turn about an axis whose turns did not close, else empty."""
        return self._turns[axis][-1].direction if self.is_open(axis) and self._turns[axis] else ""

    def found_std(self, axis: str) -> float:
        """Return the closure [rad], 1 sigma, that the turns about an axis show, at least the stated one."""
        found = max(self._scatter.get(axis, 0.0), self.closure_std)
        step = 10 ** (np.floor(np.log10(np.degrees(found))) - 1)
        return float(np.radians(np.ceil(np.degrees(found) / step) * step))

    def widen(self, axis: str) -> float:
        """State the closure that the turns about an axis show; return it [rad]."""
        self.closure_std = self.found_std(axis)
        self._scatter.pop(axis, None)
        self._verdict[axis] = Closing.CLOSED
        return self.closure_std

    def question(self, axis: str) -> OperatorQuestion:
        """Ask whether to turn again or to state what was found."""
        wide, stated = np.degrees(self.found_std(axis)), np.degrees(self.closure_std)
        again = {
            Closing.ONCE_MORE: "rotate once more: this shows which of the two was wrong",
            Closing.OTHER: "repeat the rotation in the other direction: that one was wrong",
        }.get(self._verdict[axis], "repeat both directions, after a check of the marks and the stop")
        choices = (
            Choice(key=TURN_AGAIN, title=again),
            Choice(key=WIDEN_CLOSURE, title=f"accept them: closure error {wide:.2g} deg (u), not {stated:.2g}"),
        )
        text = f"The rotations about {axis.upper()} do not meet the stated closure error."
        return OperatorQuestion(text=text, choices=choices)


def agreement_in_words(seen: TurnCounts, partner: TurnCounts | None, closure_std: float) -> str:
    """Say how a turn agrees with its partner; nothing where there is none."""
    if partner is None:
        return ""
    off, most = np.degrees(abs(pair_difference(seen, partner))), np.degrees(pair_limit(seen, partner, closure_std))
    return f"pair differs by {off:.3f} deg (limit {most:.3f})"


def earth_rate_text(change: tuple[float, float] | None) -> str:
    """Return in words how a turn closed by the horizontal Earth rate: angle and 1 sigma [deg]."""
    return "" if change is None else f"closed within {abs(change[0]):.1f} deg (u = {change[1]:.1f} deg)"


def heading_moved(
    before: CertainDwell, after: CertainDwell, latitude: float, C_sb: FloatArray, k: float
) -> tuple[float, float] | None:
    """Return the change of heading [deg], counter-clockwise, with 1 sigma; None where it is not determined.

    ``C_sb`` (3, 3) takes cube axes to the IMU's; ``k`` [count/rad].
    """
    angle, std = np.degrees(heading_change(before, after, latitude, C_sb, k))
    return (float(angle), float(std)) if std < MAX_HEADING_STD_DEG else None


def closure_remedy(found: Closing, step: Turn, off: float, most: float) -> str:
    """Say what the turns about an axis say together, and what is to be done; ``off`` and its limit [rad]."""
    name, other = step_title(step), step_title(_other_way(step))
    how = f"{name} and {other} differ by {np.degrees(abs(off)):.2f} deg, limit {np.degrees(most):.2f}"
    return {
        Closing.ONCE_MORE: f"{how}: one more {name} shows which was wrong",
        Closing.OTHER: f"{how}: {name} is confirmed, repeat {other}",
        Closing.REPEATS: f"{how}, and each repeats: the stop or the scale factor depends on the "
        f"direction; repeat both",
        Closing.APART: f"{how}, and no two agree: check the marks, and that the cube rotates flat; repeat both",
    }[found]


def turns_to_repeat(found: Closing, step: Turn) -> list[str]:
    """Return the turns that are to be done again, the next one last."""
    other = _other_way(step).name
    return {Closing.ONCE_MORE: [step.name], Closing.OTHER: [other]}.get(found, [other, step.name])


def _other_way(step: Turn) -> Turn:
    return replace(step, direction="-" if step.direction == "+" else "+")
