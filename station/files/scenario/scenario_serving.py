"""Serves a scenario and tells what happens on the bench as it happens."""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

from drivers.simulated.companions.camera_server import SimulatedCamera
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.server import SimulatedDevice
from station.files.scenario.scenario_reading import Scenario

POLL_PERIOD_S = 0.1


def serve_scenario(
    scenario: Scenario,
    announce: Callable[[SimulatedDevice, SimulatedGnss | None, SimulatedCamera | None], None],
    tell: Callable[[str], None],
    speed: float | None = None,
) -> None:
    """Serve until interrupted.

    ``announce`` is given the devices once they can be opened, ``tell`` a line for each thing that happens.
    ``speed``, device seconds per second, goes before the scenario's.
    """
    with ExitStack() as stack:
        device = stack.enter_context(_device(scenario, speed))
        gnss = stack.enter_context(_gnss(scenario, device)) if scenario.table.gnss else None
        camera = stack.enter_context(_camera(scenario, device)) if scenario.camera else None
        announce(device, gnss, camera)
        served = [each for each in (device, gnss, camera) if each is not None]
        due, told = sorted(_events(scenario)), 0
        while all(each.failure is None for each in served):
            while due and due[0][0] <= device.time:
                at_s, text = due.pop(0)
                tell(f"{at_s:8.1f} s  {text}")
            for command, answer in device.device.moved[told:]:
                told += 1
                if not answer.startswith("ok"):  # somebody else has moved the cube meanwhile
                    tell(f"{device.time:8.1f} s  {command}: {answer}")
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
        dbc=scenario.beside(imu.dbc), mapping=scenario.beside(imu.map),
    )  # fmt: skip
    if scenario.drive is not None:
        device.device.drive(scenario.drive)
    return device


def _gnss(scenario: Scenario, device: SimulatedDevice) -> SimulatedGnss:
    gnss = scenario.table.gnss
    assert gnss is not None
    return SimulatedGnss(
        scenario.truth, scenario.autopilot, scenario.gnss_faults, scenario.track, scenario.table.seed,
        beside=device, transport=gnss.transport, port=gnss.port, to=gnss.peer,
        link=Path(gnss.link) if gnss.link else None,
    )  # fmt: skip


def _camera(scenario: Scenario, device: SimulatedDevice) -> SimulatedCamera:
    assert scenario.table.camera is not None
    return SimulatedCamera(
        scenario.truth, scenario.camera, scenario.camera_faults, scenario.drive, scenario.table.seed,
        beside=device, port=scenario.table.camera.port,
    )  # fmt: skip
