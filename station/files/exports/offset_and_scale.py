"""A correction for a receiver of offset and scale per axis, and what that loses, in numbers."""

import numpy as np

from station.files.exports.correction import Correction, TriadCorrection


def parameters(correction: Correction, accel_offset: str, accel_scale: str, gyro_offset: str) -> dict[str, float]:
    """Return the parameters of the first IMU by name, as of each kind is given, with {} for the axis."""
    accel, gyro = correction.accelerometer, correction.gyroscope
    named = {} if accel is None else {accel_offset: accel.offset, accel_scale: accel.scale}
    named |= {} if gyro is None else {gyro_offset: gyro.offset}
    return {
        name.format(axis): float(value)
        for name, values in named.items()
        for axis, value in zip("XYZ", values, strict=True)
    }


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


def _misalignment(triad: TriadCorrection) -> str:
    return f"misalignment up to {triad.misalignment * 1e3:.3g} mrad"
