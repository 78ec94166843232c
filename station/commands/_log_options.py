"""The options that describe a table from elsewhere, and what they say put together."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from station.commands._options import option, refused_as

if TYPE_CHECKING:
    from station.files.campaign_folder.loaded_campaign import LoadedCampaign
    from station.files.logs.log_campaign import LogCampaign
    from station.files.logs.log_columns import ColumnOptions
    from station.files.logs.means_table import MeansTable

UNITS_OF_TIME = (
    "s, ms, us, ns, min, h, days, tick:1e-4 (seconds a tick), unix-s, unix-ms, unix-us, unix-ns, excel, "
    "excel1904, matlab, julian, filetime, dotnet, hhmmss or yyyymmddhhmmss."
)
KINDS = "soak, sequence, means, dwell:N, dwell:x_up, turn:+x:3, turn:+x:366.76deg, rate:x; once, or once a log."
MAX_MEANS_BYTES = 2**20  # a larger file has more rows than anybody has poses
LOG_SUFFIXES = (".csv", ".txt", ".log", ".tsv", ".dat", ".mat", ".npz", ".npy", ".parquet", ".gcsv")
COLUMNS = ("time", "gyro", "accel", "unit_gyro", "unit_accel", "unit_time", "rate")  # what every log needs


@dataclass(frozen=True, slots=True)
class LogOptions:
    """The options as they were given; None of one that was not, or that a command does not have."""

    time: Annotated[str | None, option("COL", "Of a log: column of time, by name or number from 1.")] = None
    gyro: Annotated[str | None, option("A,B,C", "Gyroscopes x,y,z; - for a missing one.")] = None
    accel: Annotated[str | None, option("A,B,C", "Accelerometers x,y,z; - for a missing one.")] = None
    unit_gyro: Annotated[str | None, option("UNIT", "deg/s, rad/s, deg/h, mdeg/s, mrad/s, raw, or N/(deg/s).")] = (
        None
    )
    unit_accel: Annotated[str | None, option("UNIT", "m/s2, g, mg, ug, cm/s2, raw, or N/g.")] = None
    unit_time: Annotated[str | None, option("UNIT", UNITS_OF_TIME)] = None
    temperature: Annotated[str | None, option("COL", "Temperature.")] = None
    unit_temperature: Annotated[
        str | None, option("UNIT", "degC, K, degF, or a step and offset, as 0.1degC or 0.0125degC+25.")
    ] = None
    aux: Annotated[str | None, option("COL,...", "Other channels that may affect the sensors.")] = None
    rate: Annotated[float | None, option("HZ", "Sample rate, of a log without time.", min=1e-6, max=1e7)] = None
    reference: Annotated[
        str | None, option("COL", "A rate table's rate [deg/s], a row a point, or the angle turned.")
    ] = None
    utc: Annotated[str | None, option("COL", "UTC of the rows, to check the time.")] = None
    as_: Annotated[list[str] | None, option("KIND", KINDS, "--as")] = None
    latitude: Annotated[float | None, option("DEG", "Of the site; else it is unknown.", min=-90, max=90)] = None
    serial: Annotated[str | None, option("S", "The unit's serial number.")] = None
    campaign: Annotated[Path | None, option("FOLDER", "Keep the log as a new campaign/1 folder.")] = None

    @property
    def given(self) -> list[str]:
        """Return the names of those that were given, as they are typed."""
        return [
            f"--{each.name.rstrip('_').replace('_', '-')}"
            for each in fields(self) if getattr(self, each.name) is not None
        ]  # fmt: skip

    def are_logs(self, files: Sequence[Path]) -> bool:
        """Say whether ``files`` are logs: files, what an option says is one, or what is named like one."""
        named = bool(self.given) or any(file.suffix.lower() in LOG_SUFFIXES for file in files)
        return any(file.is_file() for file in files) or (named and not any(f.is_dir() for f in files))

    def refuse_with_folders(self) -> None:
        """Raise typer's usage error if one was given: a campaign's folder says it all itself."""
        if self.given:
            raise typer.BadParameter(f"{self.given[0]} is for logs, but these are campaign folders")

    def columns(self) -> "ColumnOptions":
        """Return what they say of a log's columns; a usage error where a unit is none."""
        from station.files.logs.log_columns import ColumnOptions
        from station.files.output_units import (
            ACCEL_UNITS,
            GYRO_UNITS,
            outputs_per_unit,
            stated_temperature_unit,
            time_unit,
        )

        with refused_as("--unit-gyro"):
            outputs_per_unit(self.unit_gyro or "raw", GYRO_UNITS)
        with refused_as("--unit-accel"):
            outputs_per_unit(self.unit_accel or "raw", ACCEL_UNITS)
        with refused_as("--unit-time"):
            time_unit(self.unit_time or "s")
        with refused_as("--unit-temperature"):
            stated_temperature_unit(self.unit_temperature or "degC")
        return ColumnOptions(
            time=self.time, gyro=_several(self.gyro), accel=_several(self.accel), temperature=self.temperature,
            auxiliary=_several(self.aux) or (), reference=self.reference, utc=self.utc, unit_time=self.unit_time,
            unit_gyro=self.unit_gyro, unit_accel=self.unit_accel,
            unit_temperature=self.unit_temperature, rate_hz=self.rate,
        )  # fmt: skip

    def read(self, files: Sequence[Path], uses_latitude: bool) -> "LogCampaign":
        """Read logs as one campaign; a usage error where an option is wrong, `DataRefused` where a log is."""
        from procedures.campaign.campaign import UNKNOWN
        from station.files.logs import log_campaign
        from station.files.logs.log_steps import check_kinds

        kinds = tuple(self.as_ or ())
        with refused_as("--as"):
            check_kinds(kinds, len(files), has_reference=self.reference is not None)
        stated = log_campaign.LogOptions(
            self.columns(), kinds, self.latitude, uses_latitude, self.serial or UNKNOWN
        )
        return log_campaign.campaign_of_logs(files, stated)


