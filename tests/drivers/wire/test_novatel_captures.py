"""The raw IMU logs, binary and as text, against frames that NovAtel's own decoder has read."""

import csv
import zlib

import numpy as np
import pytest

from drivers.framing import Decoder, sniff
from drivers.wire import FORMATS, WireFormat, novatel_binary
from procedures.counts.sample_records import CountBlock
from tests.drivers.wire.captures import CAPTURES, needs_captures

RAWIMU = CAPTURES / "novatel_rawimu"
OTHERS = {  # messages of other kinds in each file (novatel_edie, see the captures' README): none is a raw IMU log
    "align": 12, "bestpos": 26, "ins1": 284, "ins2": 835, "rxstatus": 3, "time": 6,
}  # fmt: skip


def expected(log: str, source: str) -> list[dict[str, str]]:
    with (RAWIMU / "expected.csv").open(newline="") as file:
        return [row for row in csv.DictReader(file) if row["log"] == log and row["source"] == source]


def assert_counts_are(block: CountBlock, rows: list[dict[str, str]]) -> None:
    for channel, got in (("gyro", block.gyro), ("accel", block.accel)):
        x, minus_y, z = (
            np.array([int(row[f"{channel}_{axis}_cnt"]) for row in rows]) for axis in ("x", "minus_y", "z")
        )
        np.testing.assert_array_equal(got, np.column_stack((x, -minus_y, z)))
    np.testing.assert_array_equal(block.status, [int(row["imu_status_hex"], 16) for row in rows])
    seconds = [int(row["week"]) * 604800 + float(row["seconds"]) for row in rows]
    np.testing.assert_array_equal(block.device_time, seconds)


@needs_captures
def test_real_rawimusx_frames_decode_as_novatels_own_decoder_does() -> None:
    decoder = Decoder(FORMATS["rawimusx"])
    block = decoder.feed((RAWIMU / "rawimusx_binary_good.bin").read_bytes())
    rows = expected("RAWIMUSX", "binary")
    assert_counts_are(block, rows)
    assert (decoder.counters.frames, decoder.counters.skipped_bytes) == (2, 0)
    assert decoder.model == "Epson EG320N"  # type 41, of the last frame
    assert decoder.serial is None


@needs_captures
def test_the_bad_crc_sample_is_refused() -> None:
    decoder = Decoder(FORMATS["rawimusx"])
    data = (RAWIMU / "rawimusx_binary_badcrc.bin").read_bytes()
    assert len(decoder.feed(data)) == len(decoder.finish()) == 0
    assert (decoder.counters.bad_crc, decoder.counters.skipped_bytes) == (1, len(data))


@needs_captures
def test_rawimus_agrees_with_the_manuals_ascii_example() -> None:
    block = FORMATS["rawimus"].decode(np.frombuffer(FORMATS["rawimus"].example, FORMATS["rawimus"].frame))
    assert_counts_are(block, expected("RAWIMUS", "ascii")[:1])


@needs_captures
@pytest.mark.parametrize("name", ["rawimusxa", "rawimusa", "rawimuxa"])
def test_real_lines_decode_as_novatels_own_decoder_does(name: str) -> None:
    lines = (RAWIMU / "rawimu_ascii.txt").read_bytes()
    decoder, rows = Decoder(FORMATS[name]), expected(name.removesuffix("a").upper(), "ascii")
    assert_counts_are(decoder.feed(lines), rows)
    assert (decoder.counters.frames, decoder.counters.bad_crc) == (len(rows), 0)
    assert decoder.model == {"rawimusxa": "iMAR FSAS", "rawimusa": None, "rawimuxa": "Epson EG320N"}[name]


