"""A faults file: what goes wrong on a simulated line; what is no fault is refused with the line of its table."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field

from drivers.errors import TruthRefused
from drivers.simulated.faults import KINDS, Fault, TimedFault, faults_from, gnss_faults_from
from station.errors import DataRefused
from station.files.toml_reading import Key, line_of, read_tables, read_text_file

F = TypeVar("F")


class FaultsTable(BaseModel):
    """``[[fault]]`` and ``[[gnss_fault]]``; the rest may be a truth, which leaves these to the faults."""

    model_config = ConfigDict(extra="ignore", strict=True, frozen=True)

    fault: list[dict[str, Any]] = Field(default_factory=list)
    gnss_fault: list[dict[str, Any]] = Field(default_factory=list)


def read_faults(path: Path, *, is_on_can: bool) -> tuple[tuple[Fault, ...], tuple[TimedFault, ...]]:
    """Return the faults of the line and those of the receiver.

    Raises
    ------
    DataRefused
        With the line of the table that is no fault, or is one of CAN while the device is not on it.
    """
    table, lines = read_tables(read_text_file(path), path, FaultsTable)
    return (
        tuple(each_fault(table.fault, "fault", faults_of(is_on_can=is_on_can), path, lines)),
        tuple(each_fault(table.gnss_fault, "gnss_fault", gnss_faults_from, path, lines)),
    )


def each_fault(
    tables: list[dict[str, Any]],
    name: str,
    read: Callable[[list[Mapping[str, Any]]], tuple[F, ...]],
    path: Path,
    lines: dict[Key, int],
) -> Iterator[F]:
    """Yield what ``read`` makes of tables called ``name``; one that is no fault is refused with its line."""
    for number, table in enumerate(tables):
        try:
            yield from read([table])
        except TruthRefused as error:
            raise DataRefused(path, line_of((name, number), lines), error.found, error.expected) from error


def faults_of(*, is_on_can: bool) -> Callable[[list[Mapping[str, Any]]], tuple[Fault, ...]]:
    """Return what reads tables of a device's faults."""
    return faults_from if is_on_can else _off_can


def _off_can(tables: list[Mapping[str, Any]]) -> tuple[Fault, ...]:
    faults = faults_from(tables)
    for fault in faults:
        if fault.kind not in KINDS:
            raise TruthRefused(f"fault kind {fault.kind!r} of a device not on CAN", ", ".join(KINDS))
    return faults
