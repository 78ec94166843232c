"""The monitor's engine on its own thread, so that a slow terminal delays nothing but itself."""

import contextlib
import threading
from dataclasses import replace
from queue import Empty, SimpleQueue
from typing import Self

from drivers.errors import ReplayEnded
from station.attitude.live_filters import compile_filters
from station.monitor.monitor import Monitor
from station.monitor.view import MonitorVerb

PREPARING = "preparing: the filter is compiled once on this computer (up to one minute)"


class MonitorThread:
    """A `station.monitor.view.MonitorSession`; the engine runs while the ``with`` block lasts.

    ``failure`` is what ended it, None if it was asked to or the replay is over; ``stays`` keeps the last view of a
    replay on the screen until somebody leaves. ``seconds`` [s of the device] ends it.
    """

    def __init__(self, monitor: Monitor, *, stays: bool = False, seconds: float = float("inf")) -> None:
        self._monitor, self._stays, self._seconds = monitor, stays, seconds
        self._verbs: SimpleQueue[MonitorVerb] = SimpleQueue()
        self._stop, self.changed = threading.Event(), threading.Event()
        self.view = monitor.view  # the newest
        self._from: float | None = None  # device time of the first reading [s]
        self.failure: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="monitor", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *raised: object) -> None:
        self._stop.set()
        self._thread.join()

    def send(self, verb: MonitorVerb) -> None:
        """Ask something of the engine."""
        if verb == "leave":
            self._stop.set()
        self._verbs.put(verb)

    def _run(self) -> None:
        try:
            self._publish(PREPARING)
            compile_filters()
            while not self._stop.is_set() and not self._is_long_enough():
                self._execute()
                self._monitor.round()
                self._publish()
        except ReplayEnded:
            self._wait()
        except BaseException as error:  # the edge of a thread: raised where it is waited for
            self.failure = error
        try:
            self._monitor.close()
        except BaseException as error:
            self.failure = self.failure or error
        self._publish()

    def _execute(self) -> None:
        with contextlib.suppress(Empty):
            while True:
                self._monitor.execute(self._verbs.get_nowait())

    def _is_long_enough(self) -> bool:
        reading = self._monitor.view.reading
        if reading is None:
            return False
        self._from = reading.t if self._from is None else min(self._from, reading.t)
        return reading.t - self._from >= self._seconds

    def _wait(self) -> None:
        """Keep the end of a replay on the screen."""
        self._monitor.at_end()
        self._publish()
        while self._stays and not self._stop.wait(0.05):
            self._execute()
            self._publish()

    def _publish(self, line: str = "") -> None:
        self.view = replace(self._monitor.view, line=line) if line else self._monitor.view
        self.changed.set()
