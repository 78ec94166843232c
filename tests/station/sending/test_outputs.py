"""Each output by itself, by readers that share nothing with it: bytes, units, axes, and what is dropped."""

import contextlib
import json
import os
import struct

import numpy as np
import pytest
from pymavlink import mavutil

from drivers.errors import DriverError, PortBusy, PortNotFound
from station.errors import CannotWrite
from station.sending.outputs import About, BadAddress, CalibratedSamples, Output, Quality, open_outputs
from station.sending.to_stdout import MAX_WAITING, StdoutLines
from tests.free_port import free_tcp_port
from tests.patience import HANG_S, until
from tests.refusals import refused
from tests.station.sending.datagrams import listener

FRD = np.diag([1.0, -1.0, -1.0])
ABOUT = About("MODEL", "S1", "a.json", "sensor", FRD, 0.01)
DATAGRAM = struct.Struct("<4sIQdd3d3ddII")  # as docs/how-to/streaming.md says


def made(n: int, first: int = 0, seed: int = 1) -> CalibratedSamples:
    rng = np.random.default_rng(seed)
    t = 5.0 + 0.01 * np.arange(first, first + n)
    flags = np.zeros(n, dtype=np.uint32)
    flags[0] = Quality.GAP_BEFORE | Quality.SATURATED
    lost = np.zeros(n, dtype=np.int64)
    lost[0] = 3
    temperature = np.full(n, 21.5)
    temperature[1:2] = np.nan
    return CalibratedSamples(
        np.arange(first, first + n), t, np.where(np.arange(n) % 2, np.nan, t + 1.8e9), 10**18 + np.arange(n),
        9.8 * rng.standard_normal((n, 3)), rng.standard_normal((n, 3)), temperature, flags, lost,
    )  # fmt: skip


def test_a_datagram_holds_a_sample_bit_by_bit() -> None:
    samples = made(4)
    with listener() as bound:
        (output,) = open_outputs([f"udp:127.0.0.1:{bound.getsockname()[1]}"], ABOUT)
        output.send(samples)
        found = [DATAGRAM.unpack(bound.recv(4096)) for _ in range(4)]
        output.close()
    for i, (magic, flags, sequence, t, utc, *six, temperature, lost, run) in enumerate(found):
        assert (magic, flags, sequence, t) == (b"FOG1", samples.flags[i], samples.sequence[i], samples.t[i])
        assert utc == pytest.approx(samples.utc[i], rel=0, abs=0, nan_ok=True)
        assert six == [*samples.f[i].tolist(), *samples.omega[i].tolist()]
        assert temperature == pytest.approx(samples.temperature[i], nan_ok=True)
        assert (lost, run) == (samples.lost[i], found[0][-1])
    assert DATAGRAM.size == 96
    assert output.dropped == 0


def test_mavlink_has_forward_right_down_si_units_and_says_what_it_knows() -> None:
    heard = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=9)
    samples = made(2)
    (output,) = open_outputs([f"mavlink:udpout:127.0.0.1:{heard.port.getsockname()[1]}"], ABOUT)
    output.send(samples)
    received = [heard.recv_match(type="HIGHRES_IMU", blocking=True, timeout=HANG_S) for _ in range(2)]
    output.close()
    heard.close()
    for i, message in enumerate(received):
        assert message.time_usec == round(samples.t[i] * 1e6)
        f, omega = samples.f[i] * (1, -1, -1), samples.omega[i] * (1, -1, -1)
        assert [message.xacc, message.yacc, message.zacc] == np.float32(f).tolist()
        assert [message.xgyro, message.ygyro, message.zgyro] == np.float32(omega).tolist()
        assert (message.xmag, message.abs_pressure, message.id) == (0, 0, 0)
    # of the message's definition: X ACC 1, Y 2, Z 4, gyros 8, 16, 32, temperature 4096
    assert [message.fields_updated for message in received] == [0x103F, 0x003F]
    assert [message.temperature for message in received] == [21.5, 0.0]
    assert (received[0].get_srcSystem(), received[0].get_srcComponent()) == (200, 200)


