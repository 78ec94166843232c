"""What happened, to be heard and read once each."""

from station.stream.events import Event, Sound

EVENTS_KEPT = 8


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
