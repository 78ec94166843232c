"""Events of a live stream, as they are spoken and shown, and the health of each stream."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from pydantic import BaseModel, ConfigDict

EVENTS_FILE = "events.csv"  # of a recorded run
EVENTS_KEPT = 8
Sound = Literal["", "start", "still", "accepted", "rejected"]


class Event(BaseModel):
    """Something to be heard and read once; ``number`` rises."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    number: int
    sound: Sound
    text: str


class EventLog:
    """Numbers events and keeps the last few."""

    def __init__(self) -> None:
        self.events: tuple[Event, ...] = ()
        self._number = 0

    def say(self, sound: Sound, text: str) -> None:
        """Add an event."""
        self._number += 1
        self.events = (*self.events, Event(number=self._number, sound=sound, text=text))[-EVENTS_KEPT:]

    def ended(self) -> None:
        """Take it that what was begun is over: that it began is no news any more."""
        self.events = tuple(event for event in self.events if event.sound != "start")


class NewEvents:
    """Tells which events were not seen before."""

    def __init__(self) -> None:
        self._newest = 0

    def of(self, events: Iterable[Event]) -> list[Event]:
        """Return those that are new."""
        new = [event for event in events if event.number > self._newest]
        self._newest = max([self._newest, *(event.number for event in new)])
        return new


@dataclass(frozen=True, slots=True)
class StreamState:
    """The health of one stream: ``age_s`` since the newest sample, ``trouble`` what is wrong, empty if nothing."""

    name: str
    rate_hz: float
    age_s: float
    samples: int
    gaps: int
    lost: int
    bad: int
    unhealthy: int = 0
    trouble: str = ""
