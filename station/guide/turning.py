"""A hand turn under way: rest, turn, rest; counted live, and accepted once it has come back."""

from typing import TYPE_CHECKING, Any

import numpy as np

from procedures.frames import face_of
from procedures.gyrocompass import scale
from procedures.steps import Turn
from station.guide.closing import came_back, in_words
from station.guide.desk import Desk
from station.guide.judge import Look
from station.guide.stage import Stage
from station.guide.view import Question, TurnView
from station.guide.which_way import NEITHER, which_way
from station.guide.wording import sense, task, times, title
from station.live.spans import merged
from station.live.stillness import Block
from station.live.turning import TurnWatch

if TYPE_CHECKING:
    from station.guide.resting import Again

TOUCHED_REVOLUTIONS = 0.1  # less is no turn, but a hand on the cube
SLOW_DEG_S, FAST_DEG_S = 5.0, 100.0


class Turning:
    """One attempt at the turn ``step``, the cube resting on its face."""

    def __init__(self, desk: Desk, step: Turn, again: "Again") -> None:
        self._desk, self._step, self._again = desk, step, again
        self._watch = TurnWatch(step, desk.C_ib, desk.feed.period, list(desk.turns.values()))
        self._position = desk.position
        self._rested: list[Block] = []
        self._is_ready = False

    @property
    def oldest(self) -> int | None:
        """The first sample that is still needed."""
        return self._watch.first.first if self._watch.first else None

    @property
    def is_moving(self) -> bool:
        """Whether the turn is under way."""
        return self._watch.is_moving

    def take(self, block: Block, look: Look) -> Stage:
        """Take a second of the stream."""
        if self._is_ready:
            return self._follow(block, look)
        if look.hindrance:
            return self._again(self._desk, "", must_move=False)
        self._watch.rest(block)
        self._rested.append(block)
        if why := self._wrong_heading():
            return self._again(self._desk, why, must_move=True)
        if self._position and self._watch.rested_s >= self._watch.rest_blocks - 0.5:
            self._is_ready = True
            self._desk.story.say("start", f"turn now: {times(self._step)} {sense(self._step)}")
        return self

    def interrupted(self) -> Stage:
        """Give the turn up: the stream broke it."""
        self._desk.position = 0
        return self._again(self._desk, "the stream was interrupted; the turn begins again", must_move=False)

    def answer(self, key: str) -> None:
        """Take the operator's word for the position."""
        if key in {choice.key for choice in which_way(face_of(self._step.start_position)).choices}:
            self._position = -1 if key == NEITHER else int(key)

    def shown(self) -> dict[str, Any]:
        """Return how far the turn is."""
        watch = self._watch
        per_degree = self._desk.rough_gyro_k(watch.rest_rate) * np.pi / 180
        turn = TurnView(
            revolutions=self._revolutions(),
            wanted=self._step.revolutions,
            speed_deg_s=abs(watch.count_rate) / per_degree if watch.is_moving else 0.0,
            slow_deg_s=SLOW_DEG_S, fast_deg_s=FAST_DEG_S,
            rest_s=watch.rested_s, rest_wanted_s=float(watch.rest_blocks),
        )  # fmt: skip
        line, hint = task(self._step, is_there=True), ""
        if not self._is_ready:
            hint = "keep your hands off: rest before the turn"
        elif watch.is_moving:
            line = f"{title(self._step)}: {abs(turn.revolutions):.2f} of {turn.wanted} turns"
            hint = "hands off: rest after the turn" if watch.rested_s else self._advice(turn)
        return {
            "stage": "turn", "live": self._step.name, "line": line, "hint": hint, "turn": turn,
            "question": self._question, "position": self._position,
        }  # fmt: skip

    def _advice(self, turn: TurnView) -> str:
        is_plus = turn.revolutions > 0
        if abs(turn.revolutions) > TOUCHED_REVOLUTIONS and is_plus != (self._step.direction == "+"):
            return f"the other way round: {sense(self._step)} seen from above"
        return _speed(turn)

    @property
    def _question(self) -> Question | None:
        if self._position or not self._desk.facts.asks or self._watch.rested_s < self._watch.rest_blocks - 0.5:
            return None
        return which_way(face_of(self._step.start_position))

    def _wrong_count(self) -> str:
        """Say whether the Earth's rate tells another number of revolutions; later turns have the first."""
        desk, wanted = self._desk, self._step.revolutions
        if desk.turns:
            return ""
        found = abs(self._revolutions())
        if scale(desk.known, desk.facts.latitude, desk.C_ib) is None or round(found) == wanted:
            return ""
        return f"it was about {found:.1f} revolutions, expected {wanted}"

    def _revolutions(self) -> float:
        """Return how far it has turned since it began to move."""
        if not self._watch.is_moving:
            return 0.0
        return self._watch.turned_counts / (2 * np.pi * self._desk.rough_gyro_k(self._watch.rest_rate))

    def _wrong_heading(self) -> str:
        """Find where the cube stands; say what is wrong with it."""
        desk, step = self._desk, self._step
        if not self._position:
            rate = np.mean([block.rate[:3] for block in self._rested], axis=0)
            found = desk.heading(rate, len(self._rested), face_of(step.start_position))
            if found.is_sure:
                self._position = found.position or -1
            elif not desk.facts.asks and self._watch.rested_s >= self._watch.rest_blocks - 0.5:
                self._position = step.start_position
        if self._position in {0, step.start_position}:
            return ""
        where = f"position {self._position}" if self._position > 0 else "no position, 90 deg off the marks"
        return f"the cube stands in {where}; a {title(step)} begins in position {step.start_position}"

    def _follow(self, block: Block, look: Look) -> Stage:
        desk, watch = self._desk, self._watch
        watch.take(block, is_still=look.is_still)
        if watch.is_moving:
            desk.moved()
        if look.is_still and look.face != face_of(self._step.start_position):
            return self._again(desk, f"{title(self._step)}: the cube was tipped over; once more", must_move=False)
        if not watch.is_over:
            return self
        if abs(self._revolutions()) < TOUCHED_REVOLUTIONS:
            desk.story.say("still", "touched before the turn: keep your hands off")
            return self._again(desk, "", must_move=False)
        if why := watch.fault() or self._wrong_count():
            return self._again(desk, f"{title(self._step)}: {why}; once more", must_move=False)
        closing = in_words(came_back(desk, self._step, watch))
        desk.turns[self._step.name] = watch.counts_per_revolution
        desk.accept(self._step, merged(watch.step_blocks(), None), closing)
        desk.position = self._step.start_position
        return self._again(desk, "", must_move=True)


def _speed(turn: TurnView) -> str:
    if turn.speed_deg_s > turn.fast_deg_s:
        return "slower"
    return "faster" if 0 < turn.speed_deg_s < turn.slow_deg_s else ""
