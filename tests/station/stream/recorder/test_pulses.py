"""A pulse a second at the device's input is its reference time: told by its frames, recorded, judged."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.framing import Decoder
from drivers.simulated.device import ByteDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS, PulseForm, stim300
from procedures.counts.reference_time import fit_clock
from procedures.counts.sample_records import CountBlock
from station.files.mcap_files import read_step
from station.files.mcap_files.schemas import COUNTS
from station.stream.reader import Chunk
from station.stream.recorder.accepted_step_writer import write_runs
from station.stream.recorder.sample_buffer import SampleBuffer
from station.stream.recorder.sample_stream import SampleStream
from station.stream.recorder.sample_times import PulseAges, RowTimes
from tests.drivers.wire.test_stim300 import datagram

PPM = 35.0
TRUTH = replace(Truth.example(3), effects={"clock.rate": {"value": PPM}}, sample_period_s=0.008)
WALL = 1.78e9  # s, of a station's clock that reads late and is not UTC


def pps(microseconds: int) -> np.ndarray:
    return np.frombuffer(int(microseconds % 2**24).to_bytes(3, "big"), np.uint8)


def test_the_field_is_read_in_microseconds_of_the_last_whole_datagram() -> None:
    first, last = (datagram(0xF7, pps=pps(us)) for us in (100, 998_765))
    assert stim300.pulse_age(first) == pytest.approx(100e-6)
    assert stim300.pulse_age(first + b"\r\n" + last + first[:40]) == pytest.approx(0.998765)
    for kind in (0xF0, 0xF4, 0xF5):
        assert stim300.pulse_age(datagram(kind, pps=pps(7))) == pytest.approx(7e-6)


def test_what_is_no_pulse_is_none() -> None:
    damaged = bytearray(datagram(0xF7, pps=pps(5)))
    damaged[-1] ^= 1
    for data in (
        b"",
        bytes(damaged),
        datagram(0xAF, pps=pps(5)),  # AUX of older firmware
        datagram(0xF7, pps=pps(-1)),
        datagram(0xF7, pps=pps(5), pps_status=0x80),
        datagram(0xF7, pps=pps(4_000_000)),  # the pulse went away
        datagram(0x90),
        bytes(np.random.default_rng(1).bytes(4000)),
    ):
        assert stim300.pulse_age(data) is None


def rows(seconds: float, jitter: float, *, pulsed: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return device time and reference time of a simulated device read in chunks, late by up to ``jitter`` [s]."""
    device, rng = ByteDevice(TRUTH, 3, "stim300", pps=pulsed), np.random.default_rng(2)
    decoder, form = Decoder(FORMATS["stim300"]), FORMATS["stim300"].pulse
    assert form is not None
    times, device_s, found = RowTimes(lambda ns: ns / 1e9), 0.0, list[tuple[float, float]]()
    while device_s < seconds:
        data = b"".join(sent for sent in device.chunk(7) if isinstance(sent, bytes))
        device_s += 0.008 * len(decoder.feed(data))
        read = WALL + 0.3 + device_s / (1 + PPM * 1e-6) + jitter * rng.exponential()
        utc = times.of(round(read * 1e9), device_s, form.age(data, device_s))
        if utc is not None:
            found.append((device_s, utc))
    t, u = np.array(found).T
    return t, u


def test_the_clock_is_fitted_by_pulses_to_a_sigma_that_readings_never_reach() -> None:
    by_pulses, by_reading = (fit_clock([rows(60.0, 4e-3, pulsed=pulsed)]) for pulsed in (True, False))
    assert by_pulses is not None
    assert by_reading is not None
    assert abs(by_pulses.ppm - PPM) < 4 * by_pulses.std
    assert by_pulses.std < 0.05
    assert by_pulses.std < 0.05 * by_reading.std


@pytest.mark.parametrize("size", [1, 60, 64, 96])
def test_the_pulse_is_reported_however_reads_cut_the_datagrams(size: int) -> None:
    form = FORMATS["stim300"].pulse
    data = b"".join(datagram(0xF7, pps=pps(8000 * k)) for k in range(60))
    decoder, ages, noticed = Decoder(FORMATS["stim300"]), PulseAges(form), list[float]()
    for at in range(0, len(data), size):
        block = decoder.feed(data[at : at + size])
        age = ages.of(data[at : at + size], block)
        assert (age is None) == (len(block) == 0)
        noticed += [] if age is None else [age]
    assert noticed[-1] >= 0.008 * 58
    assert np.allclose(np.diff(noticed) / 0.008, np.rint(np.diff(noticed) / 0.008))
    assert PulseAges(None).of(data, decoder.feed(data)) is None


