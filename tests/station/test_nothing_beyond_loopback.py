"""What listens by default listens on this machine alone: each kind of server started, its sockets looked at."""

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import psutil
import pytest

from drivers.addresses import whole_url
from drivers.ports import open_port
from drivers.simulated.companions.camera_server import SimulatedCamera
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station.sending import to_foxglove
from station.sending.outputs import About
from station.sending.sender import open_outputs
from station.tui.web_server import LoopbackServer

ABOUT = About("FOG-3", "1042", "a calibration", "body", np.eye(3), 0.01)


def bound() -> set[tuple[str, int]]:
    """Return every address by which a socket of this process hears others."""
    every = psutil.Process().net_connections(kind="inet")
    return {each.laddr for each in every if each.status == psutil.CONN_LISTEN or each.type == socket.SOCK_DGRAM}


@contextmanager
def simulated_device() -> Iterator[None]:
    with SimulatedDevice(Truth.example(1), 1, transport="tcp", speed=0.0):
        yield


@contextmanager
def simulated_receiver() -> Iterator[None]:
    with SimulatedGnss(Truth.example(1)):
        yield


@contextmanager
def simulated_camera() -> Iterator[None]:
    with SimulatedCamera(Truth.example(1)):
        yield


@contextmanager
def foxglove() -> Iterator[None]:
    pytest.importorskip("foxglove")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(to_foxglove, "PORT", 0)  # any free one: where it listens is what is asked
        (output,) = open_outputs(["foxglove"], ABOUT)
    yield
    output.close()


@contextmanager
def web_view() -> Iterator[None]:
    server = LoopbackServer(["true"], print, 0, lambda: Path())
    yield
    server._socket.close()  # noqa: SLF001 - serve, which ends with it, was not called


@contextmanager
def bare_udp() -> Iterator[None]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        number = free.getsockname()[1]
    port = open_port(whole_url(f"udp:{number}", "receiver"), 1.0)
    yield
    port.close()


SERVERS = [simulated_device, simulated_receiver, simulated_camera, foxglove, web_view, bare_udp]


@pytest.mark.parametrize("server", SERVERS)
def test_it_listens_on_the_loopback(server) -> None:
    before = bound()
    with server():
        opened = bound() - before
    assert opened, "it opened nothing that listens"
    assert {address for address, _ in opened} == {"127.0.0.1"}
