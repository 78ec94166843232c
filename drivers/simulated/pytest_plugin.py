"""A pytest plugin: simulated devices on real transports as fixtures (docs/how-to/testing.md).

It is loaded by every pytest of its environment, so it imports nothing until a fixture is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import pytest

if TYPE_CHECKING:
    from drivers.simulated.companions.camera_server import SimulatedCamera
    from drivers.simulated.companions.gnss_server import SimulatedGnss
    from drivers.simulated.server import SimulatedDevice
    from drivers.simulated.truth import Truth

MARKERS = {
    "simulated_imu": "truth, seed, faults, format, speed, transport ('pty', 'tcp'), hold ...",
    "simulated_can_imu": "truth, seed, faults, speed, transport ('slcan', 'udp_multicast'), dbc, mapping ...",
    "simulated_gnss": "truth, seed, faults, autopilot, track, speed, transport ('udp', 'tcp', 'pty') ...",
    "simulated_camera": "truth, seed, faults, camera, track, speed, port",
}
D = TypeVar("D", "SimulatedDevice", "SimulatedGnss", "SimulatedCamera")
F = TypeVar("F")
AS_FAST_AS_READ = 0.0
ALONE_SPEED = 10.0  # of a receiver without an IMU's clock: a fix each 20 ms


def pytest_configure(config: pytest.Config) -> None:
    """Make the markers known."""
    for name, what in MARKERS.items():
        config.addinivalue_line("markers", f"{name}(**settings): what the fixture is like: {what}")


@pytest.fixture
def simulated_imu(request: pytest.FixtureRequest) -> Iterator[SimulatedDevice]:
    """Serve an IMU on a pty, or on TCP with ``transport="tcp"``, while the test runs."""
    yield from _served(request, "simulated_imu", {"transport": "pty"})


@pytest.fixture
def simulated_can_imu(request: pytest.FixtureRequest) -> Iterator[SimulatedDevice]:
    """Serve an IMU on CAN, behind an slcan adapter on a pty, while the test runs."""
    yield from _served(request, "simulated_can_imu", {"transport": "slcan"})


@pytest.fixture
def simulated_gnss(request: pytest.FixtureRequest) -> Iterator[SimulatedGnss]:
    """Serve an autopilot with a GNSS receiver, with the test's simulated IMU, on its truth and clock."""
    from drivers.simulated.companions.gnss_server import SimulatedGnss
    from drivers.simulated.companions.truths import AutopilotTruth
    from drivers.simulated.faults import gnss_faults_from

    yield from _companion(request, SimulatedGnss, "autopilot", AutopilotTruth, gnss_faults_from, speed=ALONE_SPEED)


@pytest.fixture
def simulated_camera(request: pytest.FixtureRequest) -> Iterator[SimulatedCamera]:
    """Serve a camera over HTTP, with the test's simulated IMU, on its truth and clock."""
    from drivers.simulated.companions.camera_server import SimulatedCamera
    from drivers.simulated.companions.truths import CameraTruth
    from drivers.simulated.faults import camera_faults_from

    yield from _companion(request, SimulatedCamera, "camera", CameraTruth, camera_faults_from)


def _served(request: pytest.FixtureRequest, name: str, usual: Mapping[str, Any]) -> Iterator[SimulatedDevice]:
    from drivers.simulated.faults import Fault, faults_from
    from drivers.simulated.server import SimulatedDevice

    settings = {"seed": 1, "speed": AS_FAST_AS_READ, **usual, **_settings(request, name)}
    truth = _truth(settings)
    faults = _faults(settings, Fault, faults_from)
    yield from _until_over(SimulatedDevice(truth, faults=faults, **settings))


def _companion(
    request: pytest.FixtureRequest, device: Callable[..., D], key: str, kind: Callable[..., object],
    faults_of: Callable[[Iterable[Mapping[str, Any]]], tuple[Any, ...]], **usual: object,
) -> Iterator[D]:  # fmt: skip
    """Serve a second device whose own truth the marker gives under ``key``, as ``kind`` or its keys."""
    from drivers.simulated.faults import TimedFault

    settings = usual | _settings(request, f"simulated_{device.__name__.removeprefix('Simulated').lower()}")
    imu = _imu_of(request)
    truth = _truth(settings, imu.truth if imu else None)
    if isinstance(own := settings.pop(key, None), Mapping):
        own = kind(**own)
    faults = _faults(settings, TimedFault, faults_of)
    yield from _until_over(device(truth, own, faults, imu=imu, **settings))


def _until_over(device: D) -> Iterator[D]:
    with device:
        yield device
    if device.failure is not None:
        raise device.failure


def _settings(request: pytest.FixtureRequest, name: str) -> dict[str, Any]:
    """Return what the nearest marker says."""
    marker = request.node.get_closest_marker(name)
    if marker is None:
        return {}
    if marker.args:
        raise pytest.UsageError(f"marker {name}: found {marker.args[0]!r}; expected keywords: {MARKERS[name]}")
    return dict(marker.kwargs)


def _faults(
    settings: dict[str, Any], kind: type[F], read: Callable[[Iterable[Mapping[str, Any]]], tuple[F, ...]]
) -> list[F]:
    """Take ``faults`` out of the settings: faults, or tables of a fault file."""
    given = settings.pop("faults", ())
    return [fault if isinstance(fault, kind) else read([fault])[0] for fault in given]


def _truth(settings: dict[str, Any], imu: Truth | None = None) -> Truth:
    """Take ``truth`` out of the settings: a `Truth`, or keys of a truth file that differ from the usual."""
    from drivers.simulated.truth import Truth, truth_from

    given = settings.pop("truth", {})
    if isinstance(given, Truth):
        return given
    return truth_from(given, imu or Truth.example(settings.get("seed") or 1))


def _imu_of(request: pytest.FixtureRequest) -> SimulatedDevice | None:
    for name in ("simulated_imu", "simulated_can_imu"):
        if name in request.fixturenames:
            device: SimulatedDevice = request.getfixturevalue(name)
            return device
    return None
