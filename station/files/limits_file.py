"""``limits.toml``: the limits of an IMU model as a file, and a sample of one."""

from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from fixtures_db.imu_models import UNITS, Limit, covered, each_axis
from procedures.units import (
    DEG_H_PER_DEG_S,
    DEG_H_PER_RAD_S,
    RAD_PER_ARCSEC,
    RAD_PER_DEG,
    RAD_PER_URAD,
    STANDARD_GRAVITY,
)
from station.errors import DataRefused
from station.files.toml_file import Name, TomlTable, line_of, read_tables

_ANGLES = {"rad": 1.0, "mrad": 1e-3, "urad": RAD_PER_URAD, "deg": RAD_PER_DEG, "arcsec": RAD_PER_ARCSEC}
UNITS_OF: dict[str, dict[str, float]] = {  # by the unit of files: what a limit may be given in, and how much it is
    "g": {"mg": 1e-3, "ug": 1e-6, "m/s2": 1 / STANDARD_GRAVITY},
    "deg/h": {"deg/s": DEG_H_PER_DEG_S, "rad/s": DEG_H_PER_RAD_S},
    "rad": _ANGLES,
}
SMALL_ANGLE = {**_ANGLES, "ppm": 1e-6}  # of a misalignment, which has no unit in files
PPM = "ppm"


def units_of(parameter: str) -> dict[str, float]:
    """Return the units that a parameter may be given in, those of files first, and how much of that each is.

    A name that stands for no parameter has none.
    """
    known = next((UNITS[name] for name in covered(parameter)), ())
    others = SMALL_ANGLE if ".misalignment" in parameter else UNITS_OF.get(known[0], {}) if known else {}
    return {**dict.fromkeys(known, 1.0), **others}


class LimitTable(TomlTable):
    """``[[limit]]``."""

    parameter: str
    low: float | None = None
    high: float | None = None
    unit: str
    nominal: float | None = None
    guard_band: float = 0.0

    @property
    def limit(self) -> Limit:
        """The limit that it says, in the unit of files."""
        unit, (factor, offset) = self._unit_of_files()
        low, high = (None if end is None else factor * end + offset for end in (self.low, self.high))
        return Limit(self.parameter, low, high, unit, self.guard_band)

    def _unit_of_files(self) -> tuple[str, tuple[float, float]]:
        """Return the unit of files, and what takes a number in the unit given to it: factor and offset."""
        units = units_of(self.parameter) or {self.unit: 1.0}  # a name that is not known is refused by the limit
        unit = next(iter(units))
        is_scale = ".scale_factor" in self.parameter
        if self.nominal is not None and not (is_scale and self.unit == PPM and self.nominal > 0):
            raise ValueError("nominal above 0 of a scale factor alone, with unit ppm")
        if is_scale and self.unit == PPM:
            if self.nominal is None:
                raise ValueError(f"a nominal value in {unit} where a scale factor's limits are in ppm of it")
            return unit, (self.nominal * 1e-6, self.nominal)
        if self.unit not in units:
            ppm = [f"{PPM} with a nominal value"] if is_scale else []
            accepted = ", ".join(name for name in [*units, *ppm] if name != "1") or "1"
            raise ValueError(f"the unit of {self.parameter} to be one of {accepted}")
        return self.unit if is_scale else unit, (units[self.unit], 0.0)

    @model_validator(mode="after")
    def _is_a_limit(self) -> Self:
        _ = self.limit
        return self


class LimitsTable(TomlTable):
    """The whole of a ``limits.toml``."""

    model: Name
    limit: Annotated[list[LimitTable], Field(min_length=1)]


def limits_in(text: bytes, path: Path) -> tuple[str, tuple[Limit, ...]]:
    """Return the model of a ``limits.toml`` and its limits, one for each axis, in the units of files.

    ``text`` is the file's.

    Raises
    ------
    DataRefused
        With file and line, if it is none or limits a parameter twice.
    """
    tables, lines = read_tables(text, path, LimitsTable)
    limits = dict[str, Limit]()
    for index, table in enumerate(tables.limit):
        for one in each_axis(table.limit):
            if one.parameter in limits:
                line = line_of(("limit", index), lines)
                raise DataRefused(path, line, f"a second limit of {one.parameter}", "one limit of a parameter")
            limits[one.parameter] = one
    return tables.model, tuple(limits.values())


MODEL = "SIM-FOG3"
HEAD = """# Limits of an IMU model: edit the numbers, then
#   station fixtures limits MODEL --import limits.toml
# Units as the screens show them: ug, arcsec, deg/h, count/(g s), count/deg; or ppm of a nominal scale factor.
# A value is accepted if it is inside the limits by guard_band times its own standard uncertainty u.
model = "MODEL"
"""
LIMIT = """
[[limit]]
parameter = "{}"{}
low = {}
high = {}
unit = "{}"
guard_band = 2.0
"""
FIRST = """   # all three axes; accelerometer.scale_factor.x is one
nominal = 1000.0                           # count/(g s)"""
ROWS = (
    ("accelerometer.scale_factor", FIRST, -180000.0, 180000.0, "ppm"),
    ("accelerometer.misalignment", "", -2500.0, 2500.0, "arcsec"),
    ("accelerometer.bias", "", -12000.0, 12000.0, "ug"),
    ("gyroscope.scale_factor", "", 33000.0, 39000.0, "count/deg"),
    ("gyroscope.misalignment", "", -900.0, 900.0, "arcsec"),
    ("gyroscope.bias", "", -4.5, 4.5, "deg/h"),
)


def example_limits(model: str = MODEL) -> str:
    """Return the sample for a model."""
    head = HEAD.replace('"MODEL"', f'"{model}"').replace("limits MODEL", f"limits {model}")
    return head + "".join(LIMIT.format(*row) for row in ROWS)
