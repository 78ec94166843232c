"""A campaign of logs written as a folder of ``campaign/1``: text that reads back to the same numbers."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML
from station.files.columns import MAX_EXACT_INTEGER, DataFile
from station.files.logs.log_campaign import LogCampaign
from station.files.new_folder import new_folder
from station.files.toml_writing import toml_text

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


def _csv(data: DataFile) -> Iterator[bytes]:
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
