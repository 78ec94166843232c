"""Messages packed by pymavlink, decoded to fixes: signs and time scales against dates and directions known."""

from collections.abc import Callable
from datetime import UTC, datetime

import pytest
from pymavlink.dialects.v20 import all as dialect

from drivers.mavlink.gnss_fixes import MavlinkDecoder, SenderClock
from procedures.gnss_records import FixType, GnssFix


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


def raw(**changes: int) -> dialect.MAVLink_message:
    fields = {
        "time_usec": 5_000_000, "fix_type": 6, "lat": 311_700_000, "lon": -1_214_000_000, "alt": 10_500, "eph": 85,
        "epv": 140, "vel": 1234, "cog": 27_000, "satellites_visible": 17, "alt_ellipsoid": 20_250, "h_acc": 1500,
        "v_acc": 2500, "vel_acc": 300, "hdg_acc": 57_295_780, "yaw": 9000,
    }  # fmt: skip
    return dialect.MAVLink_gps_raw_int_message(**(fields | changes))


def test_every_field_of_gps_raw_int_is_in_si() -> None:
    # common.xml: degE7, mm, cdeg, cm/s, DOP x 100; h_acc, v_acc, vel_acc in mm and mm/s, hdg_acc in degE5
    fix = fix_of(raw())
    degree = 0.017453292519943295
    assert (fix.source, fix.system, int(fix.fix), fix.satellites) == ("GPS_RAW_INT", 7, 6, 17)
    assert (fix.latitude, fix.longitude) == pytest.approx((31.17 * degree, -121.4 * degree), rel=1e-12)
    assert (fix.height, fix.altitude) == pytest.approx((20.25, 10.5))
    assert (fix.speed, fix.course, fix.heading) == pytest.approx((12.34, 270 * degree, 90 * degree))
    assert (fix.horizontal_std, fix.vertical_std, fix.speed_std) == pytest.approx((1.5, 2.5, 0.3))
    assert fix.heading_std == pytest.approx(10.0, rel=1e-6)  # 572.9578 deg
    assert (fix.hdop, fix.vdop) == pytest.approx((0.85, 1.4))
    assert (fix.v_up, fix.is_filtered) == (None, False)
    assert (fix.utc_ns, fix.device_ns) == (None, 5_000_000_000)  # below 1e15 us it is time since boot


def test_what_gps_raw_int_leaves_open_is_absent() -> None:
    open_fields = {"eph": 65535, "epv": 65535, "vel": 65535, "cog": 65535, "satellites_visible": 255}
    fix = fix_of(raw(**open_fields, alt_ellipsoid=0, h_acc=0, v_acc=0, vel_acc=0, hdg_acc=0, yaw=0))
    absent = ("hdop", "vdop", "speed", "course", "satellites", "height", "horizontal_std", "vertical_std",
              "speed_std", "heading_std", "heading")  # fmt: skip
    assert [name for name in absent if getattr(fix, name) is not None] == []
    assert fix_of(raw(yaw=36_000)).heading == 0.0  # north: 0 says unknown
    assert fix_of(raw(yaw=65_535)).heading is None
    assert (fix_of(raw(eph=0)).hdop, fix_of(raw(epv=0)).vdop) == (None, None)


def test_a_flat_fix_has_no_height_and_none_at_all_no_place() -> None:
    flat, none = fix_of(raw(fix_type=2)), fix_of(raw(fix_type=1))
    assert (flat.height, flat.altitude) == (None, None)
    assert flat.latitude == pytest.approx(0.5440191, abs=1e-7)
    assert flat.speed == pytest.approx(12.34)
    assert (none.latitude, none.longitude, none.speed, none.course) == (None, None, None, None)


def test_every_field_of_gps_input_is_in_si_and_its_flags_leave_out_what_they_name() -> None:
    fix = fix_of(gps_input(vn=3.0, ve=-4.0, alt=12.5, hdop=0.7, vdop=1.3, speed_accuracy=0.2, horiz_accuracy=1.1,
                           vert_accuracy=2.2, yaw=18_000, time_week_ms=1500))  # fmt: skip
    assert (fix.latitude, fix.longitude) == pytest.approx((0.5440191, 2.1188297), abs=1e-7)
    assert (fix.altitude, fix.speed) == pytest.approx((12.5, 5.0))
    assert fix.course == pytest.approx(5.3558901)  # 306.87 deg: north of west
    assert fix.heading == pytest.approx(3.1415927)
    assert (fix.horizontal_std, fix.vertical_std, fix.speed_std) == pytest.approx((1.1, 2.2, 0.2))
    assert (fix.hdop, fix.vdop) == pytest.approx((0.7, 1.3))
    assert fix.utc_ns == round(datetime(2024, 2, 3, 23, 59, 42, tzinfo=UTC).timestamp()) * 10**9 + 1_500_000_000
    # GPS_INPUT_IGNORE_FLAGS of common.xml, each with what it takes away
    for flag, names in {1: ["altitude"], 2: ["hdop"], 4: ["vdop"], 8: ["speed", "course"], 16: ["v_up"],
                        32: ["speed_std"], 64: ["horizontal_std"], 128: ["vertical_std"]}.items():  # fmt: skip
        left = fix_of(gps_input(ignore_flags=flag, yaw=18_000))
        asked = (
            "altitude",
            "hdop",
            "vdop",
            "speed",
            "course",
            "v_up",
            "speed_std",
            "horizontal_std",
            "vertical_std",
        )
        assert [name for name in asked if getattr(left, name) is None] == names


