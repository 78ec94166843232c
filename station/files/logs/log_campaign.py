"""Logs of one unit as a campaign: read, put one after the other, given a kind each; written where it is asked."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import UNKNOWN
from procedures.counts.sample_times import NEAR_PERIOD_TOLERANCE, own_period
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.atomic_file import new_folder, replace_file
from station.files.campaign_folder.campaign_reading import NO_SITE, assumed_of_site, loaded_campaign
from station.files.campaign_folder.campaign_schema import (
    CAMPAIGN_TOML,
    CampaignImuTable,
    CampaignTable,
    SiteTable,
    StepTable,
)
from station.files.campaign_folder.loaded_campaign import LoadedCampaign, LoadedStep
from station.files.logs.inferred_reference import inferred_reference
from station.files.logs.log_columns import ColumnOptions, LogColumns, choose_columns
from station.files.logs.log_data import angle_at_ends, log_data
from station.files.logs.log_steps import step_of_log
from station.files.logs.means_table import is_means_table
from station.files.logs.unit_checks import Readings, check_units
from station.files.output_units import is_unit
from station.files.tables.reader import read_table
from station.files.tables.strict_csv import MAX_EXACT_INTEGER, TRIADS
from station.files.tables.table import Table
from station.files.toml_file import toml_text

_BRACKETS = re.compile(
    r"[\[(](?!.*[0-9]{2})(?=.*[^\W\d_])([^\[\]()]{1,12})[\])]\s*$"
)  # a unit, not [x8005] or [2]
PAUSE_S = 60.0  # between logs whose times do not say when they were recorded


@dataclass(frozen=True, slots=True)
class LogOptions:
    """What the user stated of all logs together; ``kinds`` (`step_kinds`), one or one a log, are guessed of none.

    ``uses_latitude``: what is asked for depends on gravity and the Earth's rate; else their absence is no warning.
    """

    columns: ColumnOptions = field(default_factory=ColumnOptions)
    kinds: tuple[str, ...] = ()
    latitude_deg: float | None = None
    uses_latitude: bool = True
    serial: str = UNKNOWN
    model: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LogCampaign:
    """The campaign that logs make, the columns of its files by name, and guesses and remarks as text.

    ``periods`` [s] are the logs' own sample periods where they differ; empty where they have one in common.
    """

    loaded: LoadedCampaign
    data: Mapping[str, Table]
    guesses: tuple[str, ...]
    notes: tuple[str, ...] = field(default=())
    periods: tuple[float, ...] = ()


def campaign_of_logs(files: Sequence[Path], stated: LogOptions) -> LogCampaign:
    """Read logs of one unit as a campaign.

    Raise `DataRefused` if one of them cannot be read or their units differ: with file, place, found, expected and
    what to do.
    """
    read = [read_table(file) for file in files]
    if not stated.kinds:
        _refuse_means(read, stated.columns)
    chosen = [_chosen(table, stated) for table in read]
    _refuse_other_units(chosen)
    ends = [angle_at_ends(found) for found in chosen]
    chosen = [
        found if angle is None else replace(found, reference=None, degrees_per_angle=None)
        for found, angle in zip(chosen, ends, strict=True)
    ]
    named = _names(files)
    data, origins, notes = list[Table](), list[float | None](), list[str]()
    for found, name in zip(chosen, named, strict=True):
        columns, origin, wording = log_data(found, stated.columns.rate_hz, name)
        if found.reference is None:  # a rate table turns
            wording += [
                f"{found.table.file.name}: {note}" for note in check_units(readings(found, columns, stated))
            ]
        data.append(columns)
        origins.append(origin)
        notes += wording
    data, apart = _placed(data, origins)
    imu, periods = _imu(chosen[0], data, stated)
    kinds = stated.kinds * len(files) if len(stated.kinds) == 1 else stated.kinds or (None,) * len(files)
    steps = list[LoadedStep]()
    guesses = [f"{found.table.file.name}: {guess}" for found in chosen for guess in found.guesses]
    for i, (kind, found) in enumerate(zip(kinds, chosen, strict=True)):
        own = imu.model_copy(update={"sample_period_s": periods[i]}) if periods else imu
        step, data[i], guess = step_of_log(data[i], kind, own, found, ends[i])
        steps.append(step)
        guesses += guess
    tables = _tables(imu, steps, stated)
    sha256 = {columns.name: columns.sha256 for columns in data}
    loaded = loaded_campaign(files[0].parent, tables, steps, sha256)
    warnings = [text for text in loaded.warnings if not text.startswith(NO_SITE)]
    if len(warnings) < len(loaded.warnings) and stated.uses_latitude:
        recorded = [triad for triad in TRIADS if any(any(getattr(found, triad)) for found in chosen)]
        warnings.insert(0, f"no --latitude: {assumed_of_site(recorded)}")
    loaded = replace(loaded, warnings=tuple(warnings), guesses=tuple(guesses), output_name=_output_name(chosen))
    if periods:  # each log was read at its own: there is none that all of them should have
        loaded = replace(loaded, campaign=replace(loaded.campaign, nominal_period=None))
    return LogCampaign(loaded, {each.name: each for each in data}, tuple(guesses), (*notes, *apart), periods)


def _chosen(table: Table, stated: LogOptions) -> LogColumns:
    """Return what a log's columns hold; of one that can only be a rate table the reference is inferred."""
    if any(not each.startswith("rate") for each in stated.kinds):
        return choose_columns(table, stated.columns)
    reference = inferred_reference(table, stated.columns)
    if reference is None:
        return choose_columns(table, stated.columns)
    found = choose_columns(table, replace(stated.columns, reference=reference))
    return replace(found, guesses=[f"rate table, reference is {reference}", *found.guesses])


