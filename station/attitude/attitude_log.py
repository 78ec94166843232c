"""`attitude-log/1` (docs/explanation/attitude.md) read, and the checks of any log's motion.

The first rule that a log breaks is named with its line. `check_motion` refuses rates and specific forces that no
moving body has, and says what they look like.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from procedures.arrays import BoolArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.axes_check import AxesDisagreement, disagreement, is_near
from procedures.attitude.mean_force import GravityCheck, gravity_check, windows_of
from procedures.errors import ErrorCode
from procedures.units import STANDARD_GRAVITY
from station.errors import DataRefused
from station.files.opening import open_inside
from station.files.output_units import GYRO_UNITS
from station.files.tables.strict_csv import NamedColumns, read_csv
from station.files.tables.table import Table

FORCE_UNITS = {"g": STANDARD_GRAVITY, "mg": 1e-3 * STANDARD_GRAVITY, "ug": 1e-6 * STANDARD_GRAVITY, "cm/s2": 0.01}
NEAR_GRAVITY = 0.2  # relative, of a mean or a rest: bias and scale factor of an accelerometer nobody calibrated
UPSIDE_DOWN = -0.7  # of the down vector's z: within 45 deg of it
LEAST_SHARE = 0.9  # of a log's windows


@dataclass(frozen=True, slots=True)
class LogPlace:
    """Where a log's rows stand: the file, a row's line; and the units that its columns are read in.

    ``units_by_option`` is whether these are stated by ``--unit-gyro`` and ``--unit-accel``.
    """

    file: Path | str
    line: Callable[[int], int | None] = lambda _row: None
    rate_unit: str = "rad/s"
    units_by_option: bool = False
    rate_names: tuple[str, ...] = ("p", "q", "r")
    outputs_per_deg_s: float | None = None  # stated as N/(deg/s)
    rate_hz: float | None = None  # of a log whose sample rate an option may state

    def refused(self, row: int, found: str, expected: str, remedy: str, code: ErrorCode) -> DataRefused:
        """Return a refusal of a row."""
        return DataRefused(self.file, self.line(row), found, expected, remedy, code)


CORRECT = "correct the range (full scale) or the unit of the rates, or the unit of time"
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
    if other is not None and (other.units or other.has_other_axes or not is_near or not other.is_by_lever_arm):
        raise _rates_refused(other, place)
    if seen.is_absent:
        raise _without_gravity(seen, place)
    if other is None:
        return []
    return [
        f"gravity turns {other.scale:.3g} times as fast as the rates: "
        "a long lever arm, or a wrong range (full scale) of the gyroscopes, or a wrong sample rate"
    ]


def _check_force_unit(seen: GravityCheck, place: LogPlace) -> None:
    """Refuse a force that is gravity in another unit: of a steady length, or at rest."""
    length = seen.rest if seen.rest is not None else seen.largest
    if abs(length / STANDARD_GRAVITY - 1) < NEAR_GRAVITY or (seen.rest is None and not seen.is_steady):
        return
    for unit, factor in FORCE_UNITS.items():
        if abs(length * factor / STANDARD_GRAVITY - 1) < NEAR_GRAVITY and seen.largest > 0.5 * seen.usual:
            found = f"specific forces of {length:.3g} m/s2: looks like {unit}"
            stated = f"--unit-accel {unit}" if place.units_by_option else f"multiply them by {factor:.6g}"
            raise place.refused(0, found, "m/s2, with gravity", stated, ErrorCode.UNIT)
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
    rate = f", or --rate {place.rate_hz / seen.scale:.4g}, if that is the sample rate" if place.rate_hz else ""
    if place.outputs_per_deg_s is not None:
        stated = f"'{place.outputs_per_deg_s / seen.scale:.3g}/(deg/s)'"
        remedy = f"say --unit-gyro {stated}, if that is the range{rate}"
        return place.refused(seen.row, found, f"{place.outputs_per_deg_s:g}/(deg/s)", remedy, ErrorCode.UNIT)
    held = [unit for unit, count in GYRO_UNITS.items() if is_near(count * seen.scale, GYRO_UNITS[place.rate_unit])]
    if place.units_by_option and held:
        found, remedy = f"{found}: looks like {held[0]}", f"say --unit-gyro {held[0]}"
    else:
        found += f": looks like {' or '.join(seen.units)}" if seen.units else ""
        remedy = f"convert the columns to {place.rate_unit}" if seen.units else CORRECT
        if place.units_by_option:
            per = f"{GYRO_UNITS[place.rate_unit] / seen.scale:.4g}/(deg/s)"
            remedy = f"say --unit-gyro '{per}', if the unit, range or scale factor is another{rate}"
    return place.refused(seen.row, found, f"{place.rate_unit}", remedy, ErrorCode.UNIT)


def check_upright(log: AttitudeLog, place: LogPlace, *, at_start: bool = False) -> None:
    """Raise `DataRefused` if a log without truth is upside down all along, or ``at_start``.

    It hangs upside down; z points up; or the accelerometers read gravity where specific force is minus that. Gyros
    cannot determine the last: f' = f x omega holds for -f as well.
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