def test_which_second_a_pulse_is_survives_late_reading_and_a_gap_in_time() -> None:
    times = RowTimes(lambda ns: ns / 1e9)
    assert times.of(round(10.9e9), 5.75, 0.75) == pytest.approx(10.75)
    assert times.of(round(12.9e9), 6.25, 0.25) == pytest.approx(11.25)  # read 1.7 s late
    assert times.of(round(13.0e9), 6.3, None) is None  # no reading next to pulses
    assert times.of(round(20.2e9), 9.37, 0.12) == pytest.approx(20.12)  # the device's time lost a part of a second
    assert times.of(round(30.0e9), 19.3, None) == pytest.approx(30.0)  # the pulse is gone for good
    assert RowTimes(None).of(round(7.6e9), 1.0, 0.5) == pytest.approx(7.5)


WEEK = 604800  # s
NOVATEL = [name for name in FORMATS if name.startswith("rawimu")]


def sample_s(name: str, data: bytes) -> float:
    return float(Decoder(FORMATS[name]).feed(data).device_time[-1])


@pytest.mark.parametrize("name", NOVATEL)
def test_a_receiver_that_knows_gps_time_gives_the_seconds_of_its_samples(name: str) -> None:
    wire = FORMATS[name]
    assert wire.pulse is not None
    at = sample_s(name, wire.example)
    assert at > 1600 * WEEK
    age = wire.pulse.age(wire.example + wire.example[:9], at)
    assert age == pytest.approx(at - np.floor(at), abs=1e-9)
    assert wire.pulse.age(wire.example, 484620.66) is None  # week 0: since it was switched on


@pytest.mark.parametrize(("name", "good", "bad"), [
    ("rawimux", b"\xb4", b"\x82"), ("rawimuxa", b"FINESTEERING", b"FREEWHEELING"),
    ("rawimu", b"\xb4", b"\x14"), ("rawimua", b"FINESTEERING", b"UNKNOWN"),
])  # fmt: skip
def test_a_time_that_the_header_calls_coarse_is_no_reference(name: str, good: bytes, bad: bytes) -> None:
    wire, at = FORMATS[name], sample_s(name, FORMATS[name].example)
    assert wire.pulse is not None
    assert wire.pulse.age(wire.example, at) is not None
    head, tail = (wire.example, b"") if name.endswith("a") else (wire.example[:14], wire.example[14:])
    assert good in (head if name.endswith("a") else head[13:])
    coarse = head.replace(good, bad) if name.endswith("a") else head[:13] + bad
    assert wire.pulse.age(coarse + tail, at) is None


@pytest.mark.parametrize("name", ["rawimusx", "rawimuxa"])
def test_a_simulated_receiver_stamps_by_true_time(name: str) -> None:
    device = ByteDevice(TRUTH, 3, name, pps=True)
    data = b"".join(sent for _ in range(500) for sent in device.chunk(7) if isinstance(sent, bytes))
    t = Decoder(FORMATS[name]).feed(data).device_time
    steps = (t[-1] - t[0]) / (len(t) - 1) * (1 + PPM * 1e-6)
    assert steps == pytest.approx(0.008, rel=3e-6)  # the unit's own clock counts its samples


def test_between_two_runs_of_a_step_the_second_is_read_again(tmp_path: Path) -> None:
    wire, stream, buffer = FORMATS["counts"], SampleStream(FORMATS["counts"]), SampleBuffer()
    none = np.zeros((10, 3), np.int64)
    for first in range(0, 200, 10):
        at = np.arange(first, first + 10)
        t = np.where(at < 100, 0.02 * at, 0.02 * at + 5.0)  # the device's clock goes on 5 s later
        one = CountBlock(at, t, none, none, np.full(10, 20.0), np.zeros(10, np.int64), np.ones(10, np.bool_))
        host_ns = round((1000.0 + 0.02 * at[-1]) * 1e9)
        buffer.append(stream.take(Chunk(host_ns, wire.encode(one))))
    pulse = PulseForm(age=lambda data, device_s: device_s % 1.0, mark=lambda block, ages: b"")
    path = tmp_path / "a.mcap"
    write_runs(path, buffer, [(0, 100), (100, 200)], COUNTS, lambda host_ns: host_ns / 1e9, pulse)
    contents = read_step(path)
    utc = contents.aux["utc_s"]
    known = np.isfinite(utc)
    assert known.sum() > 15
    assert np.abs(utc - contents.host_ns / 1e9)[known].max() < 0.6
