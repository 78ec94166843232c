"""What rates and specific forces cannot be if a body moves so: named with what they look like."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.axes_check import AxesDisagreement, disagreement, is_near
from procedures.attitude.mean_force import GravityCheck, gravity_check, windows_of
from procedures.error_codes import ErrorCode
from procedures.units import STANDARD_GRAVITY
from station.errors import DataRefused
from station.files.output_units import GYRO_UNITS

FORCE_UNITS = {"g": STANDARD_GRAVITY, "mg": 1e-3 * STANDARD_GRAVITY, "ug": 1e-6 * STANDARD_GRAVITY, "cm/s2": 0.01}
NEAR_GRAVITY = 0.2  # relative, of a mean or a rest: bias and scale factor of an accelerometer nobody calibrated
UPSIDE_DOWN = -0.7  # of the down vector's z: within 45 deg of it
LEAST_SHARE = 0.9  # of a log's windows


@dataclass(frozen=True, slots=True)
class LogPlace:
    """Where a log's rows stand: the file, a row's line; and the units that its columns are read in.

    ``units_by_option`` is whether these are told by ``--unit-gyro`` and ``--unit-accel``.
    """

    file: Path | str
    line: Callable[[int], int | None] = lambda _row: None
    rate_unit: str = "rad/s"
    force_unit: str = "m/s2"
    units_by_option: bool = False
    rate_names: tuple[str, ...] = ("p", "q", "r")
    outputs_per_deg_s: float | None = None  # told as N/(deg/s)

    def refused(self, row: int, found: str, expected: str, remedy: str, code: ErrorCode) -> DataRefused:
        """Return a refusal of a row."""
        return DataRefused(self.file, self.line(row), found, expected, remedy, code)


LEVER_ARM_SCALE = 3.0  # 1 + L w^2 / g of a sensor 30 m up a mast that swings at 0.13 Hz; none is higher up


def check_motion(log: AttitudeLog, place: LogPlace) -> list[str]:
    """Return notes; raise `DataRefused` if forces lack gravity, or rates are not of its axes and unit.

    Codes: `ErrorCode.GRAVITY`, `ErrorCode.UNIT`, `ErrorCode.AXES`.
    """
    windows = windows_of(log)
    if not len(windows.turn):
        return []
    seen = gravity_check(log, windows)
    _check_force_unit(seen, place)
    other = disagreement(log, windows)
    is_near = other is not None and 1 / LEVER_ARM_SCALE < other.scale < LEVER_ARM_SCALE
    if other is not None and (other.units or other.has_other_axes or not is_near):
        raise _rates_refused(other, place)
    if seen.is_absent:
        raise _without_gravity(seen, place)
    if other is None:
        return []
    return [
        f"gravity turns {other.scale:.3g} times as fast as the rates: "
        "a long lever arm, or a wrong range (full scale) of the gyroscopes"
    ]


def _check_force_unit(seen: GravityCheck, place: LogPlace) -> None:
    """Refuse a force that is gravity in another unit: of a steady length, or at rest."""
    length = seen.rest if seen.rest is not None else seen.largest
    if abs(length / STANDARD_GRAVITY - 1) < NEAR_GRAVITY or (seen.rest is None and not seen.is_steady):
        return
    for unit, factor in FORCE_UNITS.items():
        if abs(length * factor / STANDARD_GRAVITY - 1) < NEAR_GRAVITY and seen.largest > 0.5 * seen.usual:
            found = f"specific forces of {length:.3g} m/s2: looks like {unit}"
            told = f"--unit-accel {unit}" if place.units_by_option else f"multiply them by {factor:.6g}"
            raise place.refused(0, found, "m/s2, with gravity", told, ErrorCode.UNIT)
    if seen.rest is not None:
        if seen.rest < 0.5 * STANDARD_GRAVITY:
            raise _without_gravity(seen, place)
        found = f"{seen.rest:.3g} m/s2 at rest"
        remedy = "correct the unit or the range (full scale) of the accelerometers"
        raise place.refused(0, found, f"gravity, {STANDARD_GRAVITY:.3g} m/s2", remedy, ErrorCode.GRAVITY)


def _without_gravity(seen: GravityCheck, place: LogPlace) -> DataRefused:
    if seen.is_steady and abs(seen.usual / STANDARD_GRAVITY - 1) < NEAR_GRAVITY:
        found = (
            f"gravity that turns in a way that the rates do not (its mean over seconds is {seen.level:.2g} m/s2)"
        )
        expected = "rates and specific force of one sensor, about the same axes"
        return place.refused(0, found, expected, "correct unit, signs or order of the rates", ErrorCode.AXES)
    found = (
        f"specific forces that average {seen.largest:.2g} m/s2 over seconds ({seen.std:.2g} by motion, standard "
        "deviation): gravity was removed (linear or user acceleration)"
    )
    expected = f"specific force with gravity, {STANDARD_GRAVITY:.3g} m/s2"
    remedy = "name or record the raw accelerometer's columns, not those of linear acceleration"
    return place.refused(0, found, expected, remedy, ErrorCode.GRAVITY)


def _rates_refused(seen: AxesDisagreement, place: LogPlace) -> DataRefused:
    std = "" if seen.scale_std is None else f" (u = {seen.scale_std:.2g})"
    if seen.has_other_axes:
        letters = dict(zip("pqr", place.rate_names, strict=True))
        named = ",".join(each[:-1] + letters[each[-1]] for each in seen.reading.split(","))
        found = f"gravity turning as if the rates were {named}"
        if seen.units != ("rad/s",):
            found += f", times {seen.scale:.4g}{std}"
        expected = "rates about the same right-handed axes as the accelerometers"
        return place.refused(seen.row, found, expected, "correct signs or order of the columns", ErrorCode.AXES)
    found = f"gravity turning {seen.scale:.4g} times as fast as the rates{std}"
    if seen.units:
        found += f": looks like {' or '.join(seen.units)}"
    if place.outputs_per_deg_s is not None:
        told = f"{place.outputs_per_deg_s / seen.scale:.3g}/(deg/s)"
        remedy = f"say --unit-gyro {told}, if that is the range"
        return place.refused(seen.row, found, f"{place.outputs_per_deg_s:g}/(deg/s)", remedy, ErrorCode.UNIT)
    held = [unit for unit, count in GYRO_UNITS.items() if is_near(count * seen.scale, GYRO_UNITS[place.rate_unit])]
    if place.units_by_option and held:
        found, remedy = (
            found.partition(": looks like")[0] + f": looks like {held[0]}",
            f"say --unit-gyro {held[0]}",
        )
    elif seen.units:
        remedy = f"convert the columns to {place.rate_unit}"
    else:
        remedy = "correct the range (full scale) or the unit of the rates, or the unit of time"
    return place.refused(seen.row, found, f"{place.rate_unit}", remedy, ErrorCode.UNIT)


def check_upright(log: AttitudeLog, place: LogPlace, *, at_start: bool = False) -> None:
    """Raise `DataRefused` if a log without truth is upside down all along, or ``at_start``.

    It hangs upside down; z points up; or the accelerometers read gravity where specific force is minus that. Gyros
    cannot tell the last: f' = f x omega holds for -f as well.
    """
    if log.roll is not None:
        return
    mean = windows_of(log).body_mean()
    is_upside_down = -mean[:, 2] < UPSIDE_DOWN * np.linalg.norm(mean, axis=1)
    if not len(mean) or not (np.mean(is_upside_down) >= LEAST_SHARE or (at_start and is_upside_down[0])):
        return
    found = "+1 g along the axis that is to point down: upside down, other axes, or forces that are gravity"
    remedy = (
        "say --axes F,R,D if other axes point forward, right, down; --accel-convention gravity if 1 g at rest "
        "points down (as iOS); --accel-convention force if it is upside down"
    )
    raise place.refused(0, found, "-1 g along it, of what stands upright", remedy, ErrorCode.AXES)
