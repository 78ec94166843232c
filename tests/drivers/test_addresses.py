"""Addresses of devices: what people type becomes a URL, a URL is read whole, or refused by what was found."""

import os
import pty
from pathlib import Path

import pytest

from drivers.address_parsing import parse_device_url
from drivers.addresses import (
    CameraAddress,
    HttpCameraAddress,
    MavlinkAddress,
    Role,
    SerialAddress,
    TcpAddress,
    TriadAddress,
    UdpAddress,
    VideoDeviceAddress,
    host_and_port,
    whole_url,
    with_absolute_paths,
)
from drivers.errors import BadDeviceUrl
from drivers.mavlink.frames import read_key
from drivers.wire import FORMATS


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "serial:///dev/ttyUSB0?baud=460800&format=rawimusx",
            {"scheme": "serial", "path": "/dev/ttyUSB0", "baud": 460800, "format": "rawimusx"},
        ),
        ("serial:///dev/ttyUSB0?format=rawimusx", {"scheme": "serial", "path": "/dev/ttyUSB0", "baud": 230400}),
        ("serial:///dev/pts/3", {"scheme": "serial", "path": "/dev/pts/3", "baud": 921600, "format": None}),
        ("serial:///dev/x?format=ch70", {"baud": 115200, "parity": "E"}),
        ("serial:///dev/x?format=ch70&parity=N", {"baud": 115200, "parity": "N"}),
        ("serial:///dev/a%20b?parity=e", {"path": "/dev/a b", "parity": "E"}),
        ("tcp://127.0.0.1:4001?format=counts", {"scheme": "tcp", "host": "127.0.0.1", "port": 4001, "baud": None}),
        ("tcp://[::1]:4001", {"host": "::1", "port": 4001}),
        ("replay:run.bin", {"scheme": "replay", "path": "run.bin"}),
        ("replay:/tmp/run.bin?format=counts", {"path": "/tmp/run.bin", "format": "counts"}),
    ],
)
def test_a_url_is_read(text: str, expected: dict[str, object]) -> None:
    got = parse_device_url(text)
    assert {name: getattr(got, name) for name in expected} == expected
    assert got.name


@pytest.mark.parametrize(
    ("text", "accepted"),
    [
        ("", "serial:///dev/NAME, tcp://HOST:PORT or replay:FILE"),
        ("usb://1", "serial:///dev/NAME, tcp://HOST:PORT or replay:FILE"),
        ("rubbish", "/dev/NAME, HOST:PORT, can0, a file to replay"),
        ("COM3", "one of this machine, such as /dev/ttyUSB0; `station devices` lists them"),
        ("imu.local", "HOST:PORT, as in imu.local:5000"),
        ("serial:///", "three slashes"),
        ("serial:///dev/x%00", "printable"),
        ("serial:///dev/x?bud=115200", "one of baud, format, parity"),
        ("serial:///dev/x?baud=115200&baud=9600", "each option once"),
        ("serial:///dev/x?nonsense", "one of baud, format, parity"),
        ("serial:///dev/x?&", "NAME=VALUE"),
        ("serial:///dev/x?baud=fast", "a whole number from 50 to 12500000"),
        ("serial:///dev/x?baud=", "a whole number"),
        ("serial:///dev/x?baud=-1", "a whole number"),
        ("serial:///dev/x?baud=99999999", "a whole number"),
        ("serial:///dev/x?format=kvh", f"one of {', '.join(FORMATS)}"),
        ("serial:///dev/x?parity=M", "one of N, E, O"),
        ("tcp://host", "tcp://HOST:PORT"),
        ("tcp://host:0", "from 1 to 65535"),
        ("tcp://host:70000", "from 1 to 65535"),
        ("tcp://:4001", "tcp://HOST:PORT"),
        ("tcp://host:1/path", "tcp://HOST:PORT"),
        ("tcp://[::1:1", "tcp://HOST:PORT"),
        ("tcp://host:1?baud=9600", "one of format"),
        ("replay:", "replay:FILE"),
    ],
)
def test_a_mistyped_url_is_refused_naming_what_is_accepted(text: str, accepted: str) -> None:
    with pytest.raises(BadDeviceUrl) as refused:
        parse_device_url(text)
    assert accepted in str(refused.value)
    assert refused.value.url == text


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
    assert isinstance(address, TriadAddress)
    assert [axis.scheme for axis in address.axes] == ["serial", "serial", "tcp"]


def test_an_address_keeps_the_url_that_was_made_of_it() -> None:
    address = parse_device_url("imu.local:5000")
    assert isinstance(address, TcpAddress)
    assert (address.text, address.host, address.port) == ("tcp://imu.local:5000", "imu.local", 5000)


