"""What the bell says, on a clock of its own."""

from collections.abc import Callable
from typing import get_args

import pytest

from station.stream.stream_events import Event, Sound
from station.tui.app import BELL_PATTERNS, MAX_STROKES, Bells
from tests.station.tui.session import MemorySession, StationApp
from tests.station.tui.views import HOLDING


class Clock:
    """Does what is to be done later, at once, and notes when it would have been [s]."""

    def __init__(self) -> None:
        self.now = 0.0
        self.strokes: list[float] = []
        self._waiting: list[tuple[float, Callable[[], None]]] = []

    def later(self, delay: float, action: Callable[[], None]) -> None:
        assert delay > 0  # a timer of Textual's with no time to wait never fires
        self._waiting.append((self.now + delay, action))

    def stroke(self) -> None:
        self.strokes.append(self.now)

    def run(self) -> list[float]:
        while self._waiting:
            self._waiting.sort(key=lambda waiting: waiting[0])
            self.now, action = self._waiting.pop(0)
            action()
        return self.strokes


def rung(*sounds: Sound) -> list[float]:
    clock = Clock()
    bells = Bells(clock.stroke, clock.later)
    for sound in sounds:
        bells.ring(sound)
    return clock.run()


def test_each_sound_has_a_pattern_unlike_the_others() -> None:
    assert set(BELL_PATTERNS) == set(get_args(Sound))
    assert {sound: len(rung(sound)) for sound in BELL_PATTERNS} == {
        "": 0, "start": 1, "still": 2, "accepted": 3, "rejected": 4,
    }  # fmt: skip
    accepted, rejected = rung("accepted"), rung("rejected")
    assert accepted[-1] < 0.5 < rejected[1]


def test_a_flood_of_events_does_not_ring_for_minutes() -> None:
    assert len(rung(*["rejected"] * 50)) <= MAX_STROKES + 1


@pytest.mark.parametrize(("is_quiet", "expected"), [(False, 3), (True, 0)])
async def test_only_new_events_ring_and_none_when_quiet(is_quiet: bool, expected: int) -> None:
    session = MemorySession(HOLDING)
    app = StationApp(session, refresh_hz=0.001, is_quiet=is_quiet)
    clock = Clock()
    app.bells = Bells(clock.stroke, clock.later)
    async with app.run_test(size=(80, 24)):
        assert clock.run() == []  # what happened before these screens were opened
        new = Event(number=12, sound="accepted", text="position 3 accepted")
        session.view = HOLDING.model_copy(update={"events": (*HOLDING.events, new)})
        app.pull()
        app.pull()
        assert len(clock.run()) == expected
