"""How fast a simulated device runs: absolute deadlines, so that a late wake-up is not added to the next."""

import time
from collections.abc import Callable

MAX_CHUNK_SAMPLES = 50  # of a chunk: bounds how late a command acts
CHUNK_S = 0.01  # wall time a paced chunk aims at
MAX_BEHIND_S = 0.25  # a device later than this starts its pace anew instead of hurrying after it


class Pace:
    """Deadlines of samples ``period`` [s] apart at ``speed`` device seconds per second; 0: no deadlines."""

    def __init__(self, speed: float, period: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._per_sample = period / speed if speed else 0.0
        self._clock = clock
        self._anchor, self._anchored = clock(), 0
        self._allowed = MAX_BEHIND_S

    def excuse(self, seconds: float) -> None:
        """Take it that the device was held up on purpose: what became due meanwhile is not waited for again."""
        self._allowed = MAX_BEHIND_S + seconds

    @property
    def samples(self) -> int:
        """Samples to take at a time."""
        return (
            min(MAX_CHUNK_SAMPLES, max(1, round(CHUNK_S / self._per_sample)))
            if self._per_sample
            else MAX_CHUNK_SAMPLES
        )

    def delay(self, sample: int) -> float:
        """Return how long [s] to wait until ``sample`` is due."""
        if not self._per_sample:
            return 0.0
        now = self._clock()
        early = self._anchor + (sample - self._anchored) * self._per_sample - now
        if early > -MAX_BEHIND_S:
            self._allowed = MAX_BEHIND_S
        elif early < -self._allowed:
            self._anchor, self._anchored = now, sample
        return max(0.0, early)
