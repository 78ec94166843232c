"""Locate a fusion folder by one of the sources."""

from station.fusion_folder import FusionLog
from station.locate.inertial import by_imu
from station.locate.recorded import by_odometry
from station.locate.result import Located
from station.locate.vision import by_vision

SOURCES = {"inertial": by_imu, "odometry": by_odometry, "vision": by_vision}


def locate(log: FusionLog, source: str, layers: int = 2) -> Located:
    """Locate a folder by one of `SOURCES`.

    Raises
    ------
    DataRefused
        If the folder does not hold what the source needs.
    ExtraMissing
        If the source needs a library that is not installed.
    """
    return SOURCES[source](log, layers)


def default_source(log: FusionLog) -> str:
    """Return the source that is taken where none is asked for."""
    return "inertial" if log.imu is not None else "odometry"
