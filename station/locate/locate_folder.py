"""What ``station locate`` does with a fusion folder: choose a source, locate, write `location/1` and a summary.

Odometry of another program is a source too.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.errors import NotObservable
from procedures.fusion.fusion_records import Trajectory
from procedures.fusion.odometry import RecordedOdometry, without_restarts
from station.errors import DataRefused
from station.files.atomic_file import write_json
from station.files.fusion_folder import FusionLog, write_tum
from station.locate.camera_source import by_vision
from station.locate.imu_source import by_imu
from station.locate.outer_layer import Alignment, Located, WheelFound, through_graph
from station.text import plural

MAX_OUTLIER_SHARE = 0.3  # of the fixes: more than any receiver's outliers


FORMAT = "location/1"


def location_document(located: Located, source: str, truth: Trajectory | None) -> dict[str, Any]:
    """Return ``location/1``; ``error_m`` are over all poses from the moment of initialisation."""
    document = {
        "format": FORMAT,
        "source": source,
        "layers": located.layers,
        "initialised_at_s": located.begun_at,
        "why_not": located.why_not or None,
        "alignment": located.alignment and _alignment(located.alignment),
        "gyro_bias_rad_s": _list(located.gyro_bias),
        "accel_bias_m_s2": _list(located.accel_bias),
        "lever_arm_m": _list(located.lever_arm),
        "time_offset_s": located.time_offset,
        "camera_time_offset_s": located.camera_time_offset,
        "camera_time_offset_std_s": located.camera_time_offset_std,
        "wheel": located.wheel and _wheel(located.wheel),
        "rejected_fixes": located.rejected,
        "solve_ms": _times(located),
        "error_m": truth and _errors(located, truth),
        "warnings": list(located.warnings),
    }
    return {name: part for name, part in document.items() if part is not None and part != {}}


def _alignment(alignment: Alignment) -> dict[str, Any]:
    std = {"yaw_deg": alignment.yaw_std_deg, "tilt_deg": alignment.tilt_std_deg}
    value = {"yaw_deg": alignment.yaw_deg, "tilt_deg": alignment.tilt_deg}
    known = {name: part for name, part in value.items() if part is not None}
    return {**known, "std": {name: part for name, part in std.items() if part is not None}}


def _wheel(wheel: WheelFound) -> dict[str, Any]:
    slips = [[begin, end] for begin, end in wheel.slips]
    return {"scale": wheel.scale, "scale_std": wheel.scale_std, "slips_s": slips, "at_rest_s": wheel.rest_s}


def _list(vector: Any) -> list[float] | None:
    return None if vector is None else [float(part) for part in vector]


def _times(located: Located) -> dict[str, float]:
    if not len(located.seconds):
        return {}
    return {"mean": float(np.mean(located.seconds) * 1e3), "worst": float(np.max(located.seconds) * 1e3)}


def _errors(located: Located, truth: Trajectory) -> dict[str, Any]:
    parts = {"online": located.online, "batch": located.smoothed}
    errors = {name: position_errors(part, truth) for name, part in parts.items()}
    return {name: {"mean": off.mean, "max": off.worst} for name, off in errors.items() if off is not None}


@dataclass(frozen=True, slots=True)
class PositionErrors:
    """How far poses are from the truth [m], as they are, without any alignment; of those that it spans."""

    mean: float
    worst: float


def position_errors(trajectory: Trajectory, truth: Trajectory, after: float = -np.inf) -> PositionErrors | None:
    """Return the errors of the poses later than ``after`` [s]; None where the truth spans none."""
    distance = distances(trajectory, truth)[trajectory.t > after]
    distance = distance[np.isfinite(distance)]
    return PositionErrors(float(distance.mean()), float(distance.max())) if len(distance) else None


def distances(trajectory: Trajectory, truth: Trajectory) -> FloatArray:
    """Return the distance (n,) [m] of each pose from the truth, nan where that does not reach."""
    at = np.stack([np.interp(trajectory.t, truth.t, truth.p[:, i], np.nan, np.nan) for i in range(3)], axis=1)
    distance: FloatArray = np.linalg.norm(trajectory.p - at, axis=1)
    return distance


DOUBT = "{} of {} fixes are outliers of more than 5 sigma: check their uncertainties, units, clock and lever arm"


def by_odometry(log: FusionLog, _layers: int = 2) -> Located:
    """Locate by a recorded odometry."""
    if log.odometry is None or log.table.odometry is None:
        raise DataRefused(log.folder / "fusion.toml", None, "no [odometry]", "one, for this source", "add it")
    kept, dropped = without_restarts(log.odometry)
    if len(kept) < 2:
        file = log.folder / log.table.odometry.file
        raise DataRefused(file, None, "a restart at the end", "odometry data after it")
    text = f"{log.table.odometry.file}: {dropped} poses before an impossible step were discarded"
    return through_graph(log, RecordedOdometry(kept), (text,) if dropped else ())


SOURCES = {"inertial": by_imu, "odometry": by_odometry, "vision": by_vision}


def locate(log: FusionLog, source: str, layers: int = 2) -> Located:
    """Locate a folder by one of `SOURCES`.

    Raise `DataRefused` if the folder does not hold what the source needs, and `ExtraMissing` if the source needs
    a library that is not installed.
    """
    located = SOURCES[source](log, layers)
    total = len(log.fixes.t)
    doubts = (DOUBT.format(located.rejected, total),) if located.rejected > MAX_OUTLIER_SHARE * total else ()
    return replace(located, fixes=total, warnings=(*located.warnings, *doubts))


def default_source(log: FusionLog) -> str:
    """Return the source that is taken where none is asked for."""
    return "inertial" if log.imu is not None else "odometry"


def locate_folder(
    log: FusionLog, source: str | None, layers: int, out: Path | None, batch: Path | None, json: Path | None
) -> str:
    """Locate, write what was asked for, and return a summary, empty where a JSON was asked for.

    Raise `NotObservable` if it never could be initialised; the JSON is written and says why.
    """
    source = source or default_source(log)
    located = locate(log, source, layers)
    document = location_document(located, source, log.truth)
    if json is not None:
        write_json(json, document)
    if located.begun_at is None:
        raise NotObservable(f"{log.folder}: position and heading", (located.why_not,))
    if out is not None:
        write_tum(out, located.online)
    if batch is not None:
        write_tum(batch, located.smoothed)
    return "" if json is not None else location_text(document, located.fixes)


def location_text(document: dict[str, Any], fixes: int) -> str:
    """Return the lines of a readable summary; ``fixes`` is how many there were."""
    layers = "one layer" if document["layers"] == 1 else "two layers"
    lines = [f"source                {document['source']}, {layers}"]
    lines.append(f"initialised at        {document['initialised_at_s']:.2f} s")
    for name, unit in (("yaw", "deg"), ("tilt", "deg")):
        if f"{name}_deg" in document.get("alignment", {}):
            value, std = (part[f"{name}_deg"] for part in (document["alignment"], document["alignment"]["std"]))
            lines.append(f"{name + ' found then':<22}{value:.2f} +- {std:.2f} {unit}")
    for key, name, unit in (
        ("gyro_bias_rad_s", "gyro bias", "rad/s"),
        ("accel_bias_m_s2", "accelerometer bias", "m/s2"),
        ("lever_arm_m", "lever arm", "m"),
    ):
        if key in document:
            lines.append(f"{name:<22}{', '.join(f'{part:.4g}' for part in document[key])} {unit}")
    if "time_offset_s" in document:
        lines.append(f"GNSS time offset      {document['time_offset_s'] * 1e3:.1f} ms")
    if "camera_time_offset_s" in document:
        std = document.get("camera_time_offset_std_s")
        text = "" if std is None else f" +- {std * 1e3:.1f}"
        lines.append(f"camera time offset    {document['camera_time_offset_s'] * 1e3:.1f}{text} ms")
    if wheel := document.get("wheel"):
        slipped = f"slipped {plural(len(wheel['slips_s']), 'time')}, at rest for {wheel['at_rest_s']:.0f} s"
        lines.append(f"wheel scale factor    {wheel['scale']:.5f} +- {wheel['scale_std']:.5f}, {slipped}")
    lines.append(f"rejected fixes        {document['rejected_fixes']} of {fixes}")
    for name, text in (("online", "error, online"), ("batch", "error, smoothed")):
        if error := document.get("error_m", {}).get(name):
            lines.append(f"{text:<22}mean {error['mean']:.3f} m, largest {error['max']:.3f} m, without alignment")
    return "\n".join(lines + [f"warning: {warning}" for warning in document["warnings"]])
