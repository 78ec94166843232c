"""Locate a fusion folder by one of the sources."""

from dataclasses import replace

from station.files.fusion_folder import FusionLog
from station.locate.camera_source import by_vision
from station.locate.imu_source import by_imu
from station.locate.odometry_source import by_odometry
from station.locate.result import Located

MAX_OUTLIER_SHARE = 0.3  # of the fixes: more than any receiver's outliers
DOUBT = "{} of {} fixes are outliers of more than 5 sigma: check their uncertainties, units, clock and lever arm"
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
    located = SOURCES[source](log, layers)
    total = len(log.fixes.t)
    doubts = (DOUBT.format(located.rejected, total),) if located.rejected > MAX_OUTLIER_SHARE * total else ()
    return replace(located, fixes=total, warnings=(*located.warnings, *doubts))


def default_source(log: FusionLog) -> str:
    """Return the source that is taken where none is asked for."""
    return "inertial" if log.imu is not None else "odometry"
