"""Each wire format through each fault of a line: the bytes, to the bit, and what is decoded of them."""

from dataclasses import asdict

import pytest

from drivers.can.can_format import can_format
from drivers.framing import Decoder
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.line_faults import CAN_KINDS, KINDS, Fault, FaultyLine
from drivers.wire import FORMATS, WireFormat
from tests.stored.held import assert_held
from tests.stored.simulated_truth import TRUTH

WIRES = {**FORMATS, "can": can_format()}
FAULTS = [
    Fault(kind, 1.0 + i, every_s=9.0 if i % 2 else 0.0, count=2 + i % 3, seconds=0.25)
    for i, kind in enumerate(kind for kind in KINDS if kind not in {"stall", "unplug"})
]


def through(wire: WireFormat, faults: list[Fault]) -> dict[str, object]:
    """Return the bytes of 20 s with faults in them, and what a decoder makes of them."""
    imu, line, decoder = SimulatedImu(TRUTH, 5), FaultyLine(wire, faults, TRUTH.sample_period_s, 6), Decoder(wire)
    sent, blocks = list[object](), list[object]()
    for part in line.send((imu.read_rates if wire.output == "rate" else imu.read)(1000)):
        sent.append(part)
        if isinstance(part, bytes):
            blocks.append(decoder.feed(part))
    blocks.append(decoder.finish())
    return {"sent": sent, "blocks": blocks, "counters": asdict(decoder.counters)}


@pytest.mark.parametrize("name", WIRES)
def test_a_line_with_faults(name: str) -> None:
    assert_held("devices", f"line {name}", through(WIRES[name], FAULTS))


@pytest.mark.parametrize("kind", ["stall", "unplug", *(kind for kind in CAN_KINDS if kind.startswith("frame"))])
def test_a_line_with_one_fault(kind: str) -> None:
    wire = WIRES["can"] if kind in CAN_KINDS else WIRES["counts"]
    assert_held("devices", f"fault {kind}", through(wire, [Fault(kind, 3.0, 5.0, 2, 0.5)]))
