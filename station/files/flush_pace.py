"""When what is written is brought to the disk: every so often, on a slow disk no more than half of the time."""

import time
from collections.abc import Iterator
from contextlib import contextmanager


class FlushPace:
    """Flushes every ``period_s``, or after as long as the last one took: else nothing else would be done."""

    def __init__(self, period_s: float) -> None:
        self._period_s = period_s
        self._due = time.monotonic() + period_s

    @property
    def is_due(self) -> bool:
        """Whether to flush now."""
        return time.monotonic() >= self._due

    @contextmanager
    def flushing(self) -> Iterator[None]:
        """Time a flush."""
        began = time.monotonic()
        yield
        now = time.monotonic()
        self._due = now + max(self._period_s, now - began)
