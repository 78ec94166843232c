"""Locating beside the monitor: on a thread of its own when it is live, so that nothing waits for the estimator."""

import threading
from contextlib import ExitStack
from dataclasses import replace
from queue import SimpleQueue
from typing import Protocol

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.records import ImuSeries
from station.guide.view import Sound
from station.live.live_feed import LiveFeed
from station.locate.imu_noise import NoiseOf
from station.locate.live import LiveLocator, Taken
from station.monitor.calibration import Applied
from station.monitor.sensors import Sensors, Tick
from station.monitor.view import Location

LEAVE_S = 2.0


class Locating(Protocol):
    """What a monitor tells of each tick, and asks where the unit is."""

    @property
    def location(self) -> Location:
        """What is known now."""
        ...

    def take(self, taken: Taken) -> None:
        """Go on by a tick."""
        ...

    def begin_anew(self) -> None:
        """Begin again: the unit's time has no relation to what came before."""
        ...


class LocatorThread:
    """A locator that works through what it is given as fast as it can; both calls return at once."""

    def __init__(self, locator: LiveLocator) -> None:
        self._locator = locator
        self.location = locator.location
        self._given: SimpleQueue[Taken | None] = SimpleQueue()  # None: begin anew
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="locator", daemon=True)
        self._thread.start()

    def take(self, taken: Taken) -> None:
        """Go on by a tick, soon."""
        self._given.put(taken)

    def begin_anew(self) -> None:
        """Begin again, soon."""
        self._given.put(None)

    def close(self) -> None:
        """Let go of what is still to be done."""
        self._stop.set()
        self._given.put(None)
        self._thread.join(LEAVE_S)

    def _run(self) -> None:
        try:
            while True:
                given = self._given.get()
                if self._stop.is_set():
                    return
                if given is None:
                    self._locator.begin_anew()
                else:
                    self._locator.take(given)
                self.location = self._locator.location
        except Exception as error:  # the edge of a thread: the monitor goes on without a location and says why
            why = f"locating has stopped: {type(error).__name__}: {error}"
            self.location = replace(self.location, is_located=False, why=why)


def in_imu_axes(tick: Tick, C: FloatArray, period: float) -> ImuSeries:
    """Return a tick's samples in the middle of their intervals; ``C`` (3, 3) takes IMU axes to the body's."""
    return ImuSeries(tick.t - period / 2, tick.calibrated.rate @ C, tick.calibrated.force @ C)


def news_of(before: Location | None, found: Location) -> tuple[Sound, str] | None:
    """Return what is to be said of a location, and how it sounds."""
    was = before is not None and before.is_located
    if found.is_located and not was:
        return "accepted", "position and heading are known"
    if was and not found.is_located:
        return "rejected", f"position and heading are no longer known: {found.why}"
    return None


def locating(
    feed: LiveFeed, applied: Applied, C: FloatArray, lever_arm: tuple[float, ...], stack: ExitStack, *, live: bool
) -> Locating:
    """Return what locates the unit of a feed; ``C`` (3, 3) takes IMU axes to forward-right-down."""
    counts = feed.wire.output == "increments"
    sensors = Sensors(applied.document, applied.nominal, np.eye(3), feed.period, counts=counts)
    noise_of = NoiseOf(feed.period, applied.document, sensors.quanta() if counts else (0.0, 0.0))
    locator = LiveLocator(noise_of, C[0], np.array(lever_arm) if lever_arm else None)
    if not live:
        return locator
    thread = LocatorThread(locator)
    stack.callback(thread.close)
    return thread
