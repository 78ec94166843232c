"""What a simulated autopilot sends and answers, field by field, and what faults make of its frames."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as dialect

from drivers.errors import TruthRefused
from drivers.mavlink import frames as mavlink
from drivers.simulated.companions.gnss_server import Autopilot, SimulatedFix, SimulatedReceiver
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.faults import TimedFault, gnss_faults_from
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack

GCS = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
SET_INTERVAL, REBOOT = 511, 246
ACCEPTED, DENIED, UNSUPPORTED = 0, 2, 3
EPOCH = 1_800_000_000.0


def read(data: bytes) -> list[Any]:
    reader = dialect.MAVLink(None)
    reader.robust_parsing = True
    return [each for each in reader.parse_buffer(data) or [] if each.get_type() != "BAD_DATA"]


def autopilot(*faults: TimedFault, **truth: Any) -> Autopilot:
    return Autopilot(Truth(), AutopilotTruth(epoch_utc=EPOCH, **{"default_hz": 1.0, **truth}), faults)


def last(one: Autopilot, kind: str, now: float) -> Any:
    """Return the newest of a kind among what is sent up to a time."""
    return [each for each in read(one.due(now)) if each.get_type() == kind][-1]


def command(number: int, *parameters: float, system: int = 1) -> bytes:
    rest = [0.0] * (7 - len(parameters))
    packed: bytes = GCS.command_long_encode(system, 1, number, 0, *parameters, *rest).pack(GCS)
    return packed


def answered(one: Autopilot, *commands: bytes, now: float = 0.0) -> list[tuple[int, int]]:
    return [(each.command, each.result) for each in read(one.hear(b"".join(commands), now))]


def fault(kind: str, size: float = 0.0, at_s: float = 0.0, seconds: float = 100.0) -> TimedFault:
    return TimedFault(kind, at_s, seconds, size)


def test_system_time_is_utc_and_the_time_since_boot() -> None:
    reported = last(autopilot(), "SYSTEM_TIME", 12.0)
    assert (reported.time_unix_usec, reported.time_boot_ms) == (1_800_000_012_000_000, 12_000)
    late = last(autopilot(fault("time_jump", 5.0), fault("time_jump", 2.0)), "SYSTEM_TIME", 12.0)
    assert late.time_unix_usec == 1_800_000_019_000_000
    assert last(autopilot(fault("no_fix")), "SYSTEM_TIME", 12.0).time_unix_usec == 0


def test_the_time_since_boot_restarts_after_49_days_and_after_a_reboot() -> None:
    assert last(autopilot(), "SYSTEM_TIME", 2**32 * 1e-3 + 5.0).time_boot_ms == 5000
    one = autopilot(fault("reboot", at_s=7.0, seconds=2.0))
    assert last(one, "SYSTEM_TIME", 6.0).time_boot_ms == 6000
    first = read(one.due(7.5))
    assert first[0].get_seq() == 0
    assert {each.time_boot_ms for each in first if each.get_type() == "SYSTEM_TIME"} == {0}
    assert last(one, "SYSTEM_TIME", 8.5).time_boot_ms == 1000  # once, not again while the fault lasts


def test_a_reboot_forgets_what_was_asked_for() -> None:
    one = autopilot(fault("reboot", at_s=5.0, seconds=1.0), default_hz=0.0)
    answered(one, command(SET_INTERVAL, mavlink.SYSTEM_TIME, 1e6))
    assert last(one, "SYSTEM_TIME", 4.0).time_boot_ms == 4000
    kinds = [each.get_type() for now in (5.0, 8.0) for each in read(one.due(now))]
    assert set(kinds) == {"HEARTBEAT"}


def test_a_fix_is_stamped_with_the_time_it_is_of() -> None:
    """It comes 0.1 s late, and as much later as the faults say."""
    assert last(autopilot(), "GPS_RAW_INT", 3.0).time_usec == 2_900_000
    slow = autopilot(fault("latency", 0.5), fault("latency", 0.25), latency_s=0.2)
    assert last(slow, "GPS_RAW_INT", 3.0).time_usec == 2_050_000
    utc = last(autopilot(fault("time_jump", 4.0), states_utc=True), "GPS_RAW_INT", 3.0)
    assert utc.time_usec == 1_800_000_006_900_000
    assert last(autopilot(), "GPS_RAW_INT", 0.0).time_usec == 1  # before there is any
    assert last(autopilot(), "GPS2_RAW", 3.0).time_usec == 2_900_000
    assert last(autopilot(), "GLOBAL_POSITION_INT", 3.0).time_boot_ms == 3000


def test_a_fault_of_the_receiver_is_in_its_fixes() -> None:
    there = last(autopilot(), "GLOBAL_POSITION_INT", 3.0)
    away = last(autopilot(fault("jump", 500.0), fault("jump", 500.0)), "GLOBAL_POSITION_INT", 3.0)
    metres = 6.378e6 * 1e-7 * 0.01745 * ((away.lat - there.lat) ** 2 + (away.lon - there.lon) ** 2) ** 0.5
    assert metres == pytest.approx(1000, rel=0.2)
    assert last(autopilot(), "GPS_RAW_INT", 3.0).fix_type >= 3
    assert last(autopilot(fault("no_fix")), "GPS_RAW_INT", 3.0).fix_type < 2


def test_an_interval_is_taken_up_to_the_fastest_it_can() -> None:
    one = autopilot(most_hz=16.0, denies=frozenset({mavlink.VFR_HUD}))
    asked = [
        command(SET_INTERVAL, mavlink.SYSTEM_TIME, 62_500), command(SET_INTERVAL, mavlink.SYSTEM_TIME, 62_499),
        command(SET_INTERVAL, mavlink.VFR_HUD, 1e6), command(SET_INTERVAL, 30, 1e6),
        command(SET_INTERVAL, mavlink.GPS_RAW_INT, 0), command(SET_INTERVAL, mavlink.GPS2_RAW, -1),
    ]  # fmt: skip
    results = [result for _, result in answered(one, *asked)]
    assert results == [ACCEPTED, DENIED, DENIED, DENIED, ACCEPTED, ACCEPTED]
    assert one.commands[0] == (mavlink.SYSTEM_TIME, 62_500.0, ACCEPTED)
    assert [each[2] for each in one.commands] == results
    sent = [each.get_type() for k in range(1, 33) for each in read(one.due(k / 16))]
    assert sent.count("SYSTEM_TIME") == 32
    assert sent.count("GPS_RAW_INT") == 2  # its default again
    assert sent.count("GPS2_RAW") == 0


def test_another_command_and_another_system() -> None:
    one = autopilot(system=3)
    assert answered(one, command(REBOOT, 1, system=3)) == [(REBOOT, UNSUPPORTED)]
    assert answered(one, command(SET_INTERVAL, mavlink.SYSTEM_TIME, 1e6, system=0)) == [(SET_INTERVAL, ACCEPTED)]
    assert answered(one, command(SET_INTERVAL, mavlink.SYSTEM_TIME, 1e6, system=4)) == []
    plain = autopilot(knows_intervals=False)
    assert answered(plain, command(SET_INTERVAL, mavlink.SYSTEM_TIME, 1e6)) == [(SET_INTERVAL, UNSUPPORTED)]
    assert plain.commands == []
    deaf = autopilot(fault("deaf", at_s=2.0, seconds=1.0))
    assert answered(deaf, command(SET_INTERVAL, mavlink.SYSTEM_TIME, 1e6), now=2.5) == []
    assert answered(deaf, command(SET_INTERVAL, mavlink.SYSTEM_TIME, 1e6), now=3.5) == [(SET_INTERVAL, ACCEPTED)]


def frames(one: Autopilot, times: Sequence[float]) -> list[bytes]:
    return [one.due(now) for now in times]


TIMES = [float(k) for k in range(29)]  # a heartbeat each


def test_a_bad_checksum_is_of_one_bit_behind_the_begin_of_the_frame() -> None:
    """A system that sends its heartbeat alone: frame by frame, each has one bit, not always the same, turned."""
    plain, spoilt = (frames(autopilot(*some, default_hz=0.0), TIMES) for some in ((), (fault("bad_crc"),)))
    turned = set[int]()
    for good, bad in zip(plain, spoilt, strict=True):
        assert len(good) == len(bad)
        differing = [(i, a ^ b) for i, (a, b) in enumerate(zip(good, bad, strict=True)) if a != b]
        ((at, bits),) = differing
        assert at >= 6
        assert bits.bit_count() == 1
        turned.add(bits)
    assert len(turned) > 4


def test_what_else_a_line_does_to_frames() -> None:
    (plain,) = frames(autopilot(default_hz=0.0), [0.0])
    (noise,) = frames(autopilot(fault("noise"), default_hz=0.0), [0.0])
    assert len(noise) == 4 * len(plain)
    assert read(noise) == []
    (half,) = frames(autopilot(fault("half"), default_hz=0.0), [0.0])
    assert half == plain[: len(plain) // 2]
    assert frames(autopilot(fault("repeated"), default_hz=0.0), [0.0]) == [2 * plain]
    assert frames(autopilot(fault("outage"), default_hz=0.0), [0.0]) == [b""]
    counted = read(frames(autopilot(fault("outage", at_s=2.0, seconds=1.5), default_hz=0.0), [5.0])[0])
    assert [each.get_seq() for each in counted] == [0, 1]  # of 4 and 5 s: what is older is lost


def test_a_frame_is_sent_again_up_to_twenty_frames_later() -> None:
    one = autopilot(fault("replay", at_s=23.5), default_hz=0.0)
    sent = [[each.get_seq() for each in read(data)] for data in frames(one, TIMES)]
    assert sent[23] == [23]
    assert sent[24] == [24, 5]
    assert sent[28] == [28, 9]


def test_a_backlog_is_sent_in_one_when_it_is_over() -> None:
    one = autopilot(fault("backlog", at_s=1.5, seconds=2.0), default_hz=0.0)
    sent = [[each.get_seq() for each in read(data)] for data in frames(one, TIMES[:6])]
    assert sent == [[0], [1], [], [], [2, 3, 4], [5]]


def test_signed_frames_are_signed_with_its_key_but_for_the_faults() -> None:
    key = bytes(range(100, 132))
    signed = {
        kind: frames(autopilot(*([fault(kind)] if kind else []), default_hz=0.0, key=key), [0.0])[0]
        for kind in ("", "unsigned", "wrong_key")
    }
    plain = frames(autopilot(default_hz=0.0), [0.0])[0]
    assert len(signed[""]) == len(signed["wrong_key"]) == len(plain) + 13
    assert len(signed["unsigned"]) == len(plain)
    for kind, is_right in (("", True), ("wrong_key", False)):
        reader = dialect.MAVLink(None)
        reader.signing.secret_key = key
        reader.robust_parsing = True
        (reported,) = reader.parse_buffer(signed[kind])
        assert (reported.get_type() == "HEARTBEAT") is is_right


ALL = {"HIGHRES_IMU", "GPS_RAW_INT", "GPS2_RAW", "GLOBAL_POSITION_INT", "VFR_HUD", "SYSTEM_TIME"}


def kinds(data: bytes) -> set[str]:
    return {each.get_type() for each in read(data)} - {"HEARTBEAT"}


def ask(one: Autopilot, stream: int, rate: int, start: int = 1, now: float = 0.0, system: int = 1) -> bytes:
    return one.hear(GCS.request_data_stream_encode(system, 1, stream, rate, start).pack(GCS), now)


def set_interval(one: Autopilot, number: int, interval: float, now: float = 0.0) -> int:
    command = GCS.command_long_encode(1, 1, 511, 0, number, interval, 0, 0, 0, 0, 0).pack(GCS)
    (answer,) = read(one.hear(command, now))
    return int(answer.result)


def quiet(*faults: TimedFault, **truth: Any) -> Autopilot:
    return Autopilot(Truth(), AutopilotTruth(**{"default_hz": 0.0, **truth}), faults)


@pytest.mark.parametrize(
    ("stream", "sent"),
    [
        (0, ALL),
        (1, {"HIGHRES_IMU"}),
        (2, {"GPS_RAW_INT", "GPS2_RAW"}),
        (6, {"GLOBAL_POSITION_INT"}),
        (11, {"VFR_HUD"}),
        (12, {"SYSTEM_TIME"}),
        (3, set()),
    ],
)
def test_a_stream_holds_its_messages(stream: int, sent: set[str]) -> None:
    one = quiet()
    assert ask(one, stream, 4) == b""
    assert kinds(one.due(0.24)) == set()
    assert kinds(one.due(0.25)) == sent


@pytest.mark.parametrize(("interval", "times"), [(-1.0, []), (0.0, [1500, 2000])])
def test_an_interval_of_zero_is_the_usual_one_and_a_negative_one_is_none(
    interval: float, times: list[int]
) -> None:
    one = quiet(default_hz=2.0)
    one.due(0.75)
    assert set_interval(one, mavlink.SYSTEM_TIME, interval, now=1.0) == 0
    sent = read(one.due(1.4)) + read(one.due(2.1))
    assert [each.time_boot_ms for each in sent if each.get_type() == "SYSTEM_TIME"] == times


@pytest.mark.parametrize("size", [3600.0, 256.0, -1.0, float("nan")])
def test_a_system_that_no_byte_holds_is_refused(size: float) -> None:
    with pytest.raises(TruthRefused, match=r"wrong_system size.*1 to 255"):
        gnss_faults_from([{"kind": "wrong_system", "at_s": 1, "size": size}])


@pytest.mark.parametrize("hz", [5.0, 0.0])
def test_nothing_is_due_before_the_moment_that_the_autopilot_says(hz: float) -> None:
    autopilot = Autopilot(Truth(), AutopilotTruth(default_hz=hz))
    assert autopilot.due(0.0)
    at = autopilot.next_due
    assert at == pytest.approx(1 / hz if hz else 1.0)  # the heartbeat is always sent
    assert not autopilot.due(at - 1e-6)
    assert autopilot.due(at)


TRUTH = Truth.example(7)
PILOT = AutopilotTruth(position_std_m=0.8, velocity_std_m_s=0.05, undulation_m=12.5)
FIX = SimulatedFix(55.1234567, -37.7654321, 210.25, np.array([3.0, -4.0, 1.5]), has_fix=True, autopilot=PILOT)


def test_a_fix_has_the_units_of_its_message() -> None:
    """MAVLink common.xml, GPS_RAW_INT: degE7, mm, cm/s, cdeg from North to East, mm and mm/s of accuracy."""
    m = FIX.gps_raw_int(17)
    assert (m.time_usec, m.fix_type, m.lat, m.lon) == (17, 3, 551234567, -377654321)
    assert (m.alt, m.alt_ellipsoid) == (197750, 210250)
    assert (m.eph, m.epv, m.satellites_visible) == (90, 140, 14)
    assert m.vel == 500
    assert m.cog == round((math.degrees(math.atan2(3.0, -4.0)) % 360) * 100)
    assert (m.h_acc, m.v_acc, m.vel_acc, m.hdg_acc, m.yaw) == (800, 1280, 50, 0, 0)


def test_the_global_position_is_north_east_down() -> None:
    m = FIX.global_position(5)
    assert (m.time_boot_ms, m.lat, m.lon, m.alt, m.relative_alt) == (5, 551234567, -377654321, 197750, 0)
    assert (m.vx, m.vy, m.vz, m.hdg) == (-400, 300, -150, 65535)


def test_without_a_fix_or_where_it_is_not_stated_a_field_is_unknown() -> None:
    none = SimulatedFix(1.0, 2.0, 3.0, np.zeros(3), has_fix=False, autopilot=PILOT).gps_raw_int(0)
    assert (none.fix_type, none.lat, none.lon, none.alt, none.satellites_visible) == (1, 0, 0, 0, 3)
    assert {none.eph, none.epv, none.vel, none.cog} == {65535}
    assert {none.alt_ellipsoid, none.h_acc, none.v_acc, none.vel_acc, none.hdg_acc} == {0}
    for silent in (
        AutopilotTruth(states_accuracy=False), AutopilotTruth(position_std_m=0.0),
    ):  # fmt: skip
        m = SimulatedFix(1.0, 2.0, 3.0, np.zeros(3), has_fix=True, autopilot=silent).gps_raw_int(0)
        assert (m.fix_type, m.h_acc, m.alt_ellipsoid) == (3, 0, 0)
    slow = SimulatedFix(1.0, 2.0, 3.0, np.ones(3), has_fix=True, autopilot=AutopilotTruth(states_velocity=False))
    assert (slow.gps_raw_int(0).vel, slow.gps_raw_int(0).cog) == (65535, 65535)


def test_metres_are_degrees_by_the_radii_of_the_ellipsoid() -> None:
    track = VehicleTrack(np.array([0.0, 100.0]), np.array([[0.0, 0.0, 0.0], [1000.0, 2000.0, 30.0]]))
    fix = SimulatedReceiver(TRUTH, PILOT, track, None).look(100.0, 40.0, has_fix=True)
    latitude, e2 = math.radians(TRUTH.latitude_deg), 6.69437999014e-3
    curve = math.sqrt(1 - e2 * math.sin(latitude) ** 2)
    meridian, normal = 6378137.0 * (1 - e2) / curve**3, 6378137.0 / curve
    assert math.radians(fix.latitude - TRUTH.latitude_deg) * meridian == pytest.approx(2000.0)
    east = math.radians(fix.longitude - TRUTH.longitude_deg) * normal * math.cos(latitude)
    assert east == pytest.approx(1040.0)
    assert fix.height == pytest.approx(TRUTH.height_m + 30.0)


def test_errors_have_their_sigma_and_fade_over_a_minute() -> None:
    receiver = SimulatedReceiver(TRUTH, PILOT, None, 3)
    looks = [receiver.look(30.0 * i, 0.0, has_fix=True) for i in range(6000)]
    up = np.array([each.height for each in looks]) - TRUTH.height_m
    north = np.radians(np.array([each.latitude for each in looks]) - TRUTH.latitude_deg) * 6.37e6
    assert up.std() == pytest.approx(0.8 * 1.6, rel=0.06)  # 1600 independent ones and more: 2 %
    assert north.std() == pytest.approx(0.8, rel=0.06)
    assert np.corrcoef(up[1:], up[:-1])[0, 1] == pytest.approx(math.exp(-0.5), abs=0.04)
    assert abs(np.corrcoef(up, north)[0, 1]) < 0.08
    v = np.array([each.v_n for each in looks])
    assert v.std(axis=0) == pytest.approx([0.05] * 3, rel=0.05)
    assert np.abs(v.mean(axis=0)).max() < 0.003
    first = [
        SimulatedReceiver(TRUTH, PILOT, None, seed).look(0.0, 0.0, has_fix=True).height for seed in range(400)
    ]
    assert np.std(first) == pytest.approx(1.28, rel=0.15)
