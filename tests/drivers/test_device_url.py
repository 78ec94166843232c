"""A device's URL is read whole or refused by name."""

import pytest

from drivers.device_url import DeviceUrl
from drivers.device_url_parser import parse_device_url
from drivers.errors import BadDeviceUrl
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
    assert isinstance(got, DeviceUrl)
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