@needs_captures
@pytest.mark.parametrize("file", sorted(OTHERS))
def test_a_receivers_other_logs_give_no_false_frame(file: str) -> None:
    data = (CAPTURES / f"novatel_oem7/{file}.gps").read_bytes()
    assert sniff(data) == []  # not CH-70 either, whose check 80 and nine zeros pass
    for name in ("rawimusx", "rawimus", "rawimux", "rawimu", "rawimusxa", "stim300", "kvh1750"):
        decoder = Decoder(FORMATS[name])
        assert len(decoder.feed(data)) + len(decoder.finish()) == 0
        assert decoder.counters.skipped_bytes == len(data)
    assert data.count(b"\xaa\x44\x12") + data.count(b"\xaa\x44\x13") >= OTHERS[file]  # what was passed over


def test_a_line_with_other_fields_is_counted_and_refused() -> None:
    for fields in (b"1,2,3", b"00,11,1692,x,00801503,1,2,3,4,5,6", b"00,11,99999999,1.0,0,1,2,3,4,5,6"):
        body = b"RAWIMUSXA,1692,484620.664;" + fields
        decoder = Decoder(FORMATS["rawimusxa"])
        assert len(decoder.feed(b"%%%s*%08x\r\n" % (body, novatel_binary.crc(body)))) == 0
        assert decoder.counters.bad_length == 1


def test_the_crc_is_novatels_and_not_zlibs() -> None:
    # The published frame's own CRC, and the bitwise definition in the manual on a short message.
    assert novatel_binary.crc(FORMATS["rawimusx"].example[:-4]) == 0xBAAF5F47
    register = 0
    for octet in b"123456789":
        register ^= octet
        for _ in range(8):
            register = register >> 1 ^ (0xEDB88320 if register & 1 else 0)
    assert novatel_binary.crc(b"123456789") == register != zlib.crc32(b"123456789")


@pytest.mark.parametrize("wire", [FORMATS["rawimusx"], FORMATS["rawimus"]], ids=lambda wire: wire.name)
def test_the_largest_negative_minus_y_does_not_overflow(wire: WireFormat) -> None:
    frames = np.frombuffer(wire.example, wire.frame).copy()
    frames["gyro"] = frames["accel"] = -(2**31)
    block = wire.decode(frames)
    np.testing.assert_array_equal(block.gyro, [[-(2**31), 2**31, -(2**31)]])
    np.testing.assert_array_equal(wire.decode(np.frombuffer(wire.encode(block), wire.frame)).accel, block.accel)


def test_device_time_rises_over_a_change_of_week() -> None:
    frames = np.zeros(2, FORMATS["rawimusx"].frame)
    frames["week"], frames["seconds"] = [2208, 2209], [604799.995, 0.0]
    assert np.diff(FORMATS["rawimusx"].decode(frames).device_time) == pytest.approx(0.005, abs=3e-7)


@pytest.mark.parametrize("seconds", [np.nan, np.inf, -1.0, 604800.0, 1e300])
def test_a_time_that_is_none_makes_the_frame_unhealthy(seconds: float) -> None:
    for wire in (FORMATS["rawimusx"], FORMATS["rawimus"]):
        frames = np.zeros(1, wire.frame)
        frames["seconds"] = seconds
        block = wire.decode(frames)
        assert np.isnan(block.device_time).all()
        assert not block.healthy.any()
        with pytest.raises(ValueError, match="device_time"):
            wire.encode(block)


@pytest.mark.parametrize(("info", "healthy"), [(0, True), (1, False), (2, False), (4, True), (0xFC, True)])
def test_the_imu_error_and_encrypted_bits_are_read(info: int, healthy: bool) -> None:
    frames = np.zeros(1, FORMATS["rawimusx"].frame)
    frames["info"] = info
    assert FORMATS["rawimusx"].decode(frames).healthy == healthy


@needs_captures
def test_gravity_comes_out_of_a_real_frame_at_the_models_scale() -> None:
    scale = novatel_binary.SCALES["HG1700 AG58"]  # type 11: the first frame, level and at rest
    block = FORMATS["rawimusx"].decode(np.frombuffer(FORMATS["rawimusx"].example, FORMATS["rawimusx"].frame))
    assert np.linalg.norm(block.accel) * scale.accel * scale.rate_hz == pytest.approx(9.8, abs=0.05)
