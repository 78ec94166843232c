"""A simulated autopilot sends what it is asked for, as often, and until it is told to stop."""

from collections import Counter

from pymavlink.dialects.v20 import all as dialect

from drivers.mavlink import messages as mavlink
from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.truth import Truth

GCS = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
POSITION = 6  # the stream of GLOBAL_POSITION_INT


def sent(autopilot: Autopilot, begin_s: float, end_s: float) -> Counter[int]:
    """Return how many of each message come in a time, which is looked at every 10 ms."""
    data = b"".join(autopilot.due(0.01 * k) for k in range(round(100 * begin_s), round(100 * end_s)))
    return Counter(each.get_msgId() for each in dialect.MAVLink(None).parse_buffer(data) or ())


def ask(autopilot: Autopilot, now: float, stream: int, rate: int, start: int, system: int = 1) -> None:
    message = GCS.request_data_stream_encode(system, 1, stream, rate, start)
    autopilot.hear(message.pack(GCS), now)


def test_a_stream_comes_as_often_as_it_was_asked_for_and_ends_when_it_is_stopped() -> None:
    autopilot = Autopilot(Truth(), AutopilotTruth(default_hz=1.0))
    ask(autopilot, 0.0, POSITION, 5, 1)
    first = sent(autopilot, 0.0, 4.0)
    assert first[mavlink.GLOBAL_POSITION_INT] in {19, 20, 21}
    assert first[mavlink.VFR_HUD] == first[mavlink.HEARTBEAT] == 4
    ask(autopilot, 4.0, POSITION, 5, 0)
    ask(autopilot, 4.0, 0, 2, 1, system=7)  # another's
    second = sent(autopilot, 4.0, 8.0)
    assert second[mavlink.GLOBAL_POSITION_INT] == 0
    assert second[mavlink.VFR_HUD] == 4
    ask(autopilot, 8.0, 0, 0, 0)  # every stream
    assert {*sent(autopilot, 8.0, 12.0)} == {mavlink.HEARTBEAT}
