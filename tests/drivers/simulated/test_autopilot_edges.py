"""A simulated autopilot at its limits: frame numbers, the times of its fixes, each stream by its number."""

from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as dialect

from drivers.mavlink import messages as mavlink
from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.timed_faults import TimedFault
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack

GCS = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
ALL = {"HIGHRES_IMU", "GPS_RAW_INT", "GPS2_RAW", "GLOBAL_POSITION_INT", "VFR_HUD", "SYSTEM_TIME"}


def read(data: bytes) -> list[Any]:
    return list(dialect.MAVLink(None).parse_buffer(data) or ())


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


def test_frames_are_numbered_up_to_a_byte() -> None:
    one = quiet()
    assert [read(one.due(float(now)))[0].get_seq() for now in range(258)] == [*range(256), 0, 1]


def test_a_turned_bit_may_be_any_behind_the_begin_of_the_frame() -> None:
    plain, spoilt = quiet(), quiet(TimedFault("bad_crc", 0.0, 1e6))
    places, bits = set[int](), set[int]()
    for now in range(600):
        good, bad = plain.due(float(now)), spoilt.due(float(now))
        ((at, turned),) = [(i, a ^ b) for i, (a, b) in enumerate(zip(good, bad, strict=True)) if a != b]
        places.add(at)
        bits.add(turned)
        size = len(good)
    assert places == set(range(6, size))
    assert bits == {1 << i for i in range(8)}


def test_equal_seeds_give_equal_bytes_and_others_do_not() -> None:
    noisy = TimedFault("noise", 0.0, 10.0)
    sent = [Autopilot(Truth(), AutopilotTruth(), [noisy], seed=seed).due(0.0) for seed in (1, 1, 2, None, 0)]
    assert sent[0] == sent[1] != sent[2]
    assert sent[3] == sent[4]


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


@pytest.mark.parametrize(("system", "is_heard"), [(0, True), (1, True), (2, False)])
def test_a_stream_is_asked_of_one_system_or_of_all(system: int, is_heard: bool) -> None:
    one = quiet()
    ask(one, 12, 4, system=system)
    assert kinds(one.due(0.25)) == ({"SYSTEM_TIME"} if is_heard else set())


def test_two_requests_in_one_read_are_both_obeyed() -> None:
    one = quiet()
    asked = [GCS.request_data_stream_encode(1, 1, stream, 2, 1).pack(GCS) for stream in (11, 12)]
    one.hear(b"".join(asked), 1.0)
    assert kinds(one.due(1.5)) == {"VFR_HUD", "SYSTEM_TIME"}


def test_noise_before_a_request_does_no_harm() -> None:
    one = quiet()
    one.hear(b"\x00\xff\x55" + GCS.request_data_stream_encode(1, 1, 12, 2, 1).pack(GCS), 0.0)
    assert kinds(one.due(0.5)) == {"SYSTEM_TIME"}


def test_an_interval_is_in_microseconds_and_begins_when_it_is_set() -> None:
    one = quiet()
    assert set_interval(one, mavlink.SYSTEM_TIME, 250_000, now=1.0) == 0
    one.due(1.0)
    assert one.next_due == 1.25
    assert [each.time_boot_ms for each in read(one.due(1.75)) if each.get_type() == "SYSTEM_TIME"] == [
        1250,
        1500,
        1750,
    ]


@pytest.mark.parametrize(("interval", "times"), [(-1.0, []), (0.0, [1500, 2000])])
def test_an_interval_of_nought_is_the_usual_one_and_a_negative_one_is_none(
    interval: float, times: list[int]
) -> None:
    one = quiet(default_hz=2.0)
    one.due(0.75)
    assert set_interval(one, mavlink.SYSTEM_TIME, interval, now=1.0) == 0
    sent = read(one.due(1.4)) + read(one.due(2.1))
    assert [each.time_boot_ms for each in sent if each.get_type() == "SYSTEM_TIME"] == times


def test_messages_go_out_in_the_order_in_which_they_are_due() -> None:
    one = quiet()
    ask(one, 12, 4, now=0.0)
    ask(one, 11, 4, now=-0.125)
    one.due(0.0)
    sent = [each.get_type() for each in read(one.due(0.25))]
    assert sent == ["VFR_HUD", "SYSTEM_TIME"]


def test_an_imu_without_values_says_noughts() -> None:
    (said,) = [
        each for each in read(Autopilot(Truth(), AutopilotTruth()).due(0.0)) if each.get_type() == "HIGHRES_IMU"
    ]
    names = "xacc yacc zacc xgyro ygyro zgyro xmag ymag zmag abs_pressure diff_pressure pressure_alt"
    assert [getattr(said, name) for name in names.split()] == [0.0] * 12


def test_an_airspeed_stands_alone() -> None:
    (said,) = [
        each for each in read(Autopilot(Truth(), AutopilotTruth()).due(0.0)) if each.get_type() == "VFR_HUD"
    ]
    assert (said.groundspeed, said.heading, said.throttle, said.alt, said.climb) == (0.0, 0, 0, 0.0, 0.0)


@pytest.mark.parametrize(("latency_s", "now", "north_m"), [(0.0, 8.0, 800.0), (2.0, 8.0, 600.0), (2.0, 1.0, 0.0)])
def test_a_fix_is_of_the_place_where_it_was_a_latency_ago(latency_s: float, now: float, north_m: float) -> None:
    """It goes north by 100 m each second."""
    track = VehicleTrack(np.array([0.0, 100.0]), np.array([[0.0, 0.0, 0.0], [0.0, 10_000.0, 0.0]]))
    truth = AutopilotTruth(latency_s=latency_s, position_std_m=0.0)
    one = Autopilot(Truth(), truth, track=track)
    (said,) = [each for each in read(one.due(now)) if each.get_type() == "GLOBAL_POSITION_INT"][-1:]
    north = np.radians(said.lat * 1e-7 - Truth().latitude_deg) * 6.37e6
    assert north == pytest.approx(north_m, rel=0.01, abs=1.0)


def test_a_reboot_is_one_for_each_fault() -> None:
    one = quiet(TimedFault("reboot", 2.0, 1.0), TimedFault("reboot", 5.0, 1.0), default_hz=1.0)
    found = list[list[int]]()
    for now in (1.0, 2.0, 4.0, 5.0, 6.0):
        found.append([each.time_boot_ms for each in read(one.due(now)) if each.get_type() == "SYSTEM_TIME"])
    assert found == [[0, 1000], [0], [1000, 2000], [0], [1000]]


def test_a_replay_is_of_the_first_frame_while_there_are_not_twenty() -> None:
    one = quiet(TimedFault("replay", 0.0, 1e6))
    assert [[each.get_seq() for each in read(one.due(float(now)))] for now in range(22)][-4:] == [
        [18, 0], [19, 0], [20, 1], [21, 2],
    ]  # fmt: skip
