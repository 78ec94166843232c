"""What is asked for of calibrated samples: units, frame, the columns that follow, and the document beside them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.units import STANDARD_GRAVITY
from station.applying.checked_samples import Survey
from station.applying.source import Samples, Source
from station.calibrated.output_frame import Frame
from station.calibration import Calibrated, Calibration
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS
from station.results.solution_json import software_version

SUFFIX = {"m/s2": "m_s2", "rad/s": "rad_s", "deg/s": "deg_s", "deg/h": "deg_h", "cm/s2": "cm_s2",
          "mdeg/s": "mdeg_s", "mrad/s": "mrad_s"}  # fmt: skip
SI = ("m/s2", "rad/s")


@dataclass(frozen=True, slots=True)
class OutputRequest:
    """How samples are wanted: ``units`` of force and rate, ``frame``, ``axes`` (docs/how-to/applying.md).

    With ``force`` they are written even if they are physically impossible.
    """

    frame: Frame = "sensor"
    axes: str | None = None
    units: tuple[str, str] = SI
    force: bool = False


def axes_of(source: Source, asked: OutputRequest) -> str | None:
    """Return the axes that go with the frame: as asked, of a cube else as the source is mounted."""
    return asked.axes or (source.stated.mounting if asked.frame == "cube" else None)


def names_of(source: Source, asked: OutputRequest) -> tuple[str, ...]:
    """Return the names of the columns that are written."""
    force, rate = (SUFFIX.get(unit, unit) for unit in asked.units)
    names = ["t_s", *(f"f_{axis}_{force}" for axis in "xyz"), *(f"omega_{axis}_{rate}" for axis in "xyz")]
    return (*names, *(["temp_c"] if source.stated.temperature else []), *source.stated.auxiliary)


def columns_of(block: Samples, got: Calibrated, source: Source, asked: OutputRequest) -> list[FloatArray]:
    """Return a block's columns (n,), in the units of their names."""
    per_force = ACCEL_UNITS[asked.units[0]] / STANDARD_GRAVITY
    per_rate = GYRO_UNITS[asked.units[1]] / GYRO_UNITS["rad/s"]
    force = got.specific_force if asked.units[0] == SI[0] else got.specific_force * per_force
    rate = got.angular_rate if asked.units[1] == SI[1] else got.angular_rate * per_rate
    unknown = np.full(len(block.t), np.nan)
    columns = [block.t, *force.T, *rate.T]
    if source.stated.temperature:
        columns.append(unknown if block.temperature is None else block.temperature)
    return columns + [block.auxiliary.get(name, unknown) for name in source.stated.auxiliary]


def document_of(
    source: Source, calibration: Calibration, found: Survey, asked: OutputRequest, samples: int,
    spans: list[Calibrated], warnings: tuple[str, ...],
) -> dict[str, Any]:  # fmt: skip
    """Return applied/1: what is to know of the file beside it, ``spans`` one a block."""

    def of(name: str) -> list[Any]:
        values = np.concatenate([getattr(each, name) for each in spans])
        return [[None if np.isnan(v) else v for v in row] for row in values.tolist()]

    known = calibration.document
    about = {
        name: known[name] for name in ("model", "serial", "accepted_utc", "status", "valid_until") if name in known
    }
    return {
        "format": "applied/1", "input": source.stated.name, "samples": samples, "period_s": found.period,
        "frame": asked.frame, "axes": axes_of(source, asked), "mounting": source.stated.mounting,
        "units": list(asked.units), "software": software_version(),
        "calibration": {**about, "sha256": calibration.sha256}, "effects": list(calibration.effects),
        "warnings": list(warnings),
        "spans_s": of("spans"), "specific_force_std_m_s2": of("specific_force_std"),
        "angular_rate_std_rad_s": of("angular_rate_std"),
    }  # fmt: skip
