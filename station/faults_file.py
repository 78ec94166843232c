"""A faults file: what goes wrong on a simulated line; what is no fault is refused with the line of its table."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field

from drivers.simulated.errors import TruthRefused
from drivers.simulated.faults import KINDS, Fault, faults_from
from drivers.simulated.gnss_faults import GnssFault, gnss_faults_from
from station.campaign_folder.toml_text import Key, line_of, read_tables, read_text_file
from station.errors import DataRefused

F = TypeVar("F")


class FaultsTable(BaseModel):
    """``[[fault]]`` and ``[[gnss_fault]]``; the rest may be a truth, which leaves these to the faults."""

    model_config = ConfigDict(extra="ignore", strict=True, frozen=True)

    fault: list[dict[str, Any]] = Field(default_factory=list)
    gnss_fault: list[dict[str, Any]] = Field(default_factory=list)


def read_faults(path: Path, *, is_on_can: bool) -> tuple[tuple[Fault, ...], tuple[GnssFault, ...]]:
    """Return the faults of the line and those of the receiver.

    Raises
    ------
    DataRefused
        With the line of the table that is no fault, or is one of CAN while the device is not on it.
    """
    table, lines = read_tables(read_text_file(path), path, FaultsTable)
    read = faults_from if is_on_can else _off_can
    return (
        tuple(_each(table.fault, "fault", read, path, lines)),
        tuple(_each(table.gnss_fault, "gnss_fault", gnss_faults_from, path, lines)),
    )


def _each(
    tables: list[dict[str, Any]],
    name: str,
    read: Callable[[list[Mapping[str, Any]]], tuple[F, ...]],
    path: Path,
    lines: dict[Key, int],
) -> Iterator[F]:
    for number, table in enumerate(tables):
        try:
            yield from read([table])
        except TruthRefused as error:
            raise DataRefused(path, line_of((name, number), lines), error.found, error.expected) from error


def _off_can(tables: list[Mapping[str, Any]]) -> tuple[Fault, ...]:
    faults = faults_from(tables)
    for fault in faults:
        if fault.kind not in KINDS:
            raise TruthRefused(f"fault kind {fault.kind!r} of a device not on CAN", ", ".join(KINDS))
    return faults