def readings(found: LogColumns, data: Table, stated: LogOptions) -> Readings:
    """Return a log's outputs with the units that were stated, named or inferred, for `check_units`."""
    values = {
        triad: np.stack([data.columns[name] for name in names], axis=1) if names[0] in data.columns else None
        for triad, names in TRIADS.items()
    }
    return Readings(
        found.table.file, data.columns.get("t_s"), values, {"gyro": found.gyro, "accel": found.accel},
        {"gyro": found.unit_gyro, "accel": found.unit_accel},
        {"gyro": stated.columns.unit_gyro, "accel": stated.columns.unit_accel},
    )  # fmt: skip


def _output_name(chosen: Sequence[LogColumns]) -> str:
    """Return the unit in the brackets of the gyroscopes' columns, where all have one and it is none of rates."""
    named = [name for found in chosen for name in found.gyro if name]
    units = {match[1].strip() if (match := _BRACKETS.search(name)) else "" for name in named}
    unit = units.pop() if len(units) == 1 else ""
    is_rate = chosen[0].unit_gyro is not None or is_unit(unit)
    return "" if is_rate else unit


def _names(files: Sequence[Path]) -> list[str]:
    """Return what each log is called: by its own name, with its folder or a number where several are alike."""
    names = [file.name for file in files]
    if len(set(names)) < len(names):
        names = [f"{file.parent.name}/{file.name}" if names.count(file.name) > 1 else file.name for file in files]
    return [
        name if names.count(name) == 1 else f"{name} ({names[: i + 1].count(name)})"
        for i, name in enumerate(names)
    ]


def _refuse_means(tables: Sequence[Table], stated: ColumnOptions) -> None:
    """Refuse a table of means where samples are wanted: it would become noise or a soak."""
    for table in tables:
        if is_means_table(table, stated):
            found = f"{table.rows} rows that differ like poses, a table of means"
            remedy = (
                f"station diagnose {table.file.name} --as means uses it for a calibration; state --as or --rate "
                "if it is a log"
            )
            raise DataRefused(table.file, None, found, "samples of a recording", remedy, ErrorCode.KIND)


def _refuse_other_units(chosen: Sequence[LogColumns]) -> None:
    first = chosen[0]
    for other in chosen[1:]:
        for what in ("unit_gyro", "unit_accel"):
            ours, theirs = getattr(first, what), getattr(other, what)
            if ours and theirs and ours != theirs:
                expected = f"{ours} as in {first.table.file}"
                raise DataRefused(
                    other.table.file,
                    None,
                    f"{what} {theirs}",
                    expected,
                    "diagnose each by itself",
                    code=ErrorCode.UNIT,
                )


def _placed(data: Sequence[Table], origins: Sequence[float | None]) -> tuple[list[Table], list[str]]:
    """Return logs that each begin at 0 as far apart as one clock says, else one after the other."""
    timed = [i for i, each in enumerate(data) if "t_s" in each.columns]
    known = [origin for i in timed if (origin := origins[i]) is not None]
    begins = [origin - min(known) for origin in known] if len(known) == len(timed) and timed else []
    lengths = [float(data[i].columns["t_s"][-1]) for i in timed]
    spans = sorted((begin, begin + length) for begin, length in zip(begins, lengths, strict=False))
    is_one_clock = bool(begins) and all(first[1] < then[0] for first, then in pairwise(spans))
    if not is_one_clock:
        begins = [sum(lengths[:k]) + PAUSE_S * k for k in range(len(timed))]
    placed = list(data)
    for begin, i in zip(begins, timed, strict=True):
        columns = data[i].columns
        placed[i] = replace(data[i], columns={**columns, "t_s": columns["t_s"] + begin})
    if len(timed) < 2:
        return placed, []
    apart = "by their own clock" if is_one_clock else f"{PAUSE_S:g} s apart, in the order they were named"
    return placed, [f"the logs follow each other {apart}"]


