"""The wheel of a live run: its speeds on the IMU's clock, and what the window finds of them, in words."""

from collections.abc import Iterable, Sequence

import numpy as np

from drivers.can.wheel_reading import WheelReading
from procedures.fusion.fusion_records import ImuNoise
from procedures.fusion.inner.inner_window import InnerWindow
from procedures.fusion.inner.wheel_aid import WheelAid
from procedures.fusion.wheel_speeds import WheelMount, WheelSpeeds, no_speeds
from station.stream.gnss.fix_times import FixTimes

MARKS_NS = 60 * 10**9  # of the line between the clocks
STRANGE_S = 5.0  # from the newest sample, beyond which a frame's time is none
SILENT_S = 2.0
KEPT_S = 300.0  # of speeds, until a window has them


class LiveWheel:
    """``late`` [s] is what frames are late by when they are read."""

    def __init__(self, mount: WheelMount, late: float = 0.0) -> None:
        self._mount, self._late = mount, late
        self.begin_anew()

    def begin_anew(self) -> None:
        """Let all go that hangs on the unit's time."""
        self._times = FixTimes(MARKS_NS)
        self._speeds, self._aid = no_speeds(), None
        self._newest = self._now = -np.inf
        self._age = 0.0  # s, of the newest speed when it came

    _aid: WheelAid | None

    def mark(self, marks: Iterable[tuple[int, float]]) -> None:
        """Take moments of reading [ns] and the device times [s] of the samples that came then."""
        for host_ns, device_s in marks:
            self._times.mark_imu(host_ns, device_s)

    def take(self, readings: Sequence[WheelReading], now: float) -> None:
        """Take what was told; ``now`` [s] is the newest sample's time."""
        self._now = now
        told = list[tuple[float, float]]()
        for reading in readings:
            t = self._times.of(reading)
            if t is not None and t - self._late > self._newest and abs(now - t) < STRANGE_S:
                self._newest = t - self._late
                told.append((self._newest, reading.speed))
        self._age = now - self._newest if told else self._age
        more = WheelSpeeds(*np.array(told).reshape(-1, 2).T)
        if self._aid is not None:
            self._aid.add(more)
        elif len(told):
            self._speeds = self._speeds.followed_by(more).since(now - KEPT_S)

    def aid(self, noise: ImuNoise) -> WheelAid:
        """Return what a window that begins now is to be given."""
        self._aid = WheelAid(self._mount, self._speeds, noise)
        return self._aid

    def said(self, window: InnerWindow | None) -> str:
        """How the wheel does, in words."""
        if self._newest == -np.inf:
            return "no speed yet"
        if (silent := self._now - self._newest) > SILENT_S:
            return f"no speed for {silent:.0f} s"
        if window is None or self._aid is None:
            return "it waits for position and heading"
        if self._aid.late:
            return f"its speeds arrive {self._age:.1f} s late: too late for use"
        if self._aid.slips_now:
            return "it slips"
        return f"scale {1 + window.state.wheel:.4f} +- {window.wheel_std:.4f}"
