"""A simulated bench from one file (docs/how-to/testing.md): IMU, receiver, operator, faults, read and served.

What cannot be done is refused with its line, before anything is served.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drivers.errors import DriverError, TruthRefused, UnknownEffect
from drivers.mavlink.frames import read_key
from drivers.simulated.companions.camera_server import SimulatedCamera
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.companions.truths import AutopilotTruth, CameraTruth
from drivers.simulated.device import ByteDevice, ScheduledMove
from drivers.simulated.effects import planted
from drivers.simulated.faults import Fault, TimedFault, camera_faults_from, gnss_faults_from
from drivers.simulated.server import CAN_TRANSPORTS, SimulatedDevice
from drivers.simulated.truth import Truth, truth_from
from drivers.simulated.vehicle_track import VehicleTrack, load_track
from station.errors import DataRefused
from station.files.scenario_schema import (
    HandsTable,
    ScenarioTable,
    SimulatedCameraTable,
    SimulatedGnssTable,
    each_fault,
    faults_of,
)
from station.files.toml_file import Key, line_of, read_tables, read_text_file

MAX_MOVE_OVERLAP_S = 1e-6  # s: a move may begin so much before the one before is over


@dataclass(frozen=True, slots=True, eq=False)
class Scenario:
    """What is to be served; ``table`` has the ports. ``drive`` is the IMU's track, ``track`` the receiver's."""

    path: Path
    table: ScenarioTable
    truth: Truth
    moves: tuple[ScheduledMove, ...]
    faults: tuple[Fault, ...]
    autopilot: AutopilotTruth | None
    track: VehicleTrack | None
    gnss_faults: tuple[TimedFault, ...]
    drive: VehicleTrack | None
    camera: CameraTruth | None
    camera_faults: tuple[TimedFault, ...]

    def path_of(self, name: str) -> str:
        """Return the path of a file that is named in the scenario, from the folder it stands in."""
        return str(self.path.parent / name) if name else ""


def read_scenario(path: Path) -> Scenario:
    """Read a scenario file; raise `DataRefused` with the line of what is wrong."""
    table, lines = read_tables(read_text_file(path), path, ScenarioTable)
    where = _KeyLines(path, lines)
    truth = _truth(table, where)
    is_can = table.imu.transport in CAN_TRANSPORTS
    if table.gnss is None and table.gnss_fault:
        raise where.refusal(("gnss_fault", 0), "a fault of a receiver that is not there", "a table [gnss]")
    if table.camera is None and table.camera_fault:
        raise where.refusal(("camera_fault", 0), "a fault of a camera that is not there", "a table [camera]")
    drive = _drive(table, truth, path, where)
    return Scenario(
        path,
        table,
        truth,
        tuple(_moves(table, truth, where)),
        tuple(each_fault(table.fault, "fault", faults_of(is_on_can=is_can), path, where.lines)),
        _autopilot(table.gnss, path, where),
        _track(table.gnss.track if table.gnss else "", ("gnss", "track"), path, where) or drive,
        tuple(each_fault(table.gnss_fault, "gnss_fault", gnss_faults_from, path, where.lines)),
        drive,
        _camera(table.camera, where),
        tuple(each_fault(table.camera_fault, "camera_fault", camera_faults_from, path, where.lines)),
    )


@dataclass(frozen=True, slots=True)
class _KeyLines:
    path: Path
    lines: dict[Key, int]

    def refusal(self, key: Key, found: str, expected: str) -> DataRefused:
        return DataRefused(self.path, line_of(key, self.lines), found, expected)

    @contextmanager
    def at(self, *key: str | int) -> Iterator[None]:
        """Give what the simulator refuses the line of a key."""
        try:
            yield
        except TruthRefused as error:
            raise self.refusal(key, error.found, error.expected) from error
        except UnknownEffect as error:
            raise self.refusal(key, f"effect {error.name!r}", f"one of {', '.join(error.accepted)}") from error


def _truth(table: ScenarioTable, where: _KeyLines) -> Truth:
    base = Truth() if table.example is None else Truth.example(table.example)
    with where.at("truth", "terms"):
        terms = truth_from({"terms": table.truth.get("terms", {})}).terms
        planted({}, terms)
    for name, value in table.truth.items():
        with where.at("truth", name):
            truth = truth_from({name: value}, base)
        for effect, sizes in truth.effects.items():
            with where.at("truth", "effects", effect, next(iter(sizes), "")):
                planted({effect: sizes}, terms)
    return truth_from(table.truth, base)


def _moves(table: ScenarioTable, truth: Truth, where: _KeyLines) -> Iterator[ScheduledMove]:
    """Return all moves with their times; they are tried on a device in memory that lets no time pass."""
    device, free_s, queued_s = ByteDevice(truth, table.seed, "counts"), 0.0, 0.0
    for number, hands in enumerate(table.hands):
        at_s = _begin(hands, free_s, where, number)
        answer = device.execute(hands.do)
        if not answer.startswith("ok time "):
            raise where.refusal(("hands", number, "do"), f"{hands.do!r}", f"a move ({answer})")
        free_s = at_s + device.imu.done - queued_s
        queued_s = device.imu.done
        yield ScheduledMove(at_s, hands.do)


def _begin(hands: HandsTable, free_s: float, where: _KeyLines, number: int) -> float:
    if hands.at_s is None:
        return free_s
    if hands.at_s < free_s - MAX_MOVE_OVERLAP_S:
        key = ("hands", number, "at_s")
        raise where.refusal(
            key, f"at_s = {hands.at_s:g}", f"{free_s:.1f} or more: the simulated hands are busy until then"
        )
    return hands.at_s


def _autopilot(gnss: SimulatedGnssTable | None, path: Path, where: _KeyLines) -> AutopilotTruth | None:
    if gnss is None:
        return None
    given = gnss.autopilot.model_dump(exclude_unset=True)
    if "denies" in given:
        given["denies"] = frozenset(given["denies"])
    if "key" in given:
        try:
            given["key"] = read_key(str(path.parent / given["key"]))
        except DriverError as error:
            raise where.refusal(("gnss", "autopilot", "key"), str(error), "a key file") from error
    return AutopilotTruth(**given)


def _track(name: str, key: Key, path: Path, where: _KeyLines) -> VehicleTrack | None:
    if not name:
        return None
    text = read_text_file(path.parent / name).decode("utf-8", "replace")
    with where.at(*key):
        return load_track(text)


def _drive(table: ScenarioTable, truth: Truth, path: Path, where: _KeyLines) -> VehicleTrack | None:
    track = _track(table.imu.track, ("imu", "track"), path, where)
    if track is None:
        return None
    if table.hands:
        raise where.refusal(("hands", 0), "hands, and an IMU that is driven along a track", "one of them")
    with where.at("imu", "track"):
        ByteDevice(truth, table.seed, "counts").drive(track)
    return track


def _camera(table: SimulatedCameraTable | None, where: _KeyLines) -> CameraTruth | None:
    if table is None:
        return None
    given = table.model_dump(exclude={"port", "imu_from_camera"})
    named = {name.removesuffix("_px"): value for name, value in given.items()}
    for name, size in (("cx", table.width), ("cy", table.height)):  # the image's middle, where it is not reported
        named[name] = (size - 1) / 2 if named[name] is None else named[name]
    if table.imu_from_camera is not None:
        matrix = np.array(table.imu_from_camera)
        named |= {"C_bc": matrix[:3, :3], "t_bc": matrix[:3, 3]}
    with where.at("camera", "imu_from_camera"):
        return CameraTruth(**named)


POLL_PERIOD_S = 0.1


def serve_scenario(
    scenario: Scenario,
    announce: Callable[[SimulatedDevice, SimulatedGnss | None, SimulatedCamera | None], None],
    report: Callable[[str], None],
    speed: float | None = None,
) -> None:
    """Serve until interrupted.

    ``announce`` is given the devices once they can be opened, ``report`` a line for each thing that happens.
    ``speed``, device seconds per second, goes before the scenario's.
    """
    with ExitStack() as stack:
        device = stack.enter_context(_device(scenario, speed))
        gnss = stack.enter_context(_gnss(scenario, device)) if scenario.table.gnss else None
        camera = stack.enter_context(_served_camera(scenario, device)) if scenario.camera else None
        announce(device, gnss, camera)
        served = [each for each in (device, gnss, camera) if each is not None]
        due, stated = sorted(_events(scenario)), 0
        while all(each.failure is None for each in served):
            while due and due[0][0] <= device.time:
                at_s, text = due.pop(0)
                report(f"{at_s:8.1f} s  {text}")
            for command, answer in device.device.moved[stated:]:
                stated += 1
                if not answer.startswith("ok"):  # somebody else has moved the cube meanwhile
                    report(f"{device.time:8.1f} s  {command}: {answer}")
            time.sleep(POLL_PERIOD_S)
        raise next(each.failure for each in served if each.failure is not None)


def _events(scenario: Scenario) -> Iterator[tuple[float, str]]:
    for move in scenario.moves:
        yield move.at_s, f"hands: {move.command}"
    for fault in scenario.faults:
        yield fault.at_s, f"fault: {fault.kind}" + (f", again every {fault.every_s:g} s" if fault.every_s else "")
    for each in scenario.gnss_faults:
        yield each.at_s, f"GNSS fault: {each.kind} for {each.seconds:g} s"
    for one in scenario.camera_faults:
        yield one.at_s, f"camera fault: {one.kind} for {one.seconds:g} s"


def _device(scenario: Scenario, speed: float | None) -> SimulatedDevice:
    imu = scenario.table.imu
    device = SimulatedDevice(
        scenario.truth, scenario.table.seed, imu.format, scenario.table.speed if speed is None else speed,
        transport=imu.transport, link=Path(imu.link) if imu.link else None, port=imu.port,
        control_port=imu.control, faults=scenario.faults, moves=scenario.moves,
        dbc=scenario.path_of(imu.dbc), mapping=scenario.path_of(imu.map),
    )  # fmt: skip
    if scenario.drive is not None:
        device.device.drive(scenario.drive)
    return device


def _gnss(scenario: Scenario, device: SimulatedDevice) -> SimulatedGnss:
    gnss = scenario.table.gnss
    assert gnss is not None
    return SimulatedGnss(
        scenario.truth, scenario.autopilot, scenario.gnss_faults, scenario.track, scenario.table.seed,
        imu=device, transport=gnss.transport, port=gnss.port, to=gnss.peer,
        link=Path(gnss.link) if gnss.link else None,
    )  # fmt: skip


def _served_camera(scenario: Scenario, device: SimulatedDevice) -> SimulatedCamera:
    assert scenario.table.camera is not None
    return SimulatedCamera(
        scenario.truth, scenario.camera, scenario.camera_faults, scenario.drive, scenario.table.seed,
        imu=device, port=scenario.table.camera.port,
    )  # fmt: skip
