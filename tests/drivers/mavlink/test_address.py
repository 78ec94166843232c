"""MAVLink addresses are read, or refused with what was found and what would be accepted."""

from pathlib import Path

import pytest

from drivers.device_url_parser import parse_device_url
from drivers.errors import BadDeviceUrl
from drivers.mavlink.signing import read_key


@pytest.mark.parametrize(
    ("text", "link", "where"),
    [
        ("mavlink:udpin:0.0.0.0:14550", "udpin", "0.0.0.0:14550"),
        ("mavlink:udpout:localhost:14551?system=3&rate=10", "udpout", "localhost:14551"),
        ("mavlink:tcp:[::1]:5760", "tcp", "::1:5760"),
        ("mavlink:serial:/dev/ttyACM0?baud=115200", "serial", "/dev/ttyACM0"),
    ],
)
def test_every_link_is_read(text: str, link: str, where: str) -> None:
    address = parse_device_url(text)
    assert address.link == link
    assert where in {address.path, f"{address.host}:{address.port}"}


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
    ],
)
def test_a_mistyped_address_is_refused_in_one_line(text: str, found: str) -> None:
    with pytest.raises(BadDeviceUrl) as caught:
        parse_device_url(text)
    assert found in str(caught.value)
    assert "expected" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_key_is_bytes_or_digits_and_never_said(tmp_path: Path) -> None:
    key, file = bytes(range(200, 232)), tmp_path / "key"
    file.write_bytes(key)
    assert read_key(str(file)) == key
    file.write_text(key.hex() + "\n")
    assert read_key(str(file)) == key
    file.write_text("secret")
    with pytest.raises(BadDeviceUrl) as caught:
        read_key(str(file))
    assert "secret" not in str(caught.value)
    with pytest.raises(BadDeviceUrl, match="64 hexadecimal digits"):
        read_key(str(tmp_path / "none"))
