"""Each wire format through each fault of a line: what is decoded of it, and its counters; an autopilot."""

from dataclasses import asdict

import numpy as np

from drivers.can.can_format import can_format
from drivers.framing import Decoder
from drivers.mavlink.gnss_fixes import MavlinkDecoder
from drivers.mavlink.session import MavlinkSession
from drivers.simulated.companions.gnss_server import Autopilot
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.faults import KINDS, Fault, FaultyLine, TimedFault
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.vehicle_track import VehicleTrack
from drivers.wire import FORMATS, WireFormat
from tests.stored.conftest import StoredResult
from tests.stored.test_effects import TRUTH

WIRES = {**FORMATS, "can": can_format()}
FAULTS = [
    Fault(kind, 1.0 + i, every_s=9.0 if i % 2 else 0.0, count=2 + i % 3, seconds=0.25)
    for i, kind in enumerate(kind for kind in KINDS if kind not in {"stall", "unplug"})
]


def test_a_line_with_faults(stored_result: StoredResult) -> None:
    stored_result.check({name: _decoded(wire) for name, wire in WIRES.items()})


def test_an_autopilot_is_heard(stored_result: StoredResult) -> None:
    t = np.arange(0.0, 31.0, 5.0)
    track = VehicleTrack(t, np.stack((3 * t, 40 * np.sin(t / 9), 0.1 * t), axis=1))
    faults = [TimedFault("no_fix", 12.0, seconds=2.0), TimedFault("time_jump", 20.0, seconds=1.0, size=3.0)]
    reported = AutopilotTruth(
        states_utc=True, states_accuracy=False, states_velocity=False, system=7, latency_s=0.2
    )
    pilot, decoder, session = Autopilot(TRUTH, reported, faults, track, 5), MavlinkDecoder(), MavlinkSession(5.0)
    heard = list[object]()
    for step in range(300):
        now = 0.1 * step
        sent = pilot.due(now) + pilot.hear(session.due(now), now)
        session.hear(sent, now)
        heard += [{type(each).__name__: each} for each in decoder.feed(sent, round(1e9 * (now + 0.02)))]
    stored_result.check({
        "heard": heard[::40], "commands": pilot.commands, "messages": dict(decoder.messages),
        "counters": decoder.framer.counters,
    })  # fmt: skip


def _decoded(wire: WireFormat) -> dict[str, object]:
    imu, line, decoder = SimulatedImu(TRUTH, 5), FaultyLine(wire, FAULTS, TRUTH.sample_period_s, 6), Decoder(wire)
    sent, blocks = b"", list[object]()
    for part in line.send((imu.read_rates if wire.output == "rate" else imu.read)(1000)):
        if isinstance(part, bytes):
            sent += part
            blocks.append(decoder.feed(part))
    blocks.append(decoder.finish())
    return {"sent": sent, "blocks": blocks[::7], "counters": asdict(decoder.counters)}
