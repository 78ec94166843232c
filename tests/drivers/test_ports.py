"""Ports over real ptys and TCP sockets; every failure is its own error; the latency timer of an adapter."""

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from drivers import serial_port
from drivers.errors import LinkLost, PortBusy, PortDenied, PortNotFound, ReplayEnded
from drivers.framing import Decoder
from drivers.port_interface import Port
from drivers.ports import open_port
from drivers.serial_port import latency_ms, shorten_latency
from drivers.wire import WireFormat
from procedures.errors import ErrorCode
from tests.drivers.wire.blocks import each_format
from tests.patience import HANG_S
from tests.refusals import refused

every_format = each_format()


class Line:
    """A pty: the station opens ``url``, the test plays the device at ``master``."""

    def __init__(self) -> None:
        self.master, self._slave = os.openpty()
        self.name = os.ttyname(self._slave)
        self.url = f"serial://{self.name}?baud=921600"

    def unplug(self) -> None:
        """Take the device away."""
        for name in ("master", "_slave"):
            if (descriptor := getattr(self, name)) >= 0:
                os.close(descriptor)
                setattr(self, name, -1)


@pytest.fixture
def line() -> Iterator[Line]:
    line = Line()
    yield line
    line.unplug()


@pytest.fixture
def server() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server


def read_all(port: Port, size: int) -> bytes:
    data = b""
    while len(data) < size:
        piece = port.read(4096)
        assert piece, f"nothing more after {len(data)} of {size} bytes"
        data += piece
    return data


@every_format
def test_frames_pass_a_pty_unchanged_at_any_baud_rate(line: Line, wire: WireFormat) -> None:
    every_octet = bytes(range(256))  # no newline, flow control or parity marking may touch a byte
    for baud in (9600, 115200, 374400, 921600, 1843200, 4147200):
        port = open_port(f"serial://{line.name}?baud={baud}&format={wire.name}", timeout_s=HANG_S)
        os.write(line.master, every_octet + wire.example)
        data = read_all(port, 256 + len(wire.example))
        assert data == every_octet + wire.example
        assert len(Decoder(wire).feed(data)) == 1
        port.close()


def test_reading_returns_what_has_come_and_does_not_wait_for_more(line: Line) -> None:
    port = open_port(line.url, timeout_s=HANG_S)  # a read that waits to be full would run into the test's timeout
    os.write(line.master, b"abc")
    assert read_all(port, 3) == b"abc"
    os.write(line.master, b"defgh")
    assert port.read(2) in {b"d", b"de"}
    port.close()


def test_a_silent_line_reads_as_nothing(line: Line) -> None:
    port = open_port(line.url, timeout_s=0.01)
    assert port.read(100) == b""
    port.close()


def test_what_is_written_arrives(line: Line) -> None:
    port = open_port(line.url)
    port.write(b"log rawimusxb onnew\r\n")
    assert os.read(line.master, 100) == b"log rawimusxb onnew\r\n"
    port.close()


def test_a_port_in_use_is_busy_and_free_again_once_closed(line: Line) -> None:
    port = open_port(line.url)
    with refused(PortBusy, ErrorCode.DEVICE, port=line.name):
        open_port(line.url)
    port.close()
    port.close()
    open_port(line.url).close()


def test_a_denied_port_names_the_group(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "open", refuse_with(13))  # EACCES; the tests may run as root
    with refused(PortDenied, ErrorCode.DEVICE, "dialout", port=line.name) as caught:
        open_port(line.url)
    assert isinstance(caught.value, PermissionError)


def refuse_with(code: int) -> object:
    def refuse(path: str, *_: object) -> int:
        raise OSError(code, os.strerror(code), path)

    return refuse


def test_a_missing_port_is_reported_with_those_present(monkeypatch: pytest.MonkeyPatch) -> None:
    present = [serial_port.PortInfo("/dev/ttyUSB7", "adapter", None)]
    monkeypatch.setattr(serial_port, "list_ports", lambda: present)
    with refused(PortNotFound, ErrorCode.DEVICE, "/dev/ttyUSB7", port="/dev/ttyNOPE"):
        open_port("serial:///dev/ttyNOPE?format=counts")