def test_a_filters_position_and_heading_are_in_si() -> None:
    reported = dialect.MAVLink_global_position_int_message(
        time_boot_ms=1500,
        lat=311700000,
        lon=1214000000,
        alt=10250,
        relative_alt=0,
        vx=300,
        vy=-400,
        vz=0,
        hdg=9000,
    )
    fix = fix_of(reported)
    assert (fix.latitude, fix.longitude) == pytest.approx((0.5440191, 2.1188297), abs=1e-7)
    assert (fix.altitude, fix.speed, fix.heading) == pytest.approx((10.25, 5.0, 1.5707963))
    assert fix.course == pytest.approx(5.3558901)
    assert (fix.device_ns, fix.is_filtered) == (1_500_000_000, True)


INT32_MAX, UINT32_MAX = 2**31 - 1, 2**32 - 1
NO_PLACES = [
    {"lat": 0, "lon": 0}, {"lat": INT32_MAX, "lon": INT32_MAX}, {"lat": 311_700_000, "lon": INT32_MAX},
    {"lat": -(2**31), "lon": 0}, {"lat": 900_000_001, "lon": 0}, {"lat": 0, "lon": -1_800_000_001},
]  # fmt: skip


def global_position(**changes: int) -> dialect.MAVLink_message:
    fields = {"time_boot_ms": 1000, "lat": 311_700_000, "lon": 1_214_000_000, "alt": 10_000,
              "relative_alt": 0, "vx": 0, "vy": 300, "vz": 150, "hdg": 9000}  # fmt: skip
    return dialect.MAVLink_global_position_int_message(**(fields | changes))


def raw2(**changes: int) -> dialect.MAVLink_message:
    fields = {"time_usec": 5_000_000, "fix_type": 3, "lat": 311_700_000, "lon": 1_214_000_000, "alt": 10_500,
              "eph": 85, "epv": 140, "vel": 0,
              "cog": 0, "satellites_visible": 17, "dgps_numch": 0, "dgps_age": 0}  # fmt: skip
    return dialect.MAVLink_gps2_raw_message(**(fields | changes))


@pytest.mark.parametrize("place", NO_PLACES)
@pytest.mark.parametrize("message", [raw, raw2, gps_input, global_position])
def test_coordinates_of_a_sender_that_has_none_are_no_position(
    message: Callable[..., dialect.MAVLink_message], place: dict[str, int]
) -> None:
    """common.xml: degE7; senders without position fill zeros (mavlink 2517, PX4 11888) or INT32_MAX."""
    fix = fix_of(message(**place))
    assert not fix.has_position
    assert (fix.latitude, fix.longitude, fix.altitude, fix.height) == (None, None, None, None)
    assert fix.fix <= FixType.NO_FIX
    assert fix.no_place


@pytest.mark.parametrize("message", [raw, raw2, gps_input, global_position])
@pytest.mark.parametrize(
    "place",
    [{"lat": 0, "lon": 1}, {"lat": 1, "lon": 0}, {"lat": 0, "lon": 1_000_000_000}, {"lat": 515_000_000, "lon": 0},
     {"lat": 900_000_000, "lon": 1_800_000_000}, {"lat": -900_000_000, "lon": -1_800_000_000}],
)  # fmt: skip
def test_the_equator_the_prime_meridian_and_the_poles_are_places(
    message: Callable[..., dialect.MAVLink_message], place: dict[str, int]
) -> None:
    fix = fix_of(message(**place))
    assert fix.has_position
    assert not fix.no_place


@pytest.mark.parametrize("message", [raw, raw2, gps_input])
def test_a_fix_of_no_satellites_is_none_but_of_a_base_that_knows_its_place(
    message: Callable[..., dialect.MAVLink_message],
) -> None:
    assert not fix_of(message(satellites_visible=0)).has_position
    assert fix_of(message(satellites_visible=255)).has_position
    assert fix_of(message(satellites_visible=0, fix_type=7)).has_position


