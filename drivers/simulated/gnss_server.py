"""Serves a simulated autopilot on a real transport: UDP, TCP or pty, beside a simulated IMU or alone."""

import time
from collections.abc import Iterable
from pathlib import Path
from threading import Event, Thread
from types import TracebackType
from typing import Self

from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.gnss_faults import GnssFault
from drivers.simulated.pace import TrueTime
from drivers.simulated.talk import talk_on
from drivers.simulated.timed_faults import active
from drivers.simulated.track import Track
from drivers.simulated.truth import Truth

POLL_S = 0.002


class SimulatedGnss:
    """An autopilot on a real transport while the ``with`` block lasts.

    Parameters
    ----------
    truth, autopilot, faults, track, seed
        What is simulated, see `Autopilot`.
    beside
        The device whose time it shares; without it, the host's, ``speed`` times as fast.
    transport, link, port, to
        ``udp`` (it listens on ``port``, or sends to ``to``), ``tcp`` on ``port``, or ``pty``; port 0: any.
    """

    def __init__(
        self,
        truth: Truth,
        autopilot: AutopilotTruth | None = None,
        faults: Iterable[GnssFault] = (),
        track: Track | None = None,
        seed: int | None = 1,
        *,
        beside: TrueTime | None = None,
        speed: float = 1.0,
        transport: str = "udp",
        link: Path | None = None,
        port: int = 0,
        to: tuple[str, int] | None = None,
    ) -> None:
        self._faults = tuple(faults)
        self.autopilot = Autopilot(truth, autopilot, self._faults, track, seed)
        self._beside, self._speed = beside, speed
        self._line = talk_on(transport, link, port, to)
        self._stop = Event()
        self._thread = Thread(target=self._run, name="simulated autopilot", daemon=True)
        self._began = 0.0
        self.failure: Exception | None = None

    @property
    def url(self) -> str:
        """The URL by which a station opens it."""
        return f"mavlink:{self._line.address}"

    @property
    def now(self) -> float:
        """True time [s]."""
        return self._beside.true_time if self._beside else (time.monotonic() - self._began) * self._speed

    def plant(self, kind: str, seconds: float, size: float = 0.0) -> None:
        """Have a fault act from now on, see `drivers.simulated.gnss_faults.KINDS`."""
        self._faults = (*self._faults, GnssFault(kind, self.now, seconds, size))
        self.autopilot.faults = self._faults

    def __enter__(self) -> Self:
        self._line.plug()
        self._began = time.monotonic()
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()
        self._line.unplug()

    def _run(self) -> None:
        try:
            is_plugged = True
            answer = b""
            while not self._stop.is_set():
                now = self.now
                wanted = not active(self._faults, now, "unplug")
                if wanted != is_plugged:
                    (self._line.plug if wanted else self._line.unplug)()
                    is_plugged = wanted
                out = answer + self.autopilot.due(now)
                if is_plugged:
                    heard = self._line.exchange(out, POLL_S)
                    answer = self.autopilot.hear(heard, now) if heard else b""
                else:
                    self._stop.wait(POLL_S)
        except Exception as error:  # the edge of a thread: kept for whoever asks, and the line goes silent
            self.failure = error
