"""``station export``: a stored calibration for those who apply it."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from station.commands import Database
from station.commands._options import argument, flag, option
from station.exports import EXPORTS, PREFIX, Request, export_paths

Target = StrEnum("Target", [(one.name, one.name) for one in EXPORTS])  # type: ignore[misc]


def export(
    calibration: Annotated[Path, argument("CALIBRATION", "A calibration.json.")],
    to: Annotated[Target, option("", "The target program.")],
    out: Annotated[Path | None, option("DIR|FILE", "Where to write; else stdout, if it is one file.")] = None,
    nominal_accel: Annotated[float | None, option("COUNT/(G S)", "The driver's scale factor.")] = None,
    nominal_gyro: Annotated[float | None, option("COUNT/DEG", "The driver's scale factor.")] = None,
    single: Annotated[bool | None, flag("--float/--double", "Number type of --to c; default double.")] = None,
    db: Database = None,
) -> None:
    """Write a calibration as a program, as ArduPilot or PX4 parameters, for Kalibr or for imu_calib of ROS.

    --to c writes a C99 header and source, --to matlab a function and its .mat: from counts to specific force and
    angular rate, with all error terms corrected. Names begin with the file's name, or fog_imu in a folder. The
    other formats correct the output of a driver that converts counts to SI with one nominal scale factor for all
    axes (m/s2, rad/s); without --nominal-accel and --nominal-gyro that is the mean of the unit's own axes, to 3
    digits. Comments list what the format cannot hold and the size of that error.

    Exit code 3 if the file is no calibration/1.

    Example: station export calibration.json --to px4 --out imu.params
    """
    target = next(one for one in EXPORTS if one.name == to)
    for name, value in (("--nominal-accel", nominal_accel), ("--nominal-gyro", nominal_gyro)):
        if value is not None and not 0 < value < float("inf"):
            raise typer.BadParameter(f"{name} {value}: expected a positive number")
        if value is not None and target.is_program:
            raise typer.BadParameter(f"{name}: --to {to} uses counts; omit it")
    if single is not None and not target.has_float:
        raise typer.BadParameter(f"--float, --double: only for --to c, not for {to}")
    from station.files.atomic_file import refuse_own, replace_file, replace_files

    if out is None and len(target.ends) > 1:
        raise typer.BadParameter(f"--to {to} writes {len(target.ends)} files: name a folder or a file by --out")
    name, paths = (PREFIX, {}) if out is None else export_paths(target, out)
    refuse_own(paths.values(), [calibration])
    files = target.files(Request(calibration, nominal_accel, nominal_gyro, name, bool(single)))
    if out is None:
        typer.echo(next(iter(files.values())).decode(), nl=False)
        return
    if len(files) == 1:
        replace_file(next(iter(paths.values())), next(iter(files.values())))
    else:
        replace_files({paths[end]: content for end, content in files.items()})
    typer.echo(f"{', '.join(map(str, paths.values()))}: written; comments list what is not carried", err=True)
