"""A `calibration/1` as it is exported: its triads, and what its file says of itself."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from station.calibrated.calibration_applied import CalibrationModel
from station.calibrated.surroundings import Triad
from station.files.calibration_document import MAX_BYTES, parsed_calibration
from station.files.toml_reading import read_text_file


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
        known = self.document.get("temperature_range_c")
        return None if known is None else (float(known[0]), float(known[1]))

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
    """Read a calibration/1 to be exported; raises `DataRefused` as `checked_calibration`."""
    content = read_text_file(path, MAX_BYTES)
    checked = parsed_calibration(content, str(path))
    return StoredCalibration(
        path, checked, hashlib.sha256(content).hexdigest(), CalibrationModel.of(checked).triads
    )
