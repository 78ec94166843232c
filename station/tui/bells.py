"""What the terminal bell says: four patterns that cannot be mistaken for one another."""

from collections import deque
from collections.abc import Callable

from station.stream.stream_events import Sound

# When each stroke follows the one before [s]. Terminals merge strokes closer than about 0.1 s.
BELL_PATTERNS: dict[Sound, tuple[float, ...]] = {
    "": (),
    "start": (0.0,),
    "still": (0.0, 0.5),
    "accepted": (0.0, 0.18, 0.18),
    "rejected": (0.0, 0.8, 0.8, 0.8),
}
PATTERN_GAP_S = 0.7  # between two patterns
MAX_STROKES = 12  # strokes: what has become older than that is not news


class Bells:
    """Rings patterns one after the other: ``stroke`` the bell once, ``later`` calls after so many seconds."""

    def __init__(self, stroke: Callable[[], None], later: Callable[[float, Callable[[], None]], object]) -> None:
        self._stroke, self._later = stroke, later
        self._waits: deque[float] = deque()
        self._is_ringing = False

    def ring(self, sound: Sound) -> None:
        """Ring a pattern, after those that ring already."""
        waits = BELL_PATTERNS[sound]
        if len(self._waits) + len(waits) > MAX_STROKES or not waits:
            return
        self._waits += (waits[0] + PATTERN_GAP_S, *waits[1:]) if self._is_ringing else waits
        if not self._is_ringing:
            self._next()

    def _next(self) -> None:
        self._is_ringing = bool(self._waits)
        if not self._is_ringing:
            return
        if wait := self._waits.popleft():
            self._later(wait, self._strike)
        else:  # at once: a timer of no time never fires
            self._strike()

    def _strike(self) -> None:
        self._stroke()
        self._next()