@pytest.mark.parametrize(
    ("text", "kind", "name"),
    [
        ("mavlink:udpin:0.0.0.0:14550", UdpAddress, "udpin:0.0.0.0:14550"),
        ("mavlink:udpout:localhost:14551?system=3&rate=10", UdpAddress, "udpout:localhost:14551"),
        ("mavlink:tcp:[::1]:5760", TcpAddress, "tcp:::1:5760"),
        ("mavlink:serial:/dev/ttyACM0?baud=115200", SerialAddress, "/dev/ttyACM0"),
    ],
)
def test_every_link_is_read(text: str, kind: type, name: str) -> None:
    address = parse_device_url(text)
    assert isinstance(address, MavlinkAddress)
    assert type(address.line) is kind
    assert address.name == name


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("mavlink:", "link ''"),
        ("mavlink:usb:1", "link 'usb'"),
        ("mavlink:udpin:14550", "no usable host and port"),
        ("mavlink:udpin:127.0.0.1:99999", "no usable host and port"),
        ("mavlink:serial:ttyACM0", "no device path"),
        ("mavlink:tcp:h:1?system=0", "system '0'"),
        ("mavlink:tcp:h:1?system=1&system=2", "'system' twice"),
        ("mavlink:tcp:h:1?baud=9600", "option 'baud'"),
        ("mavlink:tcp:h:1?rate=1e9", "rate '1e9'"),
        ("mavlink:tcp:h:1?key=", "an empty key"),
        ("mavlink:tcp:h:1?x", "option 'x'"),
        ("camera:", "''"),
        ("camera:video0", "'video0'"),
        ("camera:/tmp/video.avi", "'/tmp/video.avi'"),
        ("camera:/dev/", "'/dev/'"),
        ("camera:https://cam/stream", "https://"),
        ("camera:rtsp://cam/stream", "rtsp://"),
        ("camera:http:///stream", "no usable host and port"),
        ("camera:http://cam:0/", "no usable host and port"),
        ("camera:http://cam:99999/", "out of range"),
        ("camera:http://[::1/", "Invalid IPv6 URL"),
        ("camera:http://cam/stream of it", "a space"),
        ("camera:http://cam/\x00", "cannot be printed"),
        ("camera:http://cam/kamera-ü", "not ASCII"),
        ("camera:/dev/video0?size=640", "size '640'"),
        ("camera:/dev/video0?size=640x480&size=1x1", "option 'size' twice"),
        ("camera:/dev/video0?colour=1", "option 'colour'"),
        ("camera:/dev/video0?rate=nan", "rate 'nan'"),
    ],
)
def test_a_mistyped_address_is_refused_in_one_line(text: str, found: str) -> None:
    with pytest.raises(BadDeviceUrl) as caught:
        parse_device_url(text)
    assert found in str(caught.value)
    assert "expected" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_key_is_bytes_or_digits_and_never_reported(tmp_path: Path) -> None:
    key, file = bytes(range(200, 232)), tmp_path / "key"
    file.write_bytes(key)
    assert read_key(str(file)) == key
    file.write_text(key.hex() + "\n")
    assert read_key(str(file)) == key
    file.write_text("secret")
    with pytest.raises(BadDeviceUrl) as caught:
        read_key(str(file))
    assert "secret" not in str(caught.value)
    with pytest.raises(BadDeviceUrl, match="64"):
        read_key(str(tmp_path / "none"))


def camera(text: str) -> CameraAddress:
    address = parse_device_url(text)
    assert isinstance(address, HttpCameraAddress | VideoDeviceAddress)
    return address


def test_a_stream_is_read() -> None:
    address = camera("camera:http://10.0.0.7:8080/?action=stream")
    assert (address.host, address.port, address.target) == ("10.0.0.7", 8080, "/?action=stream")
    assert address.name == "10.0.0.7:8080/?action=stream"
    assert camera("camera:http://cam").port == 80
    assert camera("camera:http://[::1]:8080/stream").host == "::1"


def test_a_device_is_read() -> None:
    address = camera("camera:/dev/v4l/by-id/usb-cam?size=640x480&rate=30")
    assert (address.path, address.size, address.rate_hz) == ("/dev/v4l/by-id/usb-cam", (640, 480), 30.0)
    assert address.name == "/dev/v4l/by-id/usb-cam"


def test_a_password_is_read_and_not_reported() -> None:
    address = camera("camera:http://me:p%40ss@cam:80/stream")
    assert (address.user, address.password) == ("me", "p@ss")
    assert address.public_text == "camera:http://me:***@cam:80/stream"
    assert "p%40ss" not in address.name
    assert camera("camera:http://cam/a@b:c").public_text == "camera:http://cam/a@b:c"


@pytest.mark.parametrize(
    ("text", "found"),
    [("h:5000", ("h", 5000)), ("[::1]:5000", ("::1", 5000)), (" h:1 ", ("h", 1)), ("h:0", None), ("h:65536", None),
     ("h:0123456", None), ("h:00000099999", None), ("h:" + "9" * 5000, None), ("h:\u0663", None), (":5", None),
     ("h", None)],
)  # fmt: skip
def test_a_host_with_a_port(text: str, found: tuple[str, int] | None) -> None:
    assert host_and_port(text) == found
