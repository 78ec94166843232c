"""How often each message comes, and whether it comes much more rarely than it was asked for.

An autopilot may refuse an interval, accept it and do nothing, or have no newer fix to send; whichever it is, the
measured rate tells.
"""

import time
from collections import Counter, deque
from collections.abc import Callable

MAX_MESSAGES = 6000  # messages
RATE_S = 5.0
MIN_EXPECTED_MESSAGES = 5  # messages expected of a rate that is judged
SETTLING_S = 8.0  # until all was asked for, three times and the old way
SLOW_SHARE, WELL_SHARE = 0.6, 0.7  # of the rate asked for: below and above
WATCHED = ("GPS_RAW_INT", "SYSTEM_TIME")  # position and time; a sender may have no more than these


class MessageRates:
    """Watches one system's messages; times are of the station's monotonic clock [s]."""

    def __init__(self, name: str, asked_hz: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._name, self._asked_hz, self._clock = name, asked_hz, clock
        self._seen: deque[tuple[float, str]] = deque(maxlen=MAX_MESSAGES)
        self._names: set[str] = set()
        self._well_since = clock()
        self._slow: dict[str, str] = {}
        self._window_s = max(RATE_S, MIN_EXPECTED_MESSAGES / asked_hz)

    @property
    def trouble(self) -> str:
        """Which message is slow, and what to do; empty where none is."""
        return next(iter(self._slow.values()), "")

    def came(self, name: str) -> None:
        """Take note of a message."""
        self._seen.append((self._clock(), name))
        self._names.add(name)

    def hz(self, window_s: float = RATE_S) -> dict[str, float]:
        """Return how often each message came over the last seconds."""
        since = self._clock() - window_s
        counts = Counter(name for at, name in self._seen if at >= since)
        return {name: count / window_s for name, count in counts.items()}

    def look(self, *, is_well: bool) -> None:
        """Say what is slow now; where something else is wrong, or was until lately, nothing is."""
        now = self._clock()
        if not is_well:
            self._well_since = now
        if now - self._well_since < SETTLING_S + self._window_s:
            self._slow.clear()
            return
        rates = self.hz(self._window_s)
        for name in WATCHED:
            rate = rates.get(name, 0.0)
            if rate > WELL_SHARE * self._asked_hz:
                self._slow.pop(name, None)
            elif rate < SLOW_SHARE * self._asked_hz and name in self._names:
                self._take(name, rate)

    def _take(self, name: str, rate: float) -> None:
        """Note a slow message; its rate as it was found, so that the words do not change all the time."""
        asked = f"{self._asked_hz:g} Hz was asked for"
        if not rate:
            self._slow[name] = f"{self._name}: {name} no longer comes, {asked}; check receiver and autopilot"
        elif name not in self._slow:
            self._slow[name] = (
                f"{self._name}: {name} comes at {rate:.2g} Hz, {asked}; let autopilot and receiver send it as "
                f"often, or ask for less: rate={max(rate, 0.1):.1g} in the address"
            )
