"""A `calibration/1` as it is exported: its triads, and what its file says of itself."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from procedures.frames import TRIADS
from station.calibrated.calibration_applied import CalibrationModel
from station.calibrated.surroundings import Triad
from station.errors import DataRefused
from station.files.calibration_document import FORMAT, checked_calibration
from station.files.toml_reading import read_text_file

MAX_BYTES = 1 << 24
LARGEST = 1e30  # of a number: float holds some 1e8 times more


@dataclass(frozen=True, slots=True, eq=False)
class StoredCalibration:
    """A calibration/1, its triads by name, and the SHA-256 of its file."""

    path: Path
    document: Mapping[str, Any]
    sha256: str
    triads: Mapping[str, Triad]

    @property
    def unit(self) -> str:
        """Model and serial."""
        return f"{self.document['model']} {self.document['serial']}"

    @property
    def effects(self) -> tuple[Mapping[str, Any], ...]:
        """The entries of its effects."""
        return tuple(self.document["effects"])

    @property
    def temperature_range_c(self) -> tuple[float, float] | None:
        """The least and the greatest temperature [degC] at which it was measured, None where nobody knows."""
        if "temperature_range_c" not in self.document:
            return None
        low, high = self.document["temperature_range_c"]
        return float(low), float(high)

    @property
    def origin(self) -> tuple[str, ...]:
        """Whose it is, its hash, when it was accepted and how long it holds: one line each."""
        document, lines = self.document, [f"Calibration of {self.unit}"]
        lines.append(f"SHA-256 of {self.path.name}: {self.sha256}")
        lines.append(
            f"status {document.get('status', 'unknown')}, accepted {document.get('accepted_utc', 'unknown')}"
        )
        until = document.get("valid_until", "not stated")
        lines.append(f"valid from {document.get('valid_from', 'not stated')}, until {until}")
        lines.append(f"made by {document.get('software', 'unknown')}")
        if (known := self.temperature_range_c) is not None:
            lines.append(f"measured at {known[0]:.1f} to {known[1]:.1f} degC")
        return tuple(lines)


def read_stored(path: Path) -> StoredCalibration:
    """Read a calibration/1 to be exported.

    Raises
    ------
    DataRefused
        If the file is none, or a number in it is none.
    """
    content = read_text_file(path, MAX_BYTES)
    try:
        document = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise DataRefused(path, None, f"no JSON ({error})", f"a {FORMAT}") from None
    if isinstance(document, dict):
        document = {key: value for key, value in document.items() if value is not None}
    checked = checked_calibration(document, str(path))
    for place, value in _numbers(checked, path):
        if not isinstance(value, int | float) or not abs(value) < LARGEST:
            raise DataRefused(path, None, f"{place} = {value!r}"[:80], f"a finite number, below {LARGEST:g}")
    return StoredCalibration(
        path, checked, hashlib.sha256(content).hexdigest(), CalibrationModel.of(checked).triads
    )


def _numbers(document: Mapping[str, Any], path: Path) -> Iterator[tuple[str, Any]]:
    for triad in (name for name in TRIADS if name in document):
        for part in ("scale_factor", "misalignment", "bias"):
            yield from ((f"{triad}.{part}", one) for one in np.ravel(document[triad][part]["value"]).tolist())
        yield from ((f"1 / {triad}.scale_factor", 1 / one) for one in document[triad]["scale_factor"]["value"])
    for entry in document["effects"]:
        for key, one in entry["coefficients"].items():
            yield f"{entry['name']} {key}", one["value"]
    known = document.get("temperature_range_c", (0.0, 0.0))
    if not isinstance(known, list | tuple) or len(known) != 2:
        raise DataRefused(path, None, f"temperature_range_c = {known!r}", "the least and the greatest [degC]")
    yield from (("temperature_range_c", value) for value in known)
