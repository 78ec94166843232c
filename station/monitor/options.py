"""How a monitor is to run."""

from collections.abc import Callable
from dataclasses import dataclass

from drivers.camera import CameraImage
from procedures.arrays import FloatArray
from procedures.units import STANDARD_GRAVITY
from station.locate.monitor_interface import Locator
from station.monitor.alarms import Alarm
from station.stream.beside import Companion


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
    camera: Companion[CameraImage] | None = None  # of which ``locating`` is told


DEFAULT_OPTIONS = MonitorOptions()
