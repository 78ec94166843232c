"""An FTDI adapter's latency timer is asked down to 1 ms; ports without one are left alone."""

import os
from pathlib import Path

import pytest

from drivers import serial_port
from drivers.ports import open_port
from drivers.serial_port import latency_ms, shorten_latency


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


def test_a_link_to_the_port_is_followed(ttys: Path, tmp_path: Path) -> None:
    (tmp_path / "ttyUSB0").touch()
    (tmp_path / "imu").symlink_to(tmp_path / "ttyUSB0")
    assert shorten_latency(str(tmp_path / "imu"), ttys) == 1


def test_a_port_without_one_is_left_alone(ttys: Path) -> None:
    assert shorten_latency("/dev/ttyS0", ttys) is None
    assert not (ttys / "ttyS0").exists()
    (ttys / "ttyUSB0/device/latency_timer").write_text("what?")
    assert shorten_latency("/dev/ttyUSB0", ttys) is None


def test_one_that_may_not_be_set_is_said(ttys: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "write_text", refuse)
    assert shorten_latency("/dev/ttyUSB0", ttys) == 16


def test_opening_a_port_sets_it(ttys: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    near, far = os.openpty()
    name = Path(os.ttyname(far)).name
    (ttys / "ttyUSB0").rename(ttys / name)
    monkeypatch.setattr(serial_port, "shorten_latency", lambda device: shorten_latency(device, ttys))
    open_port(f"serial://{os.ttyname(far)}").close()
    assert latency_ms(os.ttyname(far), ttys) == 1
    os.close(near)
    os.close(far)
