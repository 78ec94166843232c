"""The options that describe a table from elsewhere, and what they say put together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from station.commands._options import option, refused_as

if TYPE_CHECKING:
    from station.files.campaign_folder.loaded_campaign import LoadedCampaign
    from station.files.logs.log_campaign import LogCampaign
    from station.files.logs.log_columns import ColumnOptions
    from station.files.logs.means_table import MeansTable

Time = Annotated[str | None, option("--time", "COL", "Of a log: column of time, by name or number from 1.")]
Gyro = Annotated[str | None, option("--gyro", "A,B,C", "Gyroscopes x,y,z; - for a missing one.")]
Accel = Annotated[str | None, option("--accel", "A,B,C", "Accelerometers x,y,z; - for a missing one.")]
Utc = Annotated[str | None, option("--utc", "COL", "UTC of the rows, to check the time.")]
UnitTime = Annotated[
    str | None,
    option(
        "--unit-time",
        "UNIT",
        "s, ms, us, ns, min, h, days, tick:1e-4 (seconds a tick), unix-s, unix-ms, unix-us, unix-ns, excel, "
        "excel1904, matlab, julian, filetime, dotnet, hhmmss or yyyymmddhhmmss.",
    ),
]
UnitGyro = Annotated[
    str | None, option("--unit-gyro", "UNIT", "deg/s, rad/s, deg/h, mdeg/s, mrad/s, raw, or N/(deg/s).")
]
UnitAccel = Annotated[str | None, option("--unit-accel", "UNIT", "m/s2, g, mg, ug, cm/s2, raw, or N/g.")]
Temperature = Annotated[str | None, option("--temperature", "COL", "Temperature [degC].")]
Aux = Annotated[str | None, option("--aux", "COL,...", "Other channels that may affect the sensors.")]
Rate = Annotated[float | None, option("--rate", "HZ", "Sample rate, of a log without time.", min=1e-6, max=1e7)]
Reference = Annotated[
    str | None, option("--reference", "COL", "A rate table's rate [deg/s], a row a point, or the angle turned.")
]
As = Annotated[
    list[str] | None,
    option(
        "--as",
        "KIND",
        "soak, sequence, means, dwell:N, dwell:x_up, turn:+x:3, turn:+x:366.76deg, rate:x; once, or once a log.",
    ),
]
Latitude = Annotated[
    float | None, option("--latitude", "DEG", "Of the site; else it is unknown.", min=-90, max=90)
]
Serial = Annotated[str | None, option("--serial", "S", "The unit's serial number.")]
Folder = Annotated[Path | None, option("--campaign", "FOLDER", "Keep the log as a new campaign/1 folder.")]

MAX_MEANS_BYTES = 2**20  # a larger file has more rows than anybody has poses
LOG_SUFFIXES = (".csv", ".txt", ".log", ".tsv", ".dat", ".mat", ".npz", ".npy", ".parquet", ".gcsv")


@dataclass(frozen=True, slots=True)
class LogOptions:
    """The options as they were given, by name; None of one that was not."""

    given: Mapping[str, Any]

    @property
    def is_given(self) -> bool:
        """Say whether any was given."""
        return any(value is not None for value in self.given.values())

    def are_logs(self, files: Sequence[Path]) -> bool:
        """Say whether ``files`` are logs: files, what an option says is one, or what is named like one."""
        named = self.is_given or any(file.suffix.lower() in LOG_SUFFIXES for file in files)
        return any(file.is_file() for file in files) or (named and not any(f.is_dir() for f in files))

    def refuse_with_folders(self) -> None:
        """Raise typer's usage error if one was given: a campaign's folder says it all itself."""
        if given := [name for name, value in self.given.items() if value is not None]:
            raise typer.BadParameter(f"--{given[0].replace('_', '-')} is for logs, but these are campaign folders")

    def columns(self) -> "ColumnOptions":
        """Return what they say of a log's columns; a usage error where a unit is none."""
        from station.files.logs.log_columns import ColumnOptions
        from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, outputs_per_unit, time_unit

        say = self.given.get
        for name, known in (("unit_gyro", GYRO_UNITS), ("unit_accel", ACCEL_UNITS)):
            with refused_as(f"--{name.replace('_', '-')}"):
                outputs_per_unit(say(name) or "raw", known)
        with refused_as("--unit-time"):
            time_unit(say("unit_time") or "s")
        return ColumnOptions(
            time=say("time"), gyro=_several(say("gyro")), accel=_several(say("accel")),
            temperature=say("temperature"), auxiliary=_several(say("aux")) or (), reference=say("reference"),
            utc=say("utc"),
            unit_time=say("unit_time"), unit_gyro=say("unit_gyro"), unit_accel=say("unit_accel"),
            rate_hz=say("rate"),
        )  # fmt: skip

    def read(self, files: Sequence[Path]) -> "LogCampaign":
        """Read logs as one campaign; a usage error where an option is wrong, `DataRefused` where a log is."""
        from procedures.campaign.campaign import UNKNOWN
        from station.files.logs.log_campaign import LogOptions, campaign_of_logs
        from station.files.logs.log_steps import check_kinds

        say = self.given.get
        kinds = tuple(say("as") or ())
        with refused_as("--as"):
            check_kinds(kinds, len(files), has_reference=say("reference") is not None)
        columns = self.columns()
        return campaign_of_logs(
            files,
            LogOptions(
                columns, kinds, latitude_deg=say("latitude"), uses_latitude="latitude" in self.given,
                serial=say("serial") or UNKNOWN,
            ),
        )  # fmt: skip


