"""A calibration/1 for receivers with offset, scale and a cubic of temperature per axis, and what that loses.

A driver turns counts into SI by one nominal scale factor ``k0`` for all axes of a triad, so that it reads
``raw = k / k0 (E u + D)``. Inverted without the off-diagonal of E: ``u = (raw - offset) * scale`` with
``offset = k D / k0`` and ``scale = k0 / (k E_qq)``. The residual is reported, not hidden.

What a flight stack can take of the temperature: a cubic of each sensor's offset, between two temperatures.
The raw reading at zero input is ``gain (D + b(T))``, b all that goes with the temperature as a polynomial. What
lags behind the thermometer is taken as if it did not. A polynomial above the third order is fitted again by one of
the third, at Chebyshev's nodes, which is within a few per cent of the least that its largest error can be.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from procedures.arrays import FloatArray
from procedures.effects.excitation import REFERENCE_C
from procedures.units import RAD_PER_DEG, RAD_S_PER_DEG_H, S_PER_MIN, STANDARD_GRAVITY
from station.calibrated.applied_calibration import CalibrationModel
from station.calibrated.applied_effects import AppliedEffect
from station.calibrated.correction_inputs import WARMTH
from station.calibrated.rates_and_forces import NOMINAL_SCALE_DIGITS, mean_scale
from station.calibrated.remaining_uncertainty import size_of
from station.errors import DataRefused
from station.exports.exported_calibration import carried_effects, read_stored, stated_size
from station.files.calibration_document import FORMAT

ORDER = 3
NODES = 200


@dataclass(frozen=True, slots=True, eq=False)
class ThermalOffset:
    """A triad's offset by temperature: ``cubic`` (3, 4), rows sensors, of powers of T - 25 degC in SI per K^n.

    It is added to the offset at 25 degC, between ``low`` and ``high`` [degC]. ``refit`` is the largest error that
    the third order makes, ``behind`` that of what lags, at 1 K/min, both SI.
    """

    cubic: FloatArray
    low: float
    high: float
    refit: float
    behind: float

    def at(self, temperature: float) -> FloatArray:
        """Return what it adds (3,) [m/s2], [rad/s] at a temperature [degC]."""
        found: FloatArray = self.cubic @ (temperature - REFERENCE_C) ** np.arange(ORDER + 1)
        return found

    def about(self, reference: float) -> FloatArray:
        """Return its coefficients (3, 4) in SI per K^n of powers of T - ``reference`` [degC]."""
        shift = Polynomial([reference - REFERENCE_C, 1.0])
        return _table([Polynomial(row)(shift) for row in self.cubic])


def is_thermal(effect: AppliedEffect) -> bool:
    """Say whether an effect is one of the offset that goes with the temperature, or lags behind it."""
    return all(
        slot is not None and slot.array == "bias" and (slot.signal == WARMTH or isinstance(slot.signal, float))
        for slot in effect.slots
    )


def thermal_offset(
    effects: Sequence[AppliedEffect], triad: str, gain: FloatArray, si: float, limits: tuple[float, float]
) -> ThermalOffset | None:
    """Return a triad's offset by temperature, None where it has none.

    ``gain`` (3,) is that of the raw reading, ``si`` what one of the effects' unit is in SI, ``limits`` [degC] are
    the temperatures at which it was measured.
    """
    own = [one for one in effects if one.triad == triad and is_thermal(one)]
    low, high = limits
    if not own or not low < high:
        return None
    parts = [
        (one, slot, column)
        for one in own
        for slot, column in zip(one.slots, one.coefficients.T, strict=True)
        if slot is not None
    ]
    most = max(slot.at + 1 for _, slot, _ in parts)
    whole, behind = np.zeros((3, max(most, ORDER) + 1)), np.zeros(3)
    lagging = defaultdict[tuple[AppliedEffect, float], FloatArray](lambda: np.zeros_like(whole))
    for one, slot, column in parts:
        whole[:, slot.at + 1] += column
        if isinstance(slot.signal, float):
            lagging[one, slot.signal][:, slot.at + 1] += column
    warmth = (low + high) / 2 - REFERENCE_C + (high - low) / 2 * np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
    for (_, tau), polynomials in lagging.items():
        behind += (
            tau / S_PER_MIN * np.array([np.abs(Polynomial(row).deriv()(warmth)).max() for row in polynomials])
        )
    cubic, refit = whole[:, : ORDER + 1], np.zeros(3)
    if most > ORDER:
        fits = [np.polynomial.Chebyshev.fit(warmth, Polynomial(row)(warmth), ORDER) for row in whole]
        cubic = _table([fit.convert(kind=Polynomial) for fit in fits])
        refit = np.array(
            [np.abs(fit(warmth) - Polynomial(row)(warmth)).max() for fit, row in zip(fits, whole, strict=True)]
        )
    scale = gain * si
    return ThermalOffset(
        cubic * scale[:, None], low, high, float((refit * abs(scale)).max()), float((behind * abs(scale)).max())
    )


def _table(cubics: Sequence[Polynomial]) -> FloatArray:
    """Return the coefficients (3, 4) of polynomials, which leave out those that are zero at their end."""
    return np.array([np.pad(one.coef, (0, ORDER + 1 - len(one.coef))) for one in cubics], dtype=np.float64)


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

    ``remarks`` state its origin; ``effects`` are its effects by name, with what each adds at most. ``thermal``
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

    Raise `DataRefused` if the file is no calibration/1.
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
        str(one["name"]): size_of(model, document, str(one["name"])) or stated_size(one) for one in stored.effects
    }
    taken = frozenset(one.name for one in carried if is_thermal(one) and one.triad in thermal)
    return Correction(triads["accelerometer"], triads["gyroscope"], remarks, sizes, thermal, taken)


def _triad(part: Mapping[str, Any] | None, nominal: float | None, si: float) -> TriadCorrection | None:
    if part is None:
        return None
    k = np.array(part["scale_factor"]["value"], dtype=float).reshape(3)
    E = np.array(part["misalignment"]["value"], dtype=float).reshape(3, 3)
    D = np.array(part["bias"]["value"], dtype=float).reshape(3)
    sign = -1 if (k < 0).all() else 1  # where the axes differ, their gains show which counts backwards
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


AT = "1 g and 100 deg/s along each axis, the ends of the temperatures measured, 1 K/min, 50 uT"
UNITS = {"accelerometer": "m/s2", "gyroscope": "rad/s"}


def parameters(
    correction: Correction, accel_offset: str, accel_scale: str, gyro_offset: str, at_c: float | None = None
) -> dict[str, float]:
    """Return the parameters of the first IMU by name, as of each kind is given, with {} for the axis.

    Offsets are those at ``at_c`` [degC] by the cubic, without it those of the calibration.
    """
    accel, gyro = correction.accelerometer, correction.gyroscope
    named = {} if accel is None else {accel_offset: _offset(correction, "accelerometer", accel, at_c)}
    named |= {} if accel is None else {accel_scale: accel.scale}
    named |= {} if gyro is None else {gyro_offset: _offset(correction, "gyroscope", gyro, at_c)}
    return {
        name.format(axis): float(value)
        for name, values in named.items()
        for axis, value in zip("XYZ", values, strict=True)
    }


def _offset(correction: Correction, name: str, triad: TriadCorrection, at_c: float | None) -> FloatArray:
    thermal = correction.thermal.get(name)
    if thermal is None or at_c is None:
        return triad.offset
    found: FloatArray = triad.offset + thermal.at(at_c)
    return found


def lost(correction: Correction) -> list[str]:
    """Say what the off-diagonal of E and the gyroscope's scale factor leave as error when they are left out."""
    texts = list[str]()
    if (triad := correction.accelerometer) is not None:
        texts += [
            f"accelerometer: counts to m/s2 by the nominal scale factor {triad.nominal}",
            f"NOT CARRIED: accelerometer {_misalignment(triad)}: {triad.misalignment * 1e3:.3g} mg error "
            f"at 1 g across",
        ]
    if (triad := correction.gyroscope) is not None:
        ppm = np.abs(1 / triad.scale - 1).max() * 1e6
        texts += [
            f"gyroscope: counts to rad/s by the nominal scale factor {triad.nominal}",
            f"NOT CARRIED: gyroscope {_misalignment(triad)}: {triad.misalignment * 100:.3g} deg/s error "
            f"at 100 deg/s across",
            f"NOT CARRIED: gyroscope scale factor, up to {ppm:.0f} ppm off the nominal: {ppm * 1e-4:.3g} deg/s "
            f"error at 100 deg/s",
        ]
    return texts


def effects_lost(correction: Correction, *, takes_temperature: bool) -> list[str]:
    """Say which effects are not carried, and how large they are; of offsets, what a cubic leaves."""
    taken = correction.in_thermal if takes_temperature else frozenset[str]()
    left = {name: size for name, size in correction.effects.items() if name not in taken}
    texts = [f"NOT CARRIED: {name}, {size}" for name, size in left.items()]
    if left:
        texts.append(f"sizes without another condition: at {AT}")
    for name, thermal in correction.thermal.items() if takes_temperature else ():
        unit = UNITS[name]
        texts.append(f"{name} offset by temperature: {thermal.low:.1f} to {thermal.high:.1f} degC")
        if thermal.refit:
            texts.append(f"NOT CARRIED: {name} offset beyond the third order: up to {thermal.refit:.2g} {unit}")
        if thermal.behind:
            lag = f"{thermal.behind:.2g} {unit} at 1 K/min"
            texts.append(f"NOT CARRIED: {name} offset lags behind the thermometer: up to {lag}")
    return texts


def _misalignment(triad: TriadCorrection) -> str:
    return f"misalignment up to {triad.misalignment * 1e3:.3g} mrad"
