"""Locating for the monitor: on its own thread when the source is live, so that nothing waits for the estimator."""

import threading
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from queue import SimpleQueue

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.vision.camera_time import CameraTimeOffset
from station.calibrated.calibration_choice import AppliedCalibration
from station.calibrated.rates_and_forces import Sensors
from station.files.fusion_folder.fusion_tables import camera_of, lens_of
from station.locate.imu_source import noise_once_known
from station.locate.live_camera import LiveCamera
from station.locate.live_fixes import LiveWheel
from station.locate.live_locator import LiveLocator
from station.locate.monitor_interface import LocatorTick
from station.stream.camera import CameraDescription, ImageFeatureFollower
from station.stream.live.live_feed import LiveFeed

LEAVE_S = 2.0
FAR_BEHIND = 20  # ticks: two seconds


class LocatorThread:
    """A locator that works through what it is given as fast as it can; both calls return at once."""

    def __init__(self, locator: LiveLocator) -> None:
        self._locator = locator
        self.location = locator.location
        self._given: SimpleQueue[LocatorTick | None] = SimpleQueue()  # None: restart
        self._stop, self._is_blind = threading.Event(), False
        self._thread = threading.Thread(target=self._run, name="locator", daemon=True)
        self._thread.start()

    def take(self, taken: LocatorTick) -> None:
        """Advance by a tick, soon; without images from when it is far behind until it has caught up."""
        waiting = self._given.qsize()
        self._is_blind = waiting >= FAR_BEHIND or (self._is_blind and waiting > 0)
        if self._is_blind:
            taken = replace(taken, images=(), images_dropped=len(taken.images))
        self._given.put(taken)

    def reset(self) -> None:
        """Begin again, soon."""
        self._given.put(None)

    def close(self) -> None:
        """Cancel what is still to be done."""
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
                    self._locator.reset()
                else:
                    self._locator.take(given)
                self.location = self._locator.location
        except Exception as error:  # the edge of a thread: the monitor continues without a location and says why
            why = f"locating has stopped: {type(error).__name__}: {error}"
            self.location = replace(self.location, is_located=False, why=why)


def locating(
    feed: LiveFeed, applied: AppliedCalibration, C: FloatArray, lever_arm: tuple[float, ...], stack: ExitStack, *,
    live: bool, camera: LiveCamera | None = None, wheel: LiveWheel | None = None,
) -> LiveLocator | LocatorThread:  # fmt: skip
    """Return what locates the unit of a feed; ``C`` (3, 3) takes IMU axes to forward-right-down."""
    counts = feed.wire.output == "increments"
    sensors = Sensors(applied.document, applied.nominal, np.eye(3), feed.period, counts=counts)
    quantum = sensors.quanta() if counts else (0.0, 0.0)
    noise_of = partial(noise_once_known, period=feed.period, calibration=applied.document, quantum=quantum)
    locator = LiveLocator(noise_of, C[0], np.array(lever_arm) if lever_arm else None, camera, wheel)
    if not live:
        return locator
    thread = LocatorThread(locator)
    stack.callback(thread.close)
    return thread


def live_camera(described: CameraDescription) -> LiveCamera:
    """Return what follows features through a camera's images; raise `ExtraMissing` without OpenCV."""
    table = described.table
    about, std = table.time_offset_s, table.time_offset_std_s
    known = None if about is None and std is None else CameraTimeOffset(about or 0.0, std or 0.0)
    return LiveCamera(camera_of(table), ImageFeatureFollower(lens_of(table)), known)
