"""CAN ports over python-can's real interfaces: slcan on a pty with an adapter of LAWICEL's kind, UDP multicast."""

import os
import socket
import time
from collections.abc import Iterator
from threading import Event

import can
import numpy as np
import pytest

from drivers.address_parsing import parse_device_url
from drivers.can import can_port, frame_record
from drivers.errors import BadDeviceUrl, LinkLost, PortBusy, PortNotFound
from drivers.framing import Decoder
from drivers.port_interface import Port
from drivers.ports import open_port, wire_of
from drivers.simulated.bench_control import BenchControl
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.lines import SlcanAdapter
from drivers.simulated.server import CAN_TRANSPORTS, SimulatedDevice
from drivers.simulated.truth import Truth
from procedures.counts.sample_records import CountBlock
from tests.drivers.can.frames import WIRE, frames_of, samples
from tests.free_port import free_udp_port
from tests.patience import HANG_S, paced, slowness

FAST = Truth(sample_period_s=0.002)
NEVER = Event()
FRAMES = frames_of(samples(5))


@pytest.fixture(autouse=True)
def slow(monkeypatch: pytest.MonkeyPatch) -> float:
    """Give an adapter, here a thread, as long to answer as this machine makes it take; return the factor."""
    slow = slowness()
    for name in ("ANSWER_S", "OPEN_ANSWER_S"):
        monkeypatch.setattr(can_port, name, getattr(can_port, name) * slow)
    return slow


@pytest.fixture
def adapter() -> Iterator[SlcanAdapter]:
    adapter = SlcanAdapter()
    adapter.plug()
    yield adapter
    adapter.unplug()


def records(port: Port, size: int) -> bytes:
    data, until = b"", time.monotonic() + HANG_S
    while len(data) < size:
        assert time.monotonic() < until, f"{len(data)} of {size} bytes"
        data += port.read(65536)
    return data


def lost(port: Port) -> str:
    until = time.monotonic() + HANG_S
    while time.monotonic() < until:
        try:
            port.read(65536)
        except LinkLost as error:
            return str(error)
    raise AssertionError("the link was not lost")


@pytest.mark.parametrize("transport", CAN_TRANSPORTS)
def test_counts_read_from_a_bus_are_those_in_memory(transport: str) -> None:
    number = free_udp_port() if transport == "udp_multicast" else 0
    with SimulatedDevice(FAST, 5, speed=paced(2.0), transport=transport, port=number, hold=True) as device:
        port, address = open_port(device.url), parse_device_url(device.url)
        with BenchControl(device.control) as hands:
            hands.place(3, 1.0)
            hands.go()
        wire = wire_of(address)
        assert wire is not None
        decoder, blocks, until = Decoder(wire), list[CountBlock](), time.monotonic() + HANG_S
        while sum(map(len, blocks)) < 600:
            assert time.monotonic() < until
            blocks.append(decoder.feed(port.read(65536)))
        port.close()
    memory = SimulatedImu(FAST, 5)
    memory.place(3, 1.0)
    expected = memory.read(sum(map(len, blocks)) + 500)
    counter = np.concatenate([block.counter for block in blocks])
    for name in ("gyro", "accel"):
        got = np.concatenate([getattr(block, name) for block in blocks])
        assert np.array_equal(got, getattr(expected, name)[counter]), name
    if transport == "slcan":  # UDP may lose, which the counter then shows
        assert counter.tolist() == list(range(len(counter)))
        assert decoder.counters.incomplete == decoder.counters.counter_jumps == 0
    assert decoder.counters.bad_crc == decoder.counters.foreign == 0
    assert np.isfinite(next(block for block in blocks if len(block)).temperature[0])


def test_frames_of_every_kind_pass_slcan_unchanged(adapter: SlcanAdapter) -> None:
    port = open_port(adapter.address)
    sent = [(0x7FF, b""), (0x1A0, bytes(range(8))), (0x1ABCDEF0 | frame_record.EXTENDED, b"\xff\x00")]
    assert adapter.write(b"".join(frame_record.pack(each, 0, data) for each, data in sent), NEVER)
    assert frame_record.unpack(records(port, 3 * 32)) == sent
    port.close()


def test_a_time_stamping_adapter_and_its_noise_do_no_harm(adapter: SlcanAdapter) -> None:
    """Lines with the adapter's time behind the data, BEL, lines that are none, octets that are no ASCII."""
    port = open_port(adapter.address)
    good = b"t1A02ABCD"
    noise = [
        b"1234\r",
        b"\r\a\a\r",
        b"\rt1A02ABX\r",
        b"\r\xff\xfe\r",
        b"\rz\rt9\r",
        b"\rt-1A0\rTFFFFFFFF0\r",
        b"\rt1A08" + b"\xc3" * 16 + b"\r",
    ]
    assert adapter.write(b"".join(good + each for each in noise) + good + b"\r", NEVER)
    got, until = list[tuple[int, bytes]](), time.monotonic() + HANG_S
    while len([each for each in got if each == (0x1A0, b"\xab\xcd")]) < 8:
        assert time.monotonic() < until, got
        got += frame_record.unpack(port.read(65536))
    assert {identifier for identifier, data in got if data != b"\xab\xcd"} <= {frame_record.ERROR}
    port.close()


