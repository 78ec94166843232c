"""A calibration/1 as a flight stack meets it: SI readings at a nominal scale factor, to be corrected.

A driver turns counts into SI by one nominal scale factor ``k0`` for all axes of a triad, so that it reads
``raw = k / k0 (E u + D)``. Inverted without the off-diagonal of E: ``u = (raw - offset) * scale`` with
``offset = k D / k0`` and ``scale = k0 / (k E_qq)``. What that leaves is said, not hidden.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.units import RAD_S_PER_DEG_H, STANDARD_GRAVITY
from station.errors import DataRefused
from station.files.toml_reading import read_text_file

FORMAT = "calibration/1"
NOMINAL_DIGITS = 3  # of a nominal scale factor nobody gave


@dataclass(frozen=True, slots=True)
class NominalScale:
    """A nominal scale factor, in the unit of the calibration's own, and whether it was given or taken from it."""

    value: float
    unit: str
    is_given: bool

    def __str__(self) -> str:
        origin = "as given" if self.is_given else f"the mean of the axes' own to {NOMINAL_DIGITS} digits"
        return f"{self.value:.10g} {self.unit}, {origin}"


@dataclass(frozen=True, slots=True, eq=False)
class TriadCorrection:
    """A triad at its nominal scale factor: ``raw = gain (E u + D)``; D (3,) in SI, ``gain`` (3,) = k / k0."""

    nominal: NominalScale
    gain: FloatArray
    E: FloatArray
    D: FloatArray

    @property
    def matrix(self) -> FloatArray:
        """``raw = matrix u + offset`` (3, 3), rows sensors, columns body axes."""
        matrix: FloatArray = self.gain[:, None] * self.E
        return matrix

    @property
    def offset(self) -> FloatArray:
        """What the raw reading shows at zero input (3,), SI."""
        offset: FloatArray = self.gain * self.D
        return offset

    @property
    def scale(self) -> FloatArray:
        """By what the raw reading less its offset is multiplied (3,)."""
        scale: FloatArray = 1 / np.diagonal(self.matrix)
        return scale

    @property
    def misalignment(self) -> float:
        """How far the worst sensor axis points away from its body axis [rad]."""
        across = self.E - np.diag(np.diagonal(self.E))
        return float(np.linalg.norm(across, axis=1).max())


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """A calibration for a flight stack; a triad that was not calibrated is None. ``remarks`` tell its origin."""

    accelerometer: TriadCorrection | None
    gyroscope: TriadCorrection | None
    remarks: tuple[str, ...]


def read_correction(path: Path, accel: float | None = None, gyro: float | None = None) -> Correction:
    """Read a calibration/1; ``accel`` and ``gyro`` are nominal scale factors in its units, else of its own mean.

    Raises
    ------
    DataRefused
        If the file is no calibration/1.
    """
    document = _document(path)
    try:
        correction = Correction(
            _triad(document.get("accelerometer"), accel, STANDARD_GRAVITY),
            _triad(document.get("gyroscope"), gyro, RAD_S_PER_DEG_H),
            _remarks(document),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise DataRefused(path, None, f"a {FORMAT} without {error}", "k, E and D of its triads") from error
    if correction.accelerometer is None and correction.gyroscope is None:
        raise DataRefused(path, None, "no triad", "an accelerometer or a gyroscope")
    return correction


def _document(path: Path) -> dict[str, Any]:
    content = read_text_file(path)
    try:
        document = json.loads(content)
    except ValueError as error:
        raise DataRefused(path, None, f"no JSON ({error})", f"a {FORMAT}") from None
    found = document.get("format") if isinstance(document, dict) else None
    if not isinstance(document, dict) or found != FORMAT:
        remedy = "store the solution first: `station calibrate` offers it" if found == "solution/1" else "name one"
        raise DataRefused(path, None, f"format {found!r}", repr(FORMAT), remedy)
    return document


def _triad(part: Mapping[str, Any] | None, nominal: float | None, si: float) -> TriadCorrection | None:
    if part is None:
        return None
    k = np.array(part["scale_factor"]["value"], dtype=float).reshape(3)
    E = np.array(part["misalignment"]["value"], dtype=float).reshape(3, 3)
    D = np.array(part["bias"]["value"], dtype=float).reshape(3)
    k0 = float(f"{k.mean():.{NOMINAL_DIGITS}g}") if nominal is None else nominal
    return TriadCorrection(NominalScale(k0, part["scale_factor"]["unit"], nominal is not None), k / k0, E, D * si)


def _remarks(document: Mapping[str, Any]) -> tuple[str, ...]:
    remarks = [
        f"{document['model']} {document['serial']}, accepted {document['accepted_utc']}, {document['status']}",
        f"made by {document['software']}; previous calibration {document['previous']}",
    ]
    if effects := [str(effect["name"]) for effect in document["effects"]]:
        remarks.append(f"NOT CARRIED: effects {', '.join(effects)}")
    if "temperature_range_c" in document:
        low, high = document["temperature_range_c"]
        remarks.append(f"measured at {low:.1f} to {high:.1f} degC; temperature dependence is not carried")
    remarks.append("NOT CARRIED: the sigmas; they stand in the calibration")
    return tuple(remarks)
