"""Any log of rates and specific forces, for the attitude: columns and units as `diagnose` reads them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.axes_check import unit_by_motion
from procedures.errors import ErrorCode
from procedures.units import STANDARD_GRAVITY
from station.attitude.attitude_log import (
    MAX_FORCE_M_S2,
    MAX_RATE_RAD_S,
    SAMPLE_PERIOD_RANGE_S,
    LogPlace,
    check_motion,
    check_upright,
    is_attitude_log,
    read_log,
)
from station.calibrated.output_frame import DEFAULT_AXES, body_axes
from station.errors import DataRefused
from station.files.logs.log_columns import ColumnOptions, LogColumns, choose_columns
from station.files.logs.log_data import log_data
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, outputs_per_unit
from station.files.tables.reader import read_table
from station.files.tables.strict_csv import TRIADS

CONVENTIONS = ("force", "gravity")
LEVEL_SHARE = 0.7  # of gravity along the axis that is to point up, at the start: within 45 deg of it


@dataclass(frozen=True, slots=True)
class ReadLog:
    """A log in forward-right-down, what was guessed of it and what had to be done, as text."""

    log: AttitudeLog
    guesses: Sequence[str] = ()
    notes: Sequence[str] = ()


def read_any_log(
    path: Path, stated: ColumnOptions | None, axes: FloatArray | None = None, convention: str | None = None
) -> ReadLog:
    """Read a log; as attitude-log/1 if its header is that and ``stated`` is None.

    ``axes`` (3, 3) takes the sensor's axes to forward-right-down, None is `DEFAULT_AXES`, of attitude-log/1 its
    own. ``convention`` is what accelerometers read at rest: "force" upwards, "gravity" downwards; None is force,
    and a log that then is upside down all along, or at its start where nobody stated ``axes``, is refused. Raise
    `DataRefused` if it cannot be read, a unit is neither stated nor to be found, or its motion contradicts it.
    """
    is_guessed = False
    if stated is None and is_attitude_log(path):
        notes = list[str]()
        found = ReadLog(read_log(path, notes), notes=notes)
        place = LogPlace(path, lambda row: row + 2)
    else:
        found, place = _general(path, stated or ColumnOptions())
        if axes is None:
            is_guessed, axes = True, body_axes(DEFAULT_AXES)
            found = replace(
                found, guesses=[*found.guesses, f"axes {DEFAULT_AXES}: {_resting(found.log)} (--axes)"]
            )
    log = found.log if convention != "gravity" else replace(found.log, f_b=-found.log.f_b)
    if axes is not None:
        log = replace(log, omega_b=log.omega_b @ axes.T, f_b=log.f_b @ axes.T)
    if convention is None:
        check_upright(log, place, at_start=is_guessed)
    return replace(found, log=log)


def _general(path: Path, stated: ColumnOptions) -> tuple[ReadLog, LogPlace]:
    chosen = choose_columns(read_table(path), replace(stated, temperature=""))
    _refuse_missing(chosen)
    data, origin, notes = log_data(chosen, stated.rate_hz, path.name)
    t = data.columns["t_s"]
    _refuse_slow(chosen, t)
    place = LogPlace(path, units_by_option=True)
    gyro, force = (np.stack([data.columns[name] for name in TRIADS[triad]], axis=1) for triad in ("gyro", "accel"))
    guesses = [f"{path.name}: {line}" for line in chosen.guesses]
    per_g = outputs_per_unit(chosen.unit_accel or "raw", ACCEL_UNITS)
    if per_g is None:
        raise _unknown_unit(path, "accelerometers", "--unit-accel m/s2, g, mg or N/g")
    force = force * (STANDARD_GRAVITY / per_g)
    per_deg_s = outputs_per_unit(chosen.unit_gyro or "raw", GYRO_UNITS)
    if per_deg_s is None and chosen.unit_gyro is None:
        unit = unit_by_motion(AttitudeLog(t, gyro, force))
        if unit is not None:
            guesses.append(f"{path.name}: gyroscopes in {unit}, by how gravity turns")
            per_deg_s = GYRO_UNITS[unit]
    if per_deg_s is None:
        raise _unknown_unit(path, "gyroscopes", "--unit-gyro deg/s, rad/s or N/(deg/s)")
    log = AttitudeLog(t if origin is None else t + origin, np.radians(gyro / per_deg_s), force)
    if chosen.unit_gyro is not None and chosen.unit_gyro in GYRO_UNITS:
        place = replace(place, rate_unit=chosen.unit_gyro)
    elif chosen.unit_gyro is not None:
        place = replace(place, outputs_per_deg_s=per_deg_s)
    place = replace(place, rate_names=tuple(str(name) for name in chosen.gyro), rate_hz=1 / log.nominal)
    _refuse_beyond(log, place)
    return ReadLog(log, guesses, [*notes, *check_motion(log, place)]), place


def _refuse_missing(chosen: LogColumns) -> None:
    for triad, what in (("gyro", "gyroscopes"), ("accel", "accelerometers")):
        names = getattr(chosen, triad)
        if not all(names):
            found = f"{what} x,y,z = {','.join(name or '-' for name in names)}"
            expected, remedy = "three axes of each", f"name them: --{triad} A,B,C"
            raise DataRefused(chosen.table.file, None, found, expected, remedy, ErrorCode.COLUMNS)


def _refuse_slow(chosen: LogColumns, t: FloatArray) -> None:
    period = float(np.median(np.diff(t)))
    if not SAMPLE_PERIOD_RANGE_S[0] <= period <= SAMPLE_PERIOD_RANGE_S[1]:
        expected = "from {:g} to {:g} s: no slower motion can be followed".format(*SAMPLE_PERIOD_RANGE_S)
        found = f"{period:.3g} s from row to row"
        raise DataRefused(
            chosen.table.file, None, found, expected, "state --unit-time or --rate", ErrorCode.TIME_UNIT
        )


def _refuse_beyond(log: AttitudeLog, place: LogPlace) -> None:
    for values, most, unit, option in (
        (log.omega_b, MAX_RATE_RAD_S, "rad/s", "--unit-gyro"), (log.f_b, MAX_FORCE_M_S2, "m/s2", "--unit-accel"),
    ):  # fmt: skip
        if np.abs(values).max() > most:
            row = int(np.abs(values).max(axis=1).argmax())
            found, expected = f"{np.abs(values).max():.4g} {unit}", f"at most {most:g}, as of any sensor"
            raise place.refused(row, found, expected, f"state the unit with {option}", ErrorCode.UNIT)


def _unknown_unit(path: Path, what: str, option: str) -> DataRefused:
    return DataRefused(
        path, None, f"{what} in an unknown unit", "rates and forces", f"say {option}", ErrorCode.UNIT
    )


def _resting(log: AttitudeLog) -> str:
    """Say which of the sensor's axes points up at the start, by the first second's mean."""
    mean = log.f_b[: max(round(1 / log.nominal), 1)].mean(axis=0)
    axis = int(np.argmax(np.abs(mean)))
    name = ("-" if mean[axis] < 0 else "") + "xyz"[axis]
    share = abs(mean[axis]) / max(float(np.linalg.norm(mean)), 1e-12)
    return f"at the start {name} points up" if share > LEVEL_SHARE else "at the start no axis points up"
