"""A second device with its own port, on the time of a simulated IMU or alone on the host's time."""

import time
from collections.abc import Callable, Iterable
from threading import Event, Thread
from typing import Self

from drivers.simulated.faults import TimedFault, active
from drivers.simulated.server import SimulatedDevice


class CompanionDevice:
    """Served by a thread while the ``with`` block lasts; what is sent is a subclass's.

    ``imu`` is the device whose time it shares; without one time is the host's, ``speed`` times as fast. Of its
    ``faults``, which a subclass reads, ``unplug`` is acted on here. ``plug`` makes the port be there; ``unplug``,
    which may be called twice, gone.
    """

    def __init__(
        self, name: str, faults: Iterable[TimedFault], imu: SimulatedDevice | None, speed: float,
        plug: Callable[[], None], unplug: Callable[[], None],
    ) -> None:  # fmt: skip
        self.faults = list(faults)
        self._plug, self._unplug = plug, unplug
        self._imu, self._speed = imu, speed
        self._stop = Event()
        self._thread = Thread(target=self._run, name=name, daemon=True)
        self._began = 0.0
        self.failure: Exception | None = None

    @property
    def now(self) -> float:
        """True time [s]."""
        return self._imu.true_time if self._imu else (time.monotonic() - self._began) * self._speed

    def plant(self, kind: str, seconds: float, size: float = 0.0) -> None:
        """Have a fault act from now on, see the kinds in `drivers.simulated.faults`."""
        self.faults.append(TimedFault(kind, self.now, seconds, size))

    def __enter__(self) -> Self:
        self._plug()
        self._began = time.monotonic()
        self._thread.start()
        return self

    def __exit__(self, *raised: object) -> None:
        self._stop.set()
        self._thread.join()
        self._unplug()

    def _run(self) -> None:
        try:
            is_plugged = True
            while not self._stop.is_set():
                now = self.now
                wanted = not active(self.faults, now, "unplug")
                if wanted != is_plugged:
                    (self._plug if wanted else self._unplug)()
                    is_plugged = wanted
                self._step(now, is_plugged=is_plugged)
        except Exception as error:  # the edge of a thread: kept for whoever asks, and the line goes silent
            self.failure = error

    def _step(self, now: float, *, is_plugged: bool) -> None:
        """Say what is due at true time ``now`` [s]; wait a little where nothing is."""
        raise NotImplementedError