def means_of_logs(files: Sequence[Path], options: LogOptions) -> "MeansTable | None":
    """Return a single log as a table of means where it is specified as one or looks like one; None of any other.

    Raise `DataRefused` if it is specified as one and is none.
    """
    from station.files.logs.means_table import KIND, is_means_table, means_of
    from station.files.tables.reader import read_table

    kinds = options.as_ or ()
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
    guesses = list(found.found.guesses)
    if not kinds:
        guesses.append("rows differ like poses, treated as a table of means (or state --as)")
    print_inferred(*([f"{files[0].name}: {line}" for line in lines] for lines in (guesses, found.notes)))
    return found


def read_logs(
    files: Sequence[Path], options: LogOptions, folder: Path | None = None, *, uses_latitude: bool = True
) -> "LoadedCampaign":
    """Read logs as a campaign, say what was guessed, and keep it where that is asked.

    Raise `DataRefused` if a log cannot be read, or turns without a rest and it is not specified what it is.
    """
    found = options.read(files, uses_latitude)
    print_inferred(found.guesses, found.notes)
    if not options.as_:
        from station.files.logs.log_steps import refuse_restless

        refuse_restless(found.loaded.campaign)
    if folder is not None:
        from station.files.logs.log_campaign import write_campaign

        write_campaign(folder, found)
        typer.echo(f"{folder}: campaign/1", err=True)
    return found.loaded


def print_inferred(guesses: Iterable[str], notes: Iterable[str]) -> None:
    """Print on stderr what was inferred from a log, and remarks on it."""
    for line in guesses:
        typer.echo(f"inferred: {line}", err=True)
    for line in notes:
        typer.echo(f"note: {line}", err=True)


def _several(text: str | None) -> tuple[str, ...] | None:
    return None if text is None else tuple(part.strip() for part in text.split(","))