def test_a_silent_bus_reads_as_nothing_while_its_adapter_answers(adapter: SlcanAdapter, slow: float) -> None:
    port = open_port(adapter.address, timeout_s=0.01)
    until = time.monotonic() + 1.0 + 0.5 * slow
    while time.monotonic() < until:
        assert port.read(1000) == b""
    port.close()


def test_an_adapter_that_stops_answering_is_a_lost_link_within_2_s(adapter: SlcanAdapter, slow: float) -> None:
    port = open_port(adapter.address)
    adapter.ails, began = "adapter_hangs", time.monotonic()
    lost(port)
    assert time.monotonic() - began < 2.0 * slow
    port.close()
    with pytest.raises(PortNotFound, match="tty_baudrate"):
        open_port(adapter.address)
    adapter.ails = ""
    open_port(adapter.address).close()


def test_bus_off_is_a_lost_link_until_the_bus_is_back(adapter: SlcanAdapter, slow: float) -> None:
    port = open_port(adapter.address)
    adapter.ails, began = "bus_off", time.monotonic()
    assert "bus-off" in lost(port)
    assert time.monotonic() - began < 2.0 * slow
    port.close()
    with pytest.raises(LinkLost, match="bus-off"):
        open_port(adapter.address)
    adapter.ails = ""
    open_port(adapter.address).close()


def test_an_unplugged_adapter_is_a_lost_link_and_leaves_no_descriptor_open(adapter: SlcanAdapter) -> None:
    port = open_port(adapter.address)
    before = len(os.listdir("/proc/self/fd"))
    adapter.unplug()
    lost(port)
    port.close()
    port.close()
    assert len(os.listdir("/proc/self/fd")) < before


def test_a_port_in_use_is_busy(adapter: SlcanAdapter) -> None:
    port = open_port(adapter.address)
    with pytest.raises(PortBusy, match="can://socketcan/slcan0"):
        open_port(adapter.address)
    port.close()
    open_port(adapter.address).close()


def test_what_is_no_adapter_is_reported() -> None:
    far, near = os.openpty()
    with pytest.raises(PortNotFound, match=os.ttyname(near)):
        open_port(f"can://slcan{os.ttyname(near)}")
    for descriptor in (far, near):
        os.close(descriptor)
    with pytest.raises(PortNotFound, match="/dev/ttyNOPE"):
        open_port("can://slcan/dev/ttyNOPE")


@pytest.mark.parametrize(
    ("url", "found"),
    [
        ("can://", "no interface"),
        ("can://slcan", "no device path"),
        ("can://slcan/dev/x?period_s=0", "period_s '0'"),
        ("can://pigeon/x", "interface 'pigeon'"),
        ("can://virtual/x?bitrat=5", "option 'bitrat'"),
        ("can://virtual/x?protocol=1&protocol=2", "option 'protocol' twice"),
    ],
)
def test_a_wrong_address_says_what_is_accepted(url: str, found: str) -> None:
    with pytest.raises(BadDeviceUrl) as refused:
        open_port(url)
    assert found in str(refused.value)
    assert refused.value.url.partition("?")[0] == url.partition("?")[0]


def test_error_frames_are_recorded_and_bus_off_ends_the_link() -> None:
    """As socketcan hands them over; python-can's virtual bus carries them too."""
    port = open_port("can://virtual/errors", timeout_s=0.2)
    with can.Bus(interface="virtual", channel="errors") as other:
        other.send(can.Message(arbitration_id=0x4, is_error_frame=True, data=bytes(8)))
        [(identifier, _)] = frame_record.unpack(records(port, 32))
        assert identifier & frame_record.ERROR
        other.send(can.Message(arbitration_id=0x40, is_error_frame=True, data=bytes(8)))
        assert "bus-off" in lost(port)
    port.close()


def test_replayed_records_are_the_samples(tmp_path: object) -> None:
    path = f"{tmp_path}/run.can"
    with open(path, "wb") as file:
        file.write(b"".join(FRAMES))
    address = parse_device_url(f"replay:{path}?format=can")
    wire = wire_of(address)
    assert wire is not None
    port = open_port(address)
    assert len(Decoder(wire).feed(port.read(10**6))) == 5
    port.close()
    assert wire.name == WIRE.name


def test_socketcan_where_the_kernel_has_it() -> None:
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError as error:
        with pytest.raises(PortNotFound, match="can0"):
            open_port("can://socketcan/can0")
        pytest.skip(f"this kernel has no CAN: {error}")
    with pytest.raises((PortNotFound, LinkLost)):
        open_port("can://socketcan/can_none")
