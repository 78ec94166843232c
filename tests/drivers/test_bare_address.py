"""What people type for an address works, or is refused with the one thing to type."""

import os
import pty
from pathlib import Path

import pytest

from drivers.bare_address import Role, whole_url, with_absolute_paths
from drivers.device_url_parser import parse_device_url


@pytest.mark.parametrize(
    ("typed", "role", "url"),
    [
        ("/dev/ttyUSB0", "imu", "serial:///dev/ttyUSB0"),
        ("  /dev/ttyUSB0?baud=460800&format=stim300 ", "imu", "serial:///dev/ttyUSB0?baud=460800&format=stim300"),
        ("ttyACM1", "imu", "serial:///dev/ttyACM1"),
        ("serial:/dev/ttyUSB0", "imu", "serial:///dev/ttyUSB0"),
        ("serial://dev/ttyUSB0", "imu", "serial:///dev/ttyUSB0"),
        ("serial:///dev/ttyUSB0", "imu", "serial:///dev/ttyUSB0"),
        ("imu.local:5000", "imu", "tcp://imu.local:5000"),
        ("192.168.1.7:5000?format=counts", "imu", "tcp://192.168.1.7:5000?format=counts"),
        ("[::1]:5000", "imu", "tcp://[::1]:5000"),
        ("tcp:imu.local:5000", "imu", "tcp://imu.local:5000"),
        ("tcp://imu.local:5000", "imu", "tcp://imu.local:5000"),
        ("can0", "imu", "can://socketcan/can0"),
        ("vcan1?dbc=a.dbc", "imu", "can://socketcan/vcan1?dbc=a.dbc"),
        ("can://slcan/dev/ttyACM0", "imu", "can://slcan/dev/ttyACM0"),
        ("run/recording.mcap", "imu", "replay:run/recording.mcap"),
        ("recording.mcap?format=counts", "imu", "replay:recording.mcap?format=counts"),
        ("/dev/ttyACM0", "receiver", "mavlink:serial:/dev/ttyACM0"),
        ("udp:14550", "receiver", "mavlink:udpin:127.0.0.1:14550"),
        ("udp:0.0.0.0:14550", "receiver", "mavlink:udpin:0.0.0.0:14550"),
        ("udpout:10.0.0.2:14550", "receiver", "mavlink:udpout:10.0.0.2:14550"),
        ("drone.local:5760", "receiver", "mavlink:tcp:drone.local:5760"),
        ("mavlink:tcp:127.0.0.1:5760", "receiver", "mavlink:tcp:127.0.0.1:5760"),
        ("/dev/video0", "imu", "camera:/dev/video0"),
        ("video0?size=640x480", "camera", "camera:/dev/video0?size=640x480"),
        ("http://10.0.0.2:8080/stream", "camera", "camera:http://10.0.0.2:8080/stream"),
        ("cam.local:8080/stream", "camera", "camera:http://cam.local:8080/stream"),
        ("triad:?x=/dev/ttyUSB0&y=/dev/ttyUSB1&z=/dev/ttyUSB2", "imu", None),
        ("foo", "imu", None),
    ],
)
def test_what_is_typed_becomes_a_url(typed: str, role: Role, url: str | None) -> None:
    assert whole_url(typed, role) == (url or typed)
    assert whole_url(whole_url(typed, role), role) == (url or typed)


def test_a_link_to_a_port_is_a_port_and_a_file_is_replayed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours, theirs = pty.openpty()
    (tmp_path / "imu").symlink_to(os.ttyname(theirs))
    (tmp_path / "bytes").write_bytes(b"1")
    monkeypatch.chdir(tmp_path)
    assert whole_url(f"{tmp_path}/imu?format=counts") == f"serial://{tmp_path}/imu?format=counts"
    assert whole_url("imu") == f"serial://{tmp_path}/imu"
    assert whole_url("bytes") == "replay:bytes"
    assert with_absolute_paths("bytes") == f"replay:{tmp_path}/bytes"
    for end in (ours, theirs):
        os.close(end)


def test_the_axes_of_a_triad_are_typed_likewise() -> None:
    address = parse_device_url("triad:?x=/dev/ttyUSB0&y=serial:/dev/ttyUSB1&z=imu.local:5000")
    assert [axis.scheme for axis in address.axes] == ["serial", "serial", "tcp"]


def test_an_address_keeps_the_url_that_was_made_of_it() -> None:
    address = parse_device_url("imu.local:5000")
    assert (address.text, address.host, address.port) == ("tcp://imu.local:5000", "imu.local", 5000)
