"""How well the IMU's stream is: rate, age, gaps, errors."""

import time
from collections import deque
from collections.abc import Callable

from station.stream.live.live_feed import LiveFeed
from station.stream.stream_events import StreamState

RATE_WINDOW_S = 5.0


class StreamHealth:
    """Looks at one feed; ``trouble`` is what it last refused, empty while it is well."""

    def __init__(self, feed: LiveFeed, clock: Callable[[], float] = time.monotonic) -> None:
        self._feed, self._clock = feed, clock
        self._seen: deque[tuple[float, int]] = deque([(clock(), 0)])
        self._came = clock()
        self.unhealthy = 0
        self.trouble = ""

    def look(self) -> StreamState:
        """Return the stream's health now."""
        now, counters = self._clock(), self._feed.stream.counters
        if counters.samples > self._seen[-1][1]:
            self._came = now
        self._seen.append((now, counters.samples))
        while now - self._seen[0][0] > RATE_WINDOW_S and len(self._seen) > 2:
            self._seen.popleft()
        seconds = now - self._seen[0][0]
        framing = self._feed.stream.decoder.counters
        return StreamState(
            name=f"IMU {self._feed.wire.name}",
            rate_hz=(counters.samples - self._seen[0][1]) / seconds if seconds > 0 else 0.0,
            age_s=now - self._came, samples=counters.samples, gaps=counters.breaks + counters.restarts,
            lost=counters.lost, bad=framing.bad_crc + framing.bad_length, unhealthy=self.unhealthy,
            trouble=self.trouble,
        )  # fmt: skip
