"""Messages packed by pymavlink, decoded to fixes: signs and time scales against dates and directions known."""

from collections.abc import Callable
from datetime import UTC, datetime

import pytest
from pymavlink.dialects.v20 import all as dialect

from drivers.mavlink.decoder import MavlinkDecoder
from procedures.earth.gnss_records import GnssFix

Message = Callable[[dialect.MAVLink], dialect.MAVLink_message]


def fix_of(message: dialect.MAVLink_message) -> GnssFix:
    (fix,) = MavlinkDecoder(system=7).feed(message.pack(dialect.MAVLink(None, srcSystem=7, srcComponent=1)), 10**9)
    assert isinstance(fix, GnssFix)
    return fix


def gps_input(**changes: object) -> dialect.MAVLink_message:
    fields = {
        "time_usec": 1_000_000,
        "gps_id": 0,
        "ignore_flags": 0,
        "time_week_ms": 0,
        "time_week": 2300,
        "fix_type": 3,
        "lat": 311700000,
        "lon": 1214000000,
        "alt": 10.0,
        "hdop": 1.0,
        "vdop": 1.0,
        "vn": 1.0,
        "ve": 0.0,
        "vd": 2.5,
        "speed_accuracy": 0.1,
        "horiz_accuracy": 1.0,
        "vert_accuracy": 1.0,
        "satellites_visible": 9,
        "yaw": 0,
    }
    return dialect.MAVLink_gps_input_message(**(fields | changes))


def test_gps_time_is_eighteen_seconds_ahead_of_utc() -> None:
    # week 2300 begins on Sunday 2024-02-04 00:00:00 GPS: 2300 x 7 days after 1980-01-06
    assert fix_of(gps_input()).utc_ns == round(datetime(2024, 2, 3, 23, 59, 42, tzinfo=UTC).timestamp()) * 10**9


def test_what_falls_has_a_negative_upward_velocity() -> None:
    assert fix_of(gps_input(vd=2.5)).v_up == pytest.approx(-2.5)
    falling = dialect.MAVLink_global_position_int_message(
        time_boot_ms=1000, lat=311700000, lon=1214000000, alt=10000, relative_alt=0, vx=0, vy=300, vz=150, hdg=9000
    )
    fix = fix_of(falling)
    assert fix.v_up == pytest.approx(-1.5)
    assert fix.course == pytest.approx(1.5707963)  # vy is east
    assert fix.speed == pytest.approx(3.0)
