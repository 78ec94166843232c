"""RAWIMUSX and RAWIMUS against frames that NovAtel's own decoder has read."""

import csv
import os
import zlib
from pathlib import Path

import numpy as np
import pytest

from drivers.framing import Decoder
from drivers.wire import FORMATS, WireFormat, novatel, rawimus, rawimusx
from procedures.records import CountBlock

ROOT = Path(__file__).parents[3]
CAPTURES = Path(os.environ.get("STATION_DATA", ROOT / "../shared/data")) / "captures/novatel_rawimu"
needs_captures = pytest.mark.skipif(not CAPTURES.is_dir(), reason=f"no captures at {CAPTURES}; set STATION_DATA")


def expected(log: str, source: str) -> list[dict[str, str]]:
    with (CAPTURES / "expected.csv").open(newline="") as file:
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
    block = decoder.feed((CAPTURES / "rawimusx_binary_good.bin").read_bytes())
    rows = expected("RAWIMUSX", "binary")
    assert_counts_are(block, rows)
    assert (decoder.counters.frames, decoder.counters.skipped_bytes) == (2, 0)
    assert decoder.model == "Epson EG320N"  # type 41, of the last frame
    assert decoder.serial is None


@needs_captures
def test_the_bad_crc_sample_is_refused() -> None:
    decoder = Decoder(FORMATS["rawimusx"])
    data = (CAPTURES / "rawimusx_binary_badcrc.bin").read_bytes()
    assert len(decoder.feed(data)) == len(decoder.finish()) == 0
    assert (decoder.counters.bad_crc, decoder.counters.skipped_bytes) == (1, len(data))


@needs_captures
def test_rawimus_agrees_with_the_manuals_ascii_example() -> None:
    block = FORMATS["rawimus"].decode(np.frombuffer(FORMATS["rawimus"].example, rawimus.FRAME))
    assert_counts_are(block, expected("RAWIMUS", "ascii")[:1])


def test_the_crc_is_novatels_and_not_zlibs() -> None:
    # The published frame's own CRC, and the bitwise definition in the manual on a short message.
    assert novatel.crc(rawimusx.FORMAT.example[:-4]) == 0xBAAF5F47
    register = 0
    for octet in b"123456789":
        register ^= octet
        for _ in range(8):
            register = register >> 1 ^ (0xEDB88320 if register & 1 else 0)
    assert novatel.crc(b"123456789") == register != zlib.crc32(b"123456789")


@pytest.mark.parametrize("wire", [rawimusx.FORMAT, rawimus.FORMAT], ids=lambda wire: wire.name)
def test_the_largest_negative_minus_y_does_not_overflow(wire: WireFormat) -> None:
    frames = np.frombuffer(wire.example, wire.frame).copy()
    frames["gyro"] = frames["accel"] = -(2**31)
    block = wire.decode(frames)
    np.testing.assert_array_equal(block.gyro, [[-(2**31), 2**31, -(2**31)]])
    np.testing.assert_array_equal(wire.decode(np.frombuffer(wire.encode(block), wire.frame)).accel, block.accel)


def test_device_time_rises_over_a_change_of_week() -> None:
    frames = np.zeros(2, rawimusx.FRAME)
    frames["week"], frames["seconds"] = [2208, 2209], [604799.995, 0.0]
    assert np.diff(rawimusx.decode(frames).device_time) == pytest.approx(0.005, abs=3e-7)


@pytest.mark.parametrize("seconds", [np.nan, np.inf, -1.0, 604800.0, 1e300])
def test_a_time_that_is_none_makes_the_frame_unhealthy(seconds: float) -> None:
    for module in (rawimusx, rawimus):
        frames = np.zeros(1, module.FRAME)
        frames["seconds"] = seconds
        block = module.decode(frames)
        assert np.isnan(block.device_time).all()
        assert not block.healthy.any()
        with pytest.raises(ValueError, match="device_time is not finite"):
            module.encode(block)


@pytest.mark.parametrize(("info", "healthy"), [(0, True), (1, False), (2, False), (4, True), (0xFC, True)])
def test_the_imu_error_and_encrypted_bits_are_read(info: int, healthy: bool) -> None:
    frames = np.zeros(1, rawimusx.FRAME)
    frames["info"] = info
    assert rawimusx.decode(frames).healthy == healthy


def test_scales_are_in_radians_and_metres_for_every_model() -> None:
    assert novatel.SCALES["KVH 1750"].gyro == pytest.approx(0.1 / 256 / 3600 * np.pi / 180, rel=1e-12)
    assert novatel.SCALES["KVH 1750"].gyro == novatel.SCALES["iMAR FSAS"].gyro
    assert novatel.SCALES["HG1700 AG58"].accel == pytest.approx(0.3048 * 2.0**-27, rel=1e-12)
    assert novatel.SCALES["ISA-100C"].rate_hz == 200  # 100 Hz here once halved every output
    assert len(novatel.SCALES) == len(novatel.MODELS)


@needs_captures
def test_gravity_comes_out_of_a_real_frame_at_the_models_scale() -> None:
    scale = novatel.SCALES["HG1700 AG58"]  # type 11: the first frame, level and at rest
    block = FORMATS["rawimusx"].decode(np.frombuffer(FORMATS["rawimusx"].example, rawimusx.FRAME))
    assert np.linalg.norm(block.accel) * scale.accel * scale.rate_hz == pytest.approx(9.8, abs=0.05)
