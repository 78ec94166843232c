"""A calibration/1 as a flight stack meets it: SI readings at a nominal scale factor, to be corrected.

A driver turns counts into SI by one nominal scale factor ``k0`` for all axes of a triad, so that it reads
``raw = k / k0 (E u + D)``. Inverted without the off-diagonal of E: ``u = (raw - offset) * scale`` with
``offset = k D / k0`` and ``scale = k0 / (k E_qq)``. What that leaves is said, not hidden.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.units import RAD_PER_DEG, RAD_S_PER_DEG_H, STANDARD_GRAVITY
from station.calibrated.calibration_applied import CalibrationModel
from station.calibrated.rates_and_forces import NOMINAL_SCALE_DIGITS, mean_scale
from station.calibrated.unapplied_effect_size import size_of
from station.errors import DataRefused
from station.exports.carried_effects import carried_effects, said_size
from station.exports.stored_calibration import read_stored
from station.exports.thermal_offsets import ThermalOffset, is_thermal, thermal_offset
from station.files.calibration_document import FORMAT

SI = {"accelerometer": STANDARD_GRAVITY, "gyroscope": RAD_PER_DEG}  # of g, of deg/s


@dataclass(frozen=True, slots=True)
class NominalScale:
    """A nominal scale factor, in the unit of the calibration's own, and whether it was given or taken from it."""

    value: float
    unit: str
    is_given: bool

    def __str__(self) -> str:
        origin = "as given" if self.is_given else f"the mean of the axes' own to {NOMINAL_SCALE_DIGITS} digits"
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
    """A calibration for a flight stack; a triad that was not calibrated is None.

    ``remarks`` tell its origin; ``effects`` are its effects by name, with what each adds at most. ``thermal``
    holds offsets by temperature, by triad, which take the place of those effects that are ``in_thermal``.
    """

    accelerometer: TriadCorrection | None
    gyroscope: TriadCorrection | None
    remarks: tuple[str, ...]
    effects: Mapping[str, str] = field(default_factory=dict)
    thermal: Mapping[str, ThermalOffset] = field(default_factory=dict)
    in_thermal: frozenset[str] = frozenset()


def read_correction(path: Path, accel: float | None = None, gyro: float | None = None) -> Correction:
    """Read a calibration/1; ``accel`` and ``gyro`` are nominal scale factors in its units, else of its own mean.

    Raises
    ------
    DataRefused
        If the file is no calibration/1.
    """
    stored = read_stored(path)
    document, (carried, _) = stored.document, carried_effects(stored)
    try:
        triads = {
            "accelerometer": _triad(document.get("accelerometer"), accel, STANDARD_GRAVITY),
            "gyroscope": _triad(document.get("gyroscope"), gyro, RAD_S_PER_DEG_H),
        }
        remarks = _remarks(document)
    except KeyError as error:
        raise DataRefused(path, None, f"a {FORMAT} without {error}", "what one says of itself") from error
    thermal = {
        name: offset
        for name, triad in triads.items()
        if triad is not None and (limits := stored.temperature_range_c) is not None
        if (offset := thermal_offset(carried, name, triad.gain, SI[name], limits)) is not None
    }
    model = CalibrationModel.of(document)
    sizes = {
        str(one["name"]): size_of(model, document, str(one["name"])) or said_size(one) for one in stored.effects
    }
    taken = frozenset(one.name for one in carried if is_thermal(one) and one.triad in thermal)
    return Correction(triads["accelerometer"], triads["gyroscope"], remarks, sizes, thermal, taken)


def _triad(part: Mapping[str, Any] | None, nominal: float | None, si: float) -> TriadCorrection | None:
    if part is None:
        return None
    k = np.array(part["scale_factor"]["value"], dtype=float).reshape(3)
    E = np.array(part["misalignment"]["value"], dtype=float).reshape(3, 3)
    D = np.array(part["bias"]["value"], dtype=float).reshape(3)
    sign = -1 if (k < 0).all() else 1  # where the axes differ, their gains tell which counts backwards
    k0 = sign * mean_scale(k) if nominal is None else nominal
    return TriadCorrection(NominalScale(k0, part["scale_factor"]["unit"], nominal is not None), k / k0, E, D * si)


def _remarks(document: Mapping[str, Any]) -> tuple[str, ...]:
    remarks = [
        f"{document['model']} {document['serial']}, accepted {document['accepted_utc']}, {document['status']}",
        f"made by {document['software']}; previous calibration {document['previous']}",
    ]
    if "temperature_range_c" in document:
        low, high = document["temperature_range_c"]
        remarks.append(f"measured at {low:.1f} to {high:.1f} degC")
    remarks.append("NOT CARRIED: the uncertainties; see the calibration")
    return tuple(remarks)
