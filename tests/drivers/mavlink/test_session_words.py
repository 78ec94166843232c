"""What a station says on a link word by word, to a system whose frames are made by hand, at moments by hand."""

from typing import Any

import pytest
from pymavlink.dialects.v20 import all as dialect

from drivers.mavlink import frames as mavlink
from drivers.mavlink.session import MavlinkSession, RequestedMessage

VEHICLE = dialect.MAVLink(None, srcSystem=7, srcComponent=3)
KEY = bytes(range(32))
IN_ORDER = ["GPS_RAW_INT", "SYSTEM_TIME", "GPS2_RAW", "GLOBAL_POSITION_INT", "VFR_HUD", "HIGHRES_IMU"]


def frame(message: dialect.MAVLink_message) -> bytes:
    """Return a message as the vehicle's next frame."""
    packed: bytes = message.pack(VEHICLE)
    VEHICLE.seq = (VEHICLE.seq + 1) % 256
    return packed


def heartbeat() -> bytes:
    return frame(VEHICLE.heartbeat_encode(2, 3, 0, 0, 4))


def answer(result: int, command: int = 511) -> bytes:
    return frame(VEHICLE.command_ack_encode(command, result))


def answers(result: int) -> bytes:
    """Return the answers to all six questions."""
    return b"".join(answer(result) for _ in IN_ORDER)


def clock(boot_ms: int) -> bytes:
    return frame(VEHICLE.system_time_encode(0, boot_ms))


def read(data: bytes) -> list[Any]:
    return list(dialect.MAVLink(None).parse_buffer(data) or ())


def reported(session: MavlinkSession, now: float) -> list[Any]:
    """Return what is sent by a moment but for heartbeats."""
    return [each for each in read(session.due(now)) if each.get_type() != "HEARTBEAT"]


def begun(rate_hz: float = 5.0, now: float = 0.0) -> MavlinkSession:
    """Return a session that has just heard its vehicle and asked the first question."""
    session = MavlinkSession(rate_hz)
    session.hear(heartbeat(), now)
    assert [each.get_type() for each in reported(session, now)] == ["COMMAND_LONG"]
    return session


def agreed(now: float = 0.0) -> MavlinkSession:
    """Return a session all of whose questions were accepted at one moment."""
    session = begun(now=now)
    session.hear(answers(0), now)
    reported(session, now)
    assert [each.outcome for each in session.asked] == ["accepted"] * 6
    return session


def test_a_question_names_the_vehicle_the_message_and_its_interval() -> None:
    session = MavlinkSession(4.0)
    session.hear(heartbeat(), 0.0)
    (one,) = reported(session, 0.0)
    assert (one.target_system, one.target_component) == (7, 3)
    assert (one.command, one.confirmation) == (511, 0)
    numbers = [getattr(one, f"param{i}") for i in range(1, 8)]
    assert numbers == [mavlink.GPS_RAW_INT, 250_000, 0, 0, 0, 0, 0]


def test_a_question_is_put_three_times_a_second_apart_and_then_the_old_way() -> None:
    session = begun(now=10.0)
    assert reported(session, 10.99) == []
    (second,) = reported(session, 11.0)
    assert (second.param1, second.confirmation) == (mavlink.GPS_RAW_INT, 1)
    assert reported(session, 11.99) == []
    (third,) = reported(session, 12.0)
    assert (third.param1, third.confirmation) == (mavlink.GPS_RAW_INT, 2)
    assert reported(session, 12.99) == []
    assert session.asked == []
    old, following = reported(session, 13.0)
    assert session.asked == [RequestedMessage("GPS_RAW_INT", 5.0, "no answer")]
    assert (old.get_type(), old.target_system, old.target_component) == ("REQUEST_DATA_STREAM", 7, 3)
    assert (old.req_stream_id, old.req_message_rate, old.start_stop) == (2, 5, 1)
    assert (following.param1, following.confirmation) == (mavlink.SYSTEM_TIME, 0)


@pytest.mark.parametrize(
    ("result", "outcome"),
    [
        (0, "accepted"),
        (1, "temporarily rejected"),
        (2, "denied"),
        (3, "unsupported"),
        (4, "failed"),
        (6, "cancelled"),
        (7, "result 7"),
        (9, "result 9"),
    ],
)
def test_an_answer_is_reported_and_what_is_refused_is_asked_the_old_way(result: int, outcome: str) -> None:
    session = begun()
    session.hear(answer(result), 0.5)
    assert session.asked == [RequestedMessage("GPS_RAW_INT", 5.0, outcome)]
    kinds = [each.get_type() for each in reported(session, 0.5)]
    assert kinds == (["COMMAND_LONG"] if result == 0 else ["REQUEST_DATA_STREAM", "COMMAND_LONG"])


def test_every_message_is_asked_for_in_order_and_in_the_stream_that_has_it() -> None:
    session = begun()
    session.hear(answers(3), 0.0)
    out = reported(session, 0.0)
    assert [each.message for each in session.asked] == IN_ORDER
    streams = [each.req_stream_id for each in out if each.get_type() == "REQUEST_DATA_STREAM"]
    assert streams == [2, 12, 2, 6, 11, 1]
    assert out[-1].get_type() == "REQUEST_DATA_STREAM"  # nothing is left to ask


@pytest.mark.parametrize(("silent_s", "is_asked"), [(4.9, False), (5.0, True)])
def test_who_was_silent_for_five_seconds_is_asked_again(silent_s: float, is_asked: bool) -> None:
    session = agreed(now=100.0)
    session.hear(heartbeat(), 100.0 + silent_s)
    assert [each.param1 for each in reported(session, 100.0 + silent_s)] == is_asked * [mavlink.GPS_RAW_INT]
    assert session.asked == [] if is_asked else len(session.asked) == 6


def test_a_system_that_restarted_is_asked_again_once() -> None:
    session = agreed()
    session.hear(clock(60_000) + heartbeat(), 1.0)
    assert reported(session, 1.0) == []
    session.hear(clock(500), 2.0)
    assert reported(session, 2.0) == []  # by its next heartbeat
    session.hear(heartbeat(), 2.5)
    assert [each.param1 for each in reported(session, 2.5)] == [mavlink.GPS_RAW_INT]
    session.hear(answers(0), 2.5)
    reported(session, 2.5)
    session.hear(heartbeat(), 3.0)
    assert reported(session, 3.0) == []


def test_with_a_key_it_signs_and_believes_only_what_is_signed() -> None:
    session = MavlinkSession(5.0, key=KEY)
    session.hear(heartbeat(), 0.0)
    out = session.due(0.0)
    reader = dialect.MAVLink(None)
    reader.signing.secret_key = KEY
    (first,) = reader.parse_buffer(out)  # and no question: nobody was heard
    assert (first.get_type(), first.get_signed()) == ("HEARTBEAT", True)
    assert int.from_bytes(out[-12:-6], "little") > 10**13  # ten microseconds since 2015
    other = dialect.MAVLink(None, srcSystem=7, srcComponent=3)
    other.signing.secret_key, other.signing.sign_outgoing = KEY, True
    other.signing.timestamp = 2**47  # long after any day of this test
    session.hear(other.heartbeat_encode(2, 3, 0, 0, 4).pack(other), 0.0)
    (question,) = reader.parse_buffer(session.due(0.0))
    assert (question.get_type(), question.get_signed()) == ("COMMAND_LONG", True)
    assert not read(MavlinkSession(5.0).due(0.0))[0].get_signed()
