"""A correction for a receiver of offset and scale per axis, and what that loses, in numbers."""

import numpy as np

from procedures.arrays import FloatArray
from station.exports.correction import Correction, TriadCorrection

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
    said = list[str]()
    if (triad := correction.accelerometer) is not None:
        said += [
            f"accelerometer: counts to m/s2 by the nominal scale factor {triad.nominal}",
            f"NOT CARRIED: accelerometer {_misalignment(triad)}: {triad.misalignment * 1e3:.3g} mg error "
            f"at 1 g across",
        ]
    if (triad := correction.gyroscope) is not None:
        ppm = np.abs(1 / triad.scale - 1).max() * 1e6
        said += [
            f"gyroscope: counts to rad/s by the nominal scale factor {triad.nominal}",
            f"NOT CARRIED: gyroscope {_misalignment(triad)}: {triad.misalignment * 100:.3g} deg/s error "
            f"at 100 deg/s across",
            f"NOT CARRIED: gyroscope scale factor, up to {ppm:.0f} ppm off the nominal: {ppm * 1e-4:.3g} deg/s "
            f"error at 100 deg/s",
        ]
    return said


def effects_lost(correction: Correction, *, takes_temperature: bool) -> list[str]:
    """Say which effects are not carried, and how large they are; of offsets, what a cubic leaves."""
    taken = correction.in_thermal if takes_temperature else frozenset[str]()
    left = {name: size for name, size in correction.effects.items() if name not in taken}
    said = [f"NOT CARRIED: {name}, {size}" for name, size in left.items()]
    if left:
        said.append(f"sizes without another condition: at {AT}")
    for name, thermal in correction.thermal.items() if takes_temperature else ():
        unit = UNITS[name]
        said.append(f"{name} offset by temperature: {thermal.low:.1f} to {thermal.high:.1f} degC")
        if thermal.refit:
            said.append(f"NOT CARRIED: {name} offset beyond the third order: up to {thermal.refit:.2g} {unit}")
        if thermal.behind:
            lag = f"{thermal.behind:.2g} {unit} at 1 K/min"
            said.append(f"NOT CARRIED: {name} offset lags behind the thermometer: up to {lag}")
    return said


def _misalignment(triad: TriadCorrection) -> str:
    return f"misalignment up to {triad.misalignment * 1e3:.3g} mrad"