def test_heights_and_accuracies_that_say_unknown_are_absent() -> None:
    fix = fix_of(raw(alt=INT32_MAX, alt_ellipsoid=INT32_MAX, h_acc=UINT32_MAX, v_acc=UINT32_MAX,
                     vel_acc=UINT32_MAX, hdg_acc=UINT32_MAX))  # fmt: skip
    assert fix.has_position
    names = "altitude", "height", "horizontal_std", "vertical_std", "speed_std", "heading_std"
    assert [name for name in names if getattr(fix, name) is not None] == []
    assert fix_of(global_position(alt=-(2**31))).altitude is None
    assert fix_of(gps_input(alt=float("nan"))).altitude is None


def test_directions_beyond_a_circle_are_absent() -> None:
    assert fix_of(raw(cog=36_001)).course is None
    assert fix_of(raw(yaw=40_000)).heading is None
    assert fix_of(global_position(hdg=36_001)).heading is None
    assert fix_of(gps_input(yaw=65_535)).heading is None
    assert fix_of(gps_input(yaw=36_000)).heading == 0.0


@pytest.mark.parametrize("time", [{"time_week": 0}, {"time_week": 276}, {"time_week_ms": 604_800_000}])
def test_a_gps_time_that_is_none_is_absent(time: dict[str, int]) -> None:
    """Week 276 is 2300 less two turns of ten bits, as of an old receiver: 1985."""
    assert fix_of(gps_input(**time)).utc_ns is None


def test_a_time_of_0_is_unknown() -> None:
    assert (fix_of(raw(time_usec=0)).utc_ns, fix_of(raw(time_usec=0)).device_ns) == (None, None)


S = 10**9
UTC_NS = 1_780_000_000 * S  # 2026: in microseconds beyond 1e15, so no time since boot


def test_a_stamp_is_reported_on_both_clocks_once_a_mark_has_joined_them() -> None:
    clock = SenderClock()
    assert clock.times(5_000_000) == (None, 5 * S)
    assert clock.times(UTC_NS // 1000) == (UTC_NS, None)
    assert clock.times(0) == (None, None)
    mark = clock.mark(host_ns=100 * S, boot_ns=40 * S, utc_ns=UTC_NS)
    assert (mark.host_ns, mark.device_ns, mark.utc_ns) == (100 * S, 40 * S, UTC_NS)
    assert clock.times(45_000_000) == (UTC_NS + 5 * S, 45 * S)
    assert clock.times(UTC_NS // 1000 + 3_000_000) == (UTC_NS + 3 * S, 43 * S)
    assert clock.times(1) == (UTC_NS - 40 * S + 1000, 1000)
    assert clock.times(10**15) == (UTC_NS - 40 * S + 10**18, 10**18)


def test_latency_is_what_a_message_came_later_than_the_promptest_mark() -> None:
    clock = SenderClock()
    assert clock.latency(100 * S, 40 * S) is None
    clock.mark(100 * S, 40 * S, None)
    clock.mark(102 * S - S // 2, 41 * S, None)  # half a second late
    assert clock.latency(103 * S, 42 * S + S // 4) == pytest.approx(0.75)
    assert clock.latency(103 * S, None) is None


def test_a_boot_time_that_goes_back_by_more_than_a_second_is_a_restart() -> None:
    clock = SenderClock()
    clock.mark(100 * S, 40 * S, UTC_NS)
    clock.mark(101 * S, 39 * S, None)  # out of order, no more
    assert (clock.reboots, clock.times(45_000_000)[0]) == (0, UTC_NS + 5 * S)
    clock.mark(200 * S, 2 * S, None)
    assert (clock.reboots, clock.times(45_000_000)) == (1, (None, 45 * S))
    assert clock.latency(201 * S, 2 * S) == pytest.approx(1.0)  # by the new clock alone


def test_a_boot_time_of_32_bit_that_restarts_is_no_restart() -> None:
    clock = SenderClock()
    for ms in range(2**32 - 3000, 2**32 + 3000, 1000):
        boot_ns = clock.since_boot_ns(ms % 2**32)
        assert boot_ns == ms * 10**6
        clock.mark(boot_ns + 7, boot_ns, UTC_NS + boot_ns)
        assert clock.since_boot_ns((ms - 200) % 2**32) == (ms - 200) * 10**6  # a fix of before the mark
        assert clock.times(boot_ns // 1000) == (UTC_NS + boot_ns, boot_ns)
    assert clock.reboots == 0
    boot_ns = clock.since_boot_ns(100_000)  # no mark for minutes: it was switched off and on
    assert boot_ns == 100 * S
    clock.mark(0, boot_ns, None)
    assert clock.reboots == 1
