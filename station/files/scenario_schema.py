"""The tables of a scenario file (`scenario/1`) and of a faults file: names with units, types, ranges, defaults."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, model_validator

from drivers.addresses import host_and_port
from drivers.errors import TruthRefused
from drivers.simulated.faults import KINDS, Fault, TimedFault, faults_from, gnss_faults_from
from drivers.simulated.server import CAN_TRANSPORTS
from drivers.wire import FORMATS
from station.errors import DataRefused
from station.files.fusion_folder.fusion_schema import Rigid
from station.files.toml_file import Key, Text, TomlTable, line_of, read_tables, read_text_file

Port = Annotated[int, Field(ge=0, le=65535)]
Seed = Annotated[int, Field(ge=0, lt=2**31)]  # it ends a serial number of 24 characters
Seconds = Annotated[float, Field(ge=0, lt=1e9)]


class SimulatedImuTable(TomlTable):
    """``[imu]``: how the IMU is connected; ``link`` and ``port`` as those of `station simulate`.

    ``track`` is a CSV file along which it is driven, and receiver and camera with it.
    """

    transport: Literal["pty", "tcp", "slcan", "udp_multicast"] = "pty"
    format: str = "counts"
    link: str = ""
    port: Port = 0
    control: Port = 0
    dbc: str = ""
    map: str = ""
    track: str = ""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.format not in FORMATS:
            raise ValueError(f"format to be one of {', '.join(FORMATS)}")
        if self.link and self.transport not in {"pty", "slcan"}:
            raise ValueError("a link only where transport is pty or slcan")
        if self.port and self.transport != "tcp":
            raise ValueError("a port only where transport is tcp")
        if (self.dbc or self.map) and self.transport not in CAN_TRANSPORTS:
            raise ValueError(f"dbc and map only where transport is {' or '.join(CAN_TRANSPORTS)}")
        return self


class AutopilotTable(TomlTable):
    """``[gnss.autopilot]``: see `AutopilotTruth`; ``key`` is a file, ``denies`` are messages."""

    system: Annotated[int, Field(ge=1, le=255)] = 1
    default_hz: Annotated[float, Field(gt=0, le=100)] = 1.0
    latency_s: Annotated[float, Field(ge=0, le=10)] = 0.1
    denies: list[int] = Field(default_factory=list)
    knows_intervals: bool = True
    obeys: bool = True
    states_utc: bool = False
    states_accuracy: bool = True
    states_velocity: bool = True
    airspeed_m_s: Annotated[float, Field(ge=0)] = 0.0
    key: str = ""


class SimulatedGnssTable(TomlTable):
    """``[gnss]``: an autopilot with a receiver; ``to`` is where UDP is sent to.

    ``track`` is a CSV file along which the receiver goes alone; without it, where the IMU goes.
    """

    transport: Literal["udp", "tcp", "pty"] = "udp"
    link: str = ""
    port: Port = 0
    to: str = ""
    track: str = ""
    autopilot: AutopilotTable = Field(default_factory=AutopilotTable)

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.to and (self.transport != "udp" or self.peer is None):
            raise ValueError('to = "HOST:PORT", and transport = "udp"')
        if self.link and self.transport != "pty":
            raise ValueError("a link only where transport is pty")
        if self.port and (self.transport == "pty" or self.to):
            raise ValueError("a port only where it listens, on udp or tcp")
        return self

    @property
    def peer(self) -> tuple[str, int] | None:
        """Where UDP is sent to."""
        return host_and_port(self.to)


class SimulatedCameraTable(TomlTable):
    """``[camera]``: see `CameraTruth`; names as in ``camera/1``. What is not given is as it is there."""

    port: Port = 0
    width: Annotated[int, Field(ge=16, le=4096)] = 376
    height: Annotated[int, Field(ge=16, le=4096)] = 240
    fx_px: Annotated[float, Field(gt=0)] = 230.0
    fy_px: Annotated[float, Field(gt=0)] = 230.0
    cx_px: float | None = None
    cy_px: float | None = None
    imu_from_camera: Rigid | None = None
    rate_hz: Annotated[float, Field(gt=0, le=100)] = 15.0
    latency_s: Annotated[float, Field(ge=0, le=10)] = 0.04
    clock_offset_s: Annotated[float, Field(ge=0)] = 1000.0
    clock_ppm: Annotated[float, Field(ge=-1000, le=1000)] = 20.0
    quality: Annotated[int, Field(ge=1, le=100)] = 90
    noise: Annotated[float, Field(ge=0, le=100)] = 1.5


class HandsTable(TomlTable):
    """``[[hands]]``: a command of the hands, at a device time; without ``at_s`` when the one before is over."""

    do: Annotated[str, Field(max_length=200)]
    at_s: Seconds | None = None


class ScenarioTable(TomlTable):
    """All of it. ``truth``, ``fault``, ``gnss_fault`` and ``camera_fault`` are read by `drivers.simulated`."""

    format: Literal["scenario/1"]
    title: Text | None = None
    seed: Seed = 1
    speed: Annotated[float, Field(ge=0)] = 1.0
    example: Seed | None = None
    truth: dict[str, Any] = Field(default_factory=dict)
    imu: SimulatedImuTable = Field(default_factory=SimulatedImuTable)
    gnss: SimulatedGnssTable | None = None
    camera: SimulatedCameraTable | None = None
    hands: list[HandsTable] = Field(default_factory=list)
    fault: list[dict[str, Any]] = Field(default_factory=list)
    gnss_fault: list[dict[str, Any]] = Field(default_factory=list)
    camera_fault: list[dict[str, Any]] = Field(default_factory=list)


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