def test_a_line_of_json_leaves_out_what_is_not_known() -> None:
    reading, writing = os.pipe()
    samples, output = made(2), StdoutLines(writing)
    output.send(samples)
    output.close()
    first, second = (json.loads(line) for line in os.read(reading, 65536).splitlines())
    assert first["format"] == "stream/1"
    assert first["flags"] == ["gap_before", "saturated"]
    assert (first["lost"], first["utc_s"]) == (3, samples.utc[0])
    assert [first[f"f_{axis}_m_s2"] for axis in "xyz"] == samples.f[0].tolist()
    assert [first[f"omega_{axis}_rad_s"] for axis in "xyz"] == samples.omega[0].tolist()
    assert second["flags"] == []
    assert not {"lost", "utc_s", "temperature_c"} & set(second)
    os.close(reading)
    os.close(writing)


def test_a_reader_that_does_not_read_costs_counted_samples_and_no_time() -> None:
    reading, writing = os.pipe()
    output, sent = StdoutLines(writing), 0
    while not output.dropped:
        output.send(made(100, sent))
        sent += 100
    assert sent > MAX_WAITING
    for _ in range(10):
        output.send(made(100, sent))
        sent += 100
    dropped = output.dropped
    assert f"{dropped} samples dropped" in output.status()
    lines = list[bytes]()
    with os.fdopen(reading, "rb") as pipe:
        while len(lines) < sent - dropped:
            lines.append(pipe.readline())
    sequences = [json.loads(line)["sequence"] for line in lines]
    assert sequences == list(range(sent - dropped))
    output.close()
    os.close(writing)


def test_a_reader_that_has_left_ends_the_output() -> None:
    reading, writing = os.pipe()
    output = StdoutLines(writing)
    os.close(reading)
    output.send(made(1))
    until(lambda: output.is_over)
    assert "left" in output.status()
    output.close()
    os.close(writing)


@pytest.mark.parametrize(
    ("address", "error", "reported"),
    [
        ("tcp:1.2.3.4:5", BadAddress, "foxglove"),
        ("udp:5005", BadAddress, "udp:HOST:PORT"),
        ("udp:localhost:65536", BadAddress, "udp:HOST:PORT"),
        ("udp:nowhere.invalid:5", PortNotFound, "nowhere.invalid:5"),
        ("stdout:1", BadAddress, "stdout"),
        ("mavlink:tcp:localhost:5", DriverError, "udpout"),
        ("mavlink:udpout:nowhere.invalid:5", PortNotFound, "nowhere.invalid:5"),
        ("foxglove:nowhere.invalid:5", DriverError, "nowhere.invalid:5"),
        ("foxglove:localhost", BadAddress, "foxglove:HOST:PORT"),
    ],
)
def test_an_address_that_cannot_be_used_is_one_line(address: str, error: type[Exception], reported: str) -> None:
    if address.startswith("foxglove"):
        pytest.importorskip("foxglove")
    with refused(error, None, reported) as caught:
        open_outputs([address], ABOUT)
    assert "\n" not in str(caught.value)


def test_what_was_opened_is_given_back_where_a_later_one_is_refused() -> None:
    pytest.importorskip("foxglove")
    port = free_tcp_port()
    with pytest.raises(BadAddress):
        open_outputs([f"foxglove:127.0.0.1:{port}", "nowhere"], ABOUT)
    opened = list[Output]()

    def attempt() -> None:  # the SDK's server ends a moment after it was told to
        with contextlib.suppress(PortBusy):
            opened.extend(open_outputs([f"foxglove:127.0.0.1:{port}"], ABOUT))

    until(lambda: opened, attempt)
    with refused(PortBusy, None, str(port)):
        open_outputs([f"foxglove:127.0.0.1:{port}"], ABOUT)
    opened[0].close()


def test_a_full_disk_is_no_reader_that_has_left() -> None:
    with open("/dev/full", "wb") as full:
        output = StdoutLines(full.fileno())
        output.send(made(3))
        with refused(CannotWrite, None, path="stdout"):
            output.close()
        assert not output.is_over