RATES = ("p_rad_s", "q_rad_s", "r_rad_s")
FORCES = ("fx_m_s2", "fy_m_s2", "fz_m_s2")
VELOCITY = ("vn_m_s", "ve_m_s", "vd_m_s")
TRUTH = ("roll_rad", "pitch_rad")
NEEDED = ("t_s", *RATES, *FORCES)
MAX_RATE_RAD_S = 87.0  # rad/s, 5000 deg/s: no gyro measures more
MAX_FORCE_M_S2 = 5000.0  # m/s2
MAX_HEADER = 10_000  # bytes
SAMPLE_PERIOD_RANGE_S = 1e-5, 1.0  # s: no IMU samples faster, and none slower can be followed
MAX_AID_VALUES = {  # of what is no sensor of the IMU: the largest value, and what a larger one looks like
    "airspeed_m_s": (3000.0, ""), **dict.fromkeys(VELOCITY, (10000.0, "")), "heading_rad": (4 * np.pi, "deg"),
    "roll_rad": (2 * np.pi, "deg"), "pitch_rad": (1.5709, "deg"),
}  # fmt: skip


def is_attitude_log(path: Path) -> bool:
    """Return whether a first line names rates as attitude-log/1 does; also of a file that is not there."""
    if not path.is_file():
        return True
    with path.open("rb") as stream:
        names = stream.readline(MAX_HEADER).decode("utf-8", "replace").strip().split(",")
    return sum(name.strip() in RATES for name in names) > 1


LOG_COLUMNS = NamedColumns(NEEDED, ("airspeed_m_s", *VELOCITY, "heading_rad", *TRUTH, "scored"), (VELOCITY, TRUTH))


def read_log(path: Path, notes: list[str] | None = None) -> AttitudeLog:
    """Read a log; what is odd about it, but may be right, is added to ``notes`` as text.

    Raise `DataRefused` if a column is missing or unknown, a cell is no number, time does not go forward, a rate
    is beyond any gyro, gravity is not in the specific force, or gyros and accelerometers disagree on how it
    turns.
    """
    if not path.exists():
        raise DataRefused(
            path,
            None,
            "no such file",
            "a CSV file of attitude-log/1",
            "name one that is there",
            code=ErrorCode.FILE_MISSING,
        )
    with open_inside(path.parent, path.name, path, None) as stream:
        table = read_csv(stream, path, LOG_COLUMNS)
    _check_time(table)
    _check_size(table)
    log = _log(table)
    found = check_motion(log, LogPlace(table.file, table.line))
    if notes is not None:
        notes += found
    return log


def _log(table: Table) -> AttitudeLog:
    columns = table.columns
    velocity = np.stack([columns[name] for name in VELOCITY], axis=1) if VELOCITY[0] in columns else None
    return AttitudeLog(
        t=columns["t_s"],
        omega_b=np.stack([columns[name] for name in RATES], axis=1),
        f_b=np.stack([columns[name] for name in FORCES], axis=1),
        airspeed=columns.get("airspeed_m_s"), velocity=velocity, heading=columns.get("heading_rad"),
        roll=columns.get("roll_rad"), pitch=columns.get("pitch_rad"), scored=_scored(table),
    )  # fmt: skip


def _scored(table: Table) -> BoolArray | None:
    scored = table.columns.get("scored")
    if scored is None:
        return None
    bad = np.flatnonzero(~np.isnan(scored) & (scored != 0) & (scored != 1))
    if len(bad):
        found = f"scored = {scored[bad[0]]:g}"
        raise DataRefused(table.file, table.line(bad[0]), found, "0 or 1")
    return np.asarray(scored == 1)


def _check_time(table: Table) -> None:
    t = table.columns["t_s"]
    back = np.flatnonzero(np.diff(t) <= 0)
    if len(back):
        row = int(back[0]) + 1
        found = f"t_s {t[row]:.9g} after {t[row - 1]:.9g}"
        remedy = "remove the row, or sort the file" if t[row] < t[row - 1] else "remove the repeated row"
        raise DataRefused(table.file, table.line(row), found, "a later time", remedy)
    if len(t) < 2:
        raise DataRefused(table.file, table.line(0), "a single row", "at least two rows")
    step = float(np.median(np.diff(t)))
    if not SAMPLE_PERIOD_RANGE_S[0] <= step <= SAMPLE_PERIOD_RANGE_S[1]:
        found = f"t_s going by {step:.3g} a row" + (": looks like ms or less" if step > 1 else "")
        raise DataRefused(
            table.file, table.line(1), found, "seconds, a row at least each", "convert t_s to seconds"
        )


def _check_size(table: Table) -> None:
    for names, most, unit, guess in (
        (RATES, MAX_RATE_RAD_S, "rad/s", "deg/s"),
        (FORCES, MAX_FORCE_M_S2, "m/s2", "mg"),
    ):
        for name in names:
            _check_column(table, name, most, f"beyond any sensor's range: looks like {guess}", unit)
    for name, (most, guess) in MAX_AID_VALUES.items():
        if name in table.columns:
            text = f"beyond {most:.4g}" + (f": looks like {guess}" if guess else "")
            _check_column(table, name, most, text, "rad" if guess else "m/s")


def _check_column(table: Table, name: str, most: float, text: str, unit: str) -> None:
    values = table.columns[name]
    beyond = np.flatnonzero(np.abs(values) > most)
    if len(beyond):
        found = f"{name} = {values[beyond[0]]:g}, {text}"
        raise DataRefused(table.file, table.line(int(beyond[0])), found, unit, f"convert the column to {unit}")
