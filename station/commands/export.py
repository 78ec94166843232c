"""``station export``: a stored calibration for those who apply it."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from station.commands import Database
from station.commands._options import argument, option


def export(
    calibration: Annotated[Path, argument("CALIBRATION", "A calibration.json.")],
    to: Annotated[Literal["ardupilot", "px4", "kalibr"], option("--to", "", "Who is to apply it.")],
    out: Annotated[Path | None, option("--out", "FILE", "Where to write; else to stdout.")] = None,
    nominal_accel: Annotated[
        float | None, option("--nominal-accel", "COUNT/(G S)", "The driver's scale factor.")
    ] = None,
    nominal_gyro: Annotated[
        float | None, option("--nominal-gyro", "COUNT/DEG", "The driver's scale factor.")
    ] = None,
    db: Database = None,
) -> None:
    """Write a calibration as ArduPilot or PX4 parameters (m/s2, rad/s) or as Kalibr's imu.yaml.

    A driver turns counts into SI by one nominal scale factor for all axes; the file corrects what that leaves. Its
    comments say what it cannot carry (misalignment, effects, sigmas) and how large an error that is. Without
    --nominal-accel and --nominal-gyro the mean of the unit's own axes, to 3 digits, is used and stated.

    Exit code 3 if the file is no calibration/1.

    Example: station export calibration.json --to px4 --out imu.params
    """
    for name, value in (("--nominal-accel", nominal_accel), ("--nominal-gyro", nominal_gyro)):
        if value is not None and not 0 < value < float("inf"):
            raise typer.BadParameter(f"{name} {value}: expected a positive number")
    from station.files.atomic_file import replace_file
    from station.files.exports import EXPORTS, read_correction

    correction = read_correction(calibration, nominal_accel, nominal_gyro)
    text = next(one for one in EXPORTS if one.name == to).text(correction)
    if out is None:
        typer.echo(text, nl=False)
    else:
        replace_file(out, text.encode())
        typer.echo(f"{out}: written; read its comments for what it does not carry", err=True)
