"""``station apply``: a stored calibration applied to what was recorded."""

import signal
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from station.commands import Database
from station.commands._log_options import COLUMNS, LogOptions
from station.commands._options import Axes, argument, flag, option, refused_as

if TYPE_CHECKING:
    from station.calibration import Calibration


def apply(
    recording: Annotated[Path, argument("INPUT", "A log, a recording (.mcap) or its folder, or a campaign/1.")],
    calibration: Annotated[str, option("FILE|SERIAL", "Else a unit's newest stored one.")],
    out: Annotated[Path, option("FILE", ".csv, .parquet, .mcap, .npz, .mat or .ros2.")],
    units: Annotated[str, option("FORCE,RATE", "As in g,deg/s; names of columns follow.")] = "m/s2,rad/s",
    frame: Annotated[str, option("FRAME", "sensor, cube or frd (forward-right-down).")] = "sensor",
    axes: Axes = "",
    without: Annotated[list[str] | None, option("EFFECT", "Do not correct this error term; repeatable.")] = None,
    force: Annotated[
        bool, flag("--force", "Write it even if specific force or rate at rest is impossible.")
    ] = False,
    *,
    log: Annotated[LogOptions, (*COLUMNS, "temperature", "unit_temperature", "aux", "serial")],
    db: Database = None,
) -> None:
    """Write specific force [m/s2] and angular rate [rad/s] of a recording, corrected by a calibration.

    Columns are t_s, f_x_m_s2, ..., omega_z_rad_s, then temp_c and auxiliary channels. Counts must be those of each
    sample alone; a campaign states its own format. FILE.json next to the output holds the remaining standard
    uncertainty of the calibration, minute by minute, in m/s2 and rad/s. A recording may have any length, in
    constant memory, except for .mat.

    Nothing is written, and the exit code is 3, if the calibration belongs to another unit; the input of an error
    term is not in the recording (--without continues); rates are given for counts or counts for rates; the sample
    rate is more than 1 % off the stated one; time goes back; or the unit rests and its specific force is not 9.8
    m/s2 within 20 % or its rate not below 0.1 deg/s plus noise (--force continues).

    Example: station apply drive.csv --calibration S123 --out drive.parquet
    """
    from station.applying.applying import OutputRequest, Progress, apply_to
    from station.applying.open_source import open_source
    from station.calibrated.output_frame import frame_named
    from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, unit_named

    words = [unit_named(word) for word in units.split(",")]
    with refused_as("--units"):
        if len(words) != 2 or words[0] not in ACCEL_UNITS or words[1] not in GYRO_UNITS:
            expected = f"one of {', '.join(ACCEL_UNITS)} and one of {', '.join(GYRO_UNITS)}"
            raise ValueError(f"found {units!r}, expected {expected}, as in g,deg/s")
    with refused_as("--frame"):
        in_frame = frame_named(frame)
    source = open_source(recording, log.columns(), log.serial)
    known = _calibration(calibration, db, source.stated.model).without(*(without or ()))
    for note in source.stated.notes:
        typer.echo(f"inferred: {note}", err=True)
    asked = OutputRequest(in_frame, axes or None, (words[0], words[1]), force=force)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that what is written aside is taken away
    read = Path(calibration) if Path(calibration).is_file() else None
    done = apply_to(source, known, out, asked, Progress(), read)
    for warning in done["warnings"]:
        typer.echo(f"warning: {warning}", err=True)
    typer.echo(
        f"{out}: {done['samples']} samples at {1 / done['period_s']:.6g} Hz, {known.model} {known.serial}, "
        f"{out}.json"
    )


def _calibration(named: str, db: str | None, model: str | None) -> "Calibration":
    """Return the calibration in a file, or the newest that is stored of a serial number."""
    from station.calibration import load

    if Path(named).is_file() or named.endswith(".json"):
        return load(named)
    from station.applying.applying import newest_of

    return newest_of(named, db, model)
