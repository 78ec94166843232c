"""The station's side of a link against the simulated autopilot, in memory and in their own time."""

import itertools
from collections.abc import Callable, Iterable

import pytest
from pymavlink.dialects.v20 import all as dialect

from drivers.mavlink.session import STATION, WANTED, MavlinkSession
from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.timed_faults import TimedFault
from drivers.simulated.truth import Truth

Line = Callable[[bytes, float], bytes]


def straight(data: bytes, _: float) -> bytes:
    return data


def talk(
    seconds: float, faults: Iterable[TimedFault] = (), default_hz: float = 0.0, up: Line = straight
) -> tuple[MavlinkSession, Autopilot, list[tuple[float, str]]]:
    """Return both sides after some time, and what the station said when; ``up`` is the line to the autopilot."""
    session, autopilot = MavlinkSession(5.0), Autopilot(Truth(), AutopilotTruth(default_hz=default_hz), faults)
    ear = dialect.MAVLink(None)
    said, answer, now = list[tuple[float, str]](), b"", 0.0
    while now < seconds:
        session.hear(answer + autopilot.due(now), now)
        out = up(session.due(now), now)
        for message in ear.parse_buffer(out) or ():
            assert message.get_srcSystem() == STATION
            said.append((now, message.get_type()))
        answer = autopilot.hear(out, now)
        now += 0.05
    return session, autopilot, said


def test_a_heartbeat_goes_out_each_second_whoever_listens() -> None:
    _, _, said = talk(20.0)
    times = [at for at, name in said if name == "HEARTBEAT"]
    assert len(times) == 20
    assert all(0.9 < b - a < 1.1 for a, b in itertools.pairwise(times))


def test_each_message_is_asked_for_once_and_each_answer_awaited() -> None:
    session, autopilot, said = talk(5.0)
    assert [one.outcome for one in session.asked] == ["accepted"] * len(WANTED)
    assert [number for number, _, _ in autopilot.commands] == list(WANTED)
    times = [at for at, name in said if name == "COMMAND_LONG"]
    assert all(b - a >= 0.04 for a, b in itertools.pairwise(times))


def test_what_nobody_answers_is_asked_three_times_and_then_the_old_way() -> None:
    def deaf(data: bytes, now: float) -> bytes:
        return data if now > 30.0 else b""

    session, autopilot, _ = talk(29.0, up=deaf)
    assert {one.outcome for one in session.asked} == {"no answer"}
    assert not autopilot.commands
    _, _, said = talk(60.0, up=deaf)
    assert [name for _, name in said if name == "COMMAND_LONG"]  # of heartbeats alone: it is asked anew


def test_a_lost_answer_is_asked_for_again() -> None:
    lost = list[float]()

    def lossy(data: bytes, now: float) -> bytes:
        if len(lost) < 2 and data and now > 0.2:
            lost.append(now)
            return b""
        return data

    session, _, _ = talk(12.0, up=lossy)
    assert [one.outcome for one in session.asked] == ["accepted"] * len(WANTED)


@pytest.mark.parametrize("default_hz", [0.0, 1.0])
def test_an_autopilot_that_restarted_is_asked_again(default_hz: float) -> None:
    _, autopilot, _ = talk(40.0, [TimedFault("reboot", 15.0, 1.0)], default_hz)
    asked = [number for number, _, _ in autopilot.commands]
    assert asked[len(WANTED) :][: len(WANTED)] == list(WANTED)
    assert len(asked) <= 3 * len(WANTED)  # silent of all but heartbeats, then its clock is seen to have gone back


def test_an_autopilot_that_was_away_is_asked_again() -> None:
    _, autopilot, _ = talk(40.0, [TimedFault("outage", 10.0, 8.0)])
    assert [number for number, _, _ in autopilot.commands] == 2 * list(WANTED)


@pytest.mark.parametrize("hz", [5.0, 0.0])
def test_nothing_is_due_before_the_moment_that_the_autopilot_says(hz: float) -> None:
    autopilot = Autopilot(Truth(), AutopilotTruth(default_hz=hz))
    assert autopilot.due(0.0)
    at = autopilot.next_due
    assert at == pytest.approx(1 / hz if hz else 1.0)  # the heartbeat is always sent
    assert not autopilot.due(at - 1e-6)
    assert autopilot.due(at)