def means_of_logs(files: Sequence[Path], options: LogOptions) -> "MeansTable | None":
    """Return a single log as a table of means where it is specified as one or looks like one; None of any other.

    Raises
    ------
    DataRefused
        If it is specified as one and is none.
    """
    from station.files.logs.means_table import KIND, is_means_table, means_of
    from station.files.tables.reader import read_table

    kinds = options.given.get("as") or ()
    if KIND in kinds and len(files) > 1:
        raise typer.BadParameter(f"found {len(files)} logs with --as {KIND}, expected one table")
    if len(files) != 1 or (kinds and KIND not in kinds):
        return None
    columns = options.columns()
    if not kinds and files[0].is_file() and files[0].stat().st_size > MAX_MEANS_BYTES:
        return None
    table = read_table(files[0])
    if not kinds and not is_means_table(table, columns):
        return None
    found = means_of(table, columns)
    for line in found.found.guesses:
        typer.echo(f"inferred: {files[0].name}: {line}", err=True)
    if not kinds:
        typer.echo(
            f"inferred: {files[0].name}: rows differ like poses, treated as a table of means (or state --as)",
            err=True,
        )
    for line in found.notes:
        typer.echo(f"note: {files[0].name}: {line}", err=True)
    return found


def read_logs(files: Sequence[Path], options: LogOptions, folder: Path | None) -> "LoadedCampaign":
    """Read logs as a campaign, say what was guessed, and keep it where that is asked.

    Raises
    ------
    DataRefused
        If a log cannot be read, or turns without a rest and it is not specified what it is.
    """
    found = options.read(files)
    for line in found.guesses:
        typer.echo(f"inferred: {line}", err=True)
    for line in found.notes:
        typer.echo(f"note: {line}", err=True)
    if not options.given.get("as"):
        from station.files.logs.log_steps import refuse_restless

        refuse_restless(found.loaded.campaign)
    if folder is not None:
        from station.files.logs.log_campaign import write_campaign

        write_campaign(folder, found)
        typer.echo(f"{folder}: campaign/1", err=True)
    return found.loaded


def _several(text: str | None) -> tuple[str, ...] | None:
    return None if text is None else tuple(part.strip() for part in text.split(","))
