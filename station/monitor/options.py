"""How a monitor is to run, and what it needs of what helps the IMU."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from drivers.camera import CameraImage
from procedures.arrays import FloatArray
from procedures.units import STANDARD_GRAVITY
from station.files.mcap_files.fix_reader import Record
from station.locate.monitor_interface import Locator
from station.monitor.alarms import Alarm
from station.stream.stream_events import StreamState


class CompanionSource(Protocol):
    """What is read beside the IMU."""

    def advance(self) -> None:
        """Take what has come."""
        ...

    @property
    def up_to_ns(self) -> int:
        """The moment [ns] up to which nothing more will come."""
        ...

    def stream(self) -> StreamState:
        """Return its health."""
        ...


class GnssAidSource(CompanionSource, Protocol):
    """What helps the IMU: a receiver."""

    def take(self, until_ns: int) -> Sequence[Record]:
        """Return what came since the last call and until a moment [ns], in order."""
        ...

    def utc(self, host_ns: int) -> float | None:
        """Return UTC [s] at a moment of the station's clock [ns]."""
        ...


class CameraSource(CompanionSource, Protocol):
    """What sees where the IMU goes: a camera."""

    def take(self, until_ns: int) -> Sequence[CameraImage]:
        """Return the images that came since the last call and until a moment [ns], in order."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class MonitorOptions:
    """How to monitor: ``aid`` by name, ``C`` (3, 3) IMU axes to forward-right-down; angles in rad, m/s2.

    ``speed`` [m/s] of the aid is shown; latitude and ``heading`` of forward are None where not known.
    """

    aid: str = "none"
    C: FloatArray | None = None
    latitude: float | None = None
    heading: float | None = None
    gravity: float = STANDARD_GRAVITY
    alarms: tuple[Alarm, ...] = ()
    restart_reader: Callable[[], None] | None = None  # has a reader that ended begin again
    locating: Locator | None = None
    camera: CameraSource | None = None  # of which ``locating`` is told


DEFAULT_OPTIONS = MonitorOptions()
