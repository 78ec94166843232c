"""Cameras' addresses are read, or refused with what was found and what would be accepted."""

import pytest

from drivers.device_url import DeviceUrl
from drivers.device_url_parser import parse_device_url
from drivers.errors import BadDeviceUrl


def camera(text: str) -> DeviceUrl:
    address = parse_device_url(text)
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


def test_a_password_is_read_and_not_told() -> None:
    address = camera("camera:http://me:p%40ss@cam:80/stream")
    assert (address.user, address.password) == ("me", "p@ss")
    assert address.public_text == "camera:http://me:***@cam:80/stream"
    assert "p%40ss" not in address.name
    assert camera("camera:http://cam/a@b:c").public_text == "camera:http://cam/a@b:c"


@pytest.mark.parametrize(
    ("text", "found"),
    [
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