@pytest.mark.parametrize("path", ["/dev/null", "/etc/passwd", "/tmp"])
def test_what_is_no_serial_line_is_reported(path: str) -> None:
    with refused(PortNotFound, ErrorCode.DEVICE, port=path) as reported:
        open_port(f"serial://{path}")
    assert str(reported.value).count(path) == 1
    assert "Errno" not in str(reported.value)


def test_an_unplugged_line_is_lost_on_read_and_on_write(line: Line) -> None:
    port = open_port(line.url)
    line.unplug()
    with refused(LinkLost, ErrorCode.DEVICE, port=line.name):
        port.read(100)
    with pytest.raises(LinkLost):
        port.write(b"x" * 100)
    port.close()


@every_format
def test_frames_pass_tcp_and_a_hang_up_is_a_lost_link(server: socket.socket, wire: WireFormat) -> None:
    port = open_port(f"tcp://127.0.0.1:{server.getsockname()[1]}?format={wire.name}", timeout_s=HANG_S)
    device, _ = server.accept()
    with device:
        device.sendall(3 * wire.example)
        assert len(Decoder(wire).feed(read_all(port, 3 * len(wire.example)))) == 3
        port.write(b"?")
        assert device.recv(10) == b"?"
    with pytest.raises(LinkLost):
        port.read(100)
    port.close()
    port.close()


def test_a_connection_reset_is_a_lost_link(server: socket.socket) -> None:
    port = open_port(f"tcp://127.0.0.1:{server.getsockname()[1]}", timeout_s=HANG_S)
    device, _ = server.accept()
    device.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
    device.close()
    with pytest.raises(LinkLost):
        port.read(100)
    port.close()


def test_a_server_that_is_not_there_is_not_found(server: socket.socket) -> None:
    number = server.getsockname()[1]
    server.close()
    with refused(PortNotFound, ErrorCode.DEVICE, str(number)):
        open_port(f"tcp://127.0.0.1:{number}")
    with pytest.raises(PortNotFound):
        open_port(f"tcp://{'a' * 70}.invalid:{number}")


def test_a_file_is_replayed_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "run.bin"
    path.write_bytes(bytes(1000))
    port = open_port(f"replay:{path}?format=counts")
    assert [len(port.read(600)), len(port.read(600))] == [600, 400]
    port.write(b"ignored")
    with refused(ReplayEnded, ErrorCode.DEVICE, path=str(path), size=1000):
        port.read(600)
    port.close()
    with pytest.raises(PortNotFound):
        open_port(f"replay:{path}x")


@pytest.fixture
def ttys(tmp_path: Path) -> Path:
    folder = tmp_path / "ttys/ttyUSB0/device"
    folder.mkdir(parents=True)
    (folder / "latency_timer").write_text("16\n")
    return tmp_path / "ttys"


def test_the_timer_is_set_to_1_ms(ttys: Path) -> None:
    assert latency_ms("/dev/ttyUSB0", ttys) == 16
    assert shorten_latency("/dev/ttyUSB0", ttys) == 1
    assert (ttys / "ttyUSB0/device/latency_timer").read_text().strip() == "1"
    assert shorten_latency("/dev/ttyUSB0", ttys) == 1


def test_a_port_without_one_is_left_alone(ttys: Path) -> None:
    assert shorten_latency("/dev/ttyS0", ttys) is None
    assert not (ttys / "ttyS0").exists()
    (ttys / "ttyUSB0/device/latency_timer").write_text("what?")
    assert shorten_latency("/dev/ttyUSB0", ttys) is None


def test_opening_a_port_sets_it(ttys: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    near, far = os.openpty()
    name = Path(os.ttyname(far)).name
    (ttys / "ttyUSB0").rename(ttys / name)
    monkeypatch.setattr(serial_port, "shorten_latency", lambda device: shorten_latency(device, ttys))
    open_port(f"serial://{os.ttyname(far)}").close()
    assert latency_ms(os.ttyname(far), ttys) == 1
    os.close(near)
    os.close(far)