def _imu(
    found: LogColumns, data: Sequence[Table], stated: LogOptions
) -> tuple[CampaignImuTable, tuple[float, ...]]:
    """Return the unit, and each log's own sample period [s] where they differ by more than one clock's would."""
    periods = [own_period(each.columns["t_s"]) if "t_s" in each.columns else np.nan for each in data]
    if stated.columns.rate_hz:
        periods = [1 / stated.columns.rate_hz]
    known = [period for period in periods if np.isfinite(period)] or [1.0]
    middle = float(np.median(known))
    is_one_rate = max(abs(period / middle - 1) for period in known) <= NEAR_PERIOD_TOLERANCE
    imu = CampaignImuTable(
        model=stated.model or UNKNOWN, serial=stated.serial, sample_period_s=middle,
        output="rate", unit_gyro=found.unit_gyro, unit_accel=found.unit_accel,
    )  # fmt: skip
    each = tuple(period if np.isfinite(period) else middle for period in periods)
    return imu, () if is_one_rate else each


def _tables(imu: CampaignImuTable, steps: Sequence[LoadedStep], stated: LogOptions) -> CampaignTable:
    site = None if stated.latitude_deg is None else SiteTable(latitude_deg=stated.latitude_deg)
    of_kind: dict[str, list[StepTable]] = {}
    for step in steps:
        of_kind.setdefault(step.kind, []).append(step.table)
    return CampaignTable(format="campaign/1", imu=imu, site=site).model_copy(update=of_kind)


ROWS_AT_ONCE = 100_000


def write_campaign(folder: Path, found: LogCampaign) -> None:
    """Write a new folder with ``campaign.toml`` and a file each log; on failure nothing is left.

    Raises
    ------
    CannotWrite
        If the folder cannot be made or is not empty.
    DataRefused
        If the logs are of several sample rates: a folder states one.
    """
    if found.periods:
        rates = ", ".join(f"{1 / period:.4g}" for period in found.periods)
        expected = "one sample rate, as a folder of campaign/1 states one"
        raise DataRefused(folder, None, f"logs of {rates} Hz", expected, "keep those of each rate by themselves")
    with new_folder(folder, CAMPAIGN_TOML):
        names = _csv_names(list(found.data))
        for name, data in found.data.items():
            replace_file(folder / names[name], b"".join(_csv(data)))
        tables = found.loaded.tables.model_dump(exclude_none=True, exclude_defaults=True)
        for steps in tables.values():
            for step in steps if isinstance(steps, list) else ():
                step["file"] = names[step["file"]]
        replace_file(folder / CAMPAIGN_TOML, toml_text(tables).encode())


def _csv_names(names: Sequence[str]) -> dict[str, str]:
    """Return the folder's file for each log: its name with .csv, numbered where several are alike."""
    stems = [re.sub(r"[^A-Za-z0-9_.-]+", "_", Path(name).stem).strip(".") or "log" for name in names]
    found = dict[str, str]()
    for i, (name, stem) in enumerate(zip(names, stems, strict=True)):
        found[name] = f"{stem}.csv" if stems.count(stem) == 1 else f"{stem}_{stems[: i + 1].count(stem)}.csv"
    return found


def _csv(data: Table) -> Iterator[bytes]:
    yield ",".join(data.columns).encode() + b"\n"
    for begin in range(0, data.rows, ROWS_AT_ONCE):
        part = [values[begin : begin + ROWS_AT_ONCE] for values in data.columns.values()]
        cells = [["" if cell != cell else repr(cell) for cell in _plain(values)] for values in part]
        yield ("\n".join(map(",".join, zip(*cells, strict=True))) + "\n").encode()


def _plain(values: FloatArray) -> list[float | int]:
    """Return numbers as Python's, whole ones without a point."""
    is_whole = np.all(values == np.round(values)) and np.all(np.abs(values) < MAX_EXACT_INTEGER)
    found: list[float | int] = (values.astype(np.int64) if is_whole else values).tolist()
    return found
