"""What an IMU tells others, datagram by datagram, read by pymavlink on a socket of loopback."""

import math
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import all as dialect

from drivers.address_parsing import parse_mavlink_url
from drivers.mavlink.imu_out import ImuOut
from drivers.network_ports import open_udp
from tests.patience import HANG_S

KEY = bytes(range(32))
ACCELEROMETER, GYROSCOPE, TEMPERATURE = 0b111, 0b111000, 1 << 12  # HIGHRES_IMU_UPDATED_FLAGS
F, W = (0.5, -1.5, -9.75), (0.25, -0.125, 2.0)


class Station:
    """Who listens, and the clock of who sends."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(HANG_S)
        self.port: int = self.socket.getsockname()[1]
        self.now = 50.0
        self.out: list[ImuOut] = []

    def hears(self, options: str = "") -> ImuOut:
        """Return a sender to this station."""
        address = parse_mavlink_url(f"mavlink:udpout:127.0.0.1:{self.port}{options}")
        sender = ImuOut(address, open_udp("127.0.0.1", self.port, 0.0, listens=False), lambda: self.now)
        self.out.append(sender)
        return sender

    def datagram(self) -> bytes:
        return self.socket.recv(65535)

    def message(self) -> Any:
        (one,) = dialect.MAVLink(None).parse_buffer(self.datagram())
        return one

    def is_sent_nothing(self) -> bool:
        """Say whether nothing has come; on loopback what was sent is there at once."""
        self.socket.setblocking(False)
        try:
            self.socket.recv(65535)
        except BlockingIOError:
            return True
        finally:
            self.socket.settimeout(HANG_S)
        return False


@pytest.fixture
def station() -> Iterator[Station]:
    one = Station()
    yield one
    one.socket.close()
    for sender in one.out:
        sender.close()


def test_its_heartbeat_is_an_imus_once_a_second(station: Station) -> None:
    out = station.hears()
    out.keep_up()
    first = station.message()
    assert (first.get_srcSystem(), first.get_srcComponent()) == (200, 200)
    assert (first.type, first.autopilot, first.base_mode, first.custom_mode, first.system_status) == (
        0,
        8,
        0,
        0,
        4,
    )
    station.now += 0.99
    out.keep_up()
    assert station.is_sent_nothing()
    station.now = 51.0
    out.keep_up()
    assert station.message().get_type() == "HEARTBEAT"
    out.keep_up()
    assert station.is_sent_nothing()


@pytest.mark.parametrize(("t", "boot_ms"), [(1.2344, 1234), (1.2346, 1235), (2**32 * 1e-3 + 5.0, 5000)])
def test_an_attitude_is_sent_after_the_heartbeat(t: float, boot_ms: int, station: Station) -> None:
    station.hears().attitude(t, 0.25, -0.5, W, 1.5)
    assert station.message().get_type() == "HEARTBEAT"
    reported = station.message()
    assert reported.time_boot_ms == boot_ms
    assert (reported.roll, reported.pitch, reported.yaw) == (0.25, -0.5, 1.5)
    assert (reported.rollspeed, reported.pitchspeed, reported.yawspeed) == W


NONE = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("force", "rate", "temperature", "updated"),
    [
        (F, W, 31.5, ACCELEROMETER | GYROSCOPE | TEMPERATURE),
        (F, W, math.nan, ACCELEROMETER | GYROSCOPE),
        (F, (0.25, math.nan, 2.0), math.nan, ACCELEROMETER),
        ((0.5, -1.5, math.inf), W, math.nan, GYROSCOPE),
        ((math.nan,) * 3, (math.nan,) * 3, 31.5, TEMPERATURE),
    ],
)
def test_what_is_not_measured_is_zero_and_not_among_the_fields(
    force: tuple[float, float, float],
    rate: tuple[float, float, float],
    temperature: float,
    updated: int,
    station: Station,
) -> None:
    station.hears().highres(12.3456789, force, rate, temperature)
    reported = station.message()
    assert (reported.get_type(), reported.time_usec, reported.fields_updated) == (
        "HIGHRES_IMU",
        12_345_679,
        updated,
    )
    assert (reported.xacc, reported.yacc, reported.zacc) == (F if updated & ACCELEROMETER else NONE)
    assert (reported.xgyro, reported.ygyro, reported.zgyro) == (W if updated & GYROSCOPE else NONE)
    assert reported.temperature == (31.5 if updated & TEMPERATURE else 0.0)
    others = "xmag", "ymag", "zmag", "abs_pressure", "diff_pressure", "pressure_alt"
    assert [getattr(reported, name) for name in others] == [0.0] * 6


def test_frames_are_signed_with_the_key_of_the_address(station: Station, tmp_path: Path) -> None:
    (tmp_path / "key").write_bytes(KEY)
    station.hears(f"?key={tmp_path / 'key'}").keep_up()
    data = station.datagram()
    reader = dialect.MAVLink(None)
    reader.signing.secret_key = KEY
    (reported,) = reader.parse_buffer(data)
    assert reported.get_type() == "HEARTBEAT"
    assert reported.get_signed()
    assert int.from_bytes(data[-12:-6], "little") > 10**13  # ten microseconds since 2015
    station.hears().keep_up()
    assert not station.message().get_signed()
