"""STIM300 against a real sensor's datagram, and what its identifiers, padding and line breaks do."""

import csv

import numpy as np
import pytest

from drivers.framing import Decoder, sniff
from drivers.wire import FORMATS, stim300
from drivers.wire.checksums import mpeg2_crc, mpeg2_is_intact
from tests.drivers.wire.captures import CAPTURES, needs_captures

WIRE = FORMATS["stim300"]
# id: bytes without CR LF, dummy bytes of the CRC (datasheet, tables 5-20 and 5-21, section 7.5.2.2)
SHEET = {
    0x90: (18, 2), 0x91: (28, 0), 0x92: (28, 0), 0x93: (38, 2), 0x94: (25, 3), 0xA5: (42, 2), 0xA6: (42, 2),
    0xA7: (59, 1), 0xF0: (22, 2), 0xF1: (32, 0), 0xF2: (32, 0), 0xF3: (42, 2), 0xF4: (29, 3), 0xF5: (46, 2),
    0xF6: (46, 2), 0xF7: (63, 1), 0xAF: (63, 1),
}  # fmt: skip


def datagram(identifier: int, counter: int = 0, **fields: object) -> bytes:
    """Return a datagram of any identifier, its CRC by the datasheet's own rule."""
    frames = np.zeros(1, stim300.KINDS[identifier].dtype)
    frames["id"], frames["counter"] = identifier, counter
    for name, value in fields.items():
        frames[name] = value
    body = frames.tobytes()[:-4]
    return body + bitwise_crc(body + bytes(-len(body) % 4)).to_bytes(4, "big")


def bitwise_crc(data: bytes) -> int:
    register = 0xFFFFFFFF
    for octet in data:
        register ^= octet << 24
        for _ in range(8):
            register = (register << 1 ^ (0x04C11DB7 if register & 0x80000000 else 0)) & 0xFFFFFFFF
    return register


@needs_captures
def test_a_real_datagram_decodes_to_its_printed_values() -> None:
    folder = CAPTURES / "stim300"
    data = (folder / "stim300_AF_datagram.bin").read_bytes()
    decoder = Decoder(WIRE)
    block = decoder.feed(data)
    assert (decoder.counters.frames, decoder.counters.skipped_bytes) == (1, 0)
    (row,) = np.frombuffer(data, stim300.FRAME)
    got: dict[str, object] = {"crc32": f"{row['crc']:08x}", "latency": row["latency"], "counter": row["counter"]}
    for name, key in (("gyro", "gyro"), ("accel", "acc10g"), ("incl", "incl")):
        got |= {f"{key}_{axis}": stim300.int24(row[name])[i] for i, axis in enumerate("xyz")}
        got[f"{key}_status"] = row[f"{name}_status"]
    for name, key in (("gyro", "gyro"), ("accel", "acc"), ("incl", "incl")):
        got |= {f"temp_{key}_{axis}": row[f"{name}_temp"][i] for i, axis in enumerate("xyz")}
        got[f"temp_{key}_status"] = row[f"{name}_temp_status"]
    got |= {"aux": stim300.int24(row["pps"]), "aux_status": row["pps_status"]}
    with (folder / "expected.csv").open(newline="") as file:
        rows = {each["field"]: each for each in csv.DictReader(file)}
    raw = {name: str(value) for name, value in got.items() if name != "aux"}
    assert raw == {name: each["raw"] for name, each in rows.items() if name != "aux"}
    assert str(got["aux"]) == rows["aux"]["value"]
    assert block.gyro.tolist() == [[292, -1322, 859]]
    assert block.accel.tolist() == [[-6234, -8906, 531538]]
    assert block.temperature[0] == pytest.approx(np.mean([35.625, 35.75, 35.625]))
    assert block.device_time[0] == 225 / 2000


@pytest.mark.parametrize("identifier", sorted(stim300.KINDS))
def test_every_identifier_has_its_length_and_is_found(identifier: int) -> None:
    kind = stim300.KINDS[identifier]
    sent = [datagram(identifier, counter=16 * i, gyro=[0, 1, i], gyro_status=i % 2) for i in range(6)]
    if identifier in SHEET:
        assert (len(sent[0]), -(len(sent[0]) - 4) % 4) == SHEET[identifier]
    for line_break in (b"", b"\r\n"):
        decoder = Decoder(WIRE)
        block = decoder.feed(line_break.join(sent) + line_break)
        assert block.gyro[:, 2].tolist() == [256 + i for i in range(6)]
        assert decoder.counters.skipped_bytes == decoder.counters.counter_jumps == 0
        assert decoder.counters.bad_status == 3
        assert decoder.kind is kind
        assert ("accel" in kind.triads) == (identifier & 7 in {1, 3, 5, 7})
        (likely,) = sniff(line_break.join(sent))
        assert (likely.format, likely.frames) == ("stim300", 6)


def test_a_line_break_cut_in_two_is_one_still() -> None:
    stream = b"\r\n".join(datagram(0x93, counter=16 * i) for i in range(4)) + b"\r\n\r"
    for cut in range(len(stream)):
        decoder = Decoder(WIRE)
        frames = len(decoder.feed(stream[:cut])) + len(decoder.feed(stream[cut:])) + len(decoder.finish())
        assert (frames, decoder.counters.skipped_bytes) == (4, 1)


def test_the_kind_may_change_on_the_way() -> None:
    block = Decoder(WIRE).feed(
        datagram(0x90, 0) + datagram(0x91, 8, accel=1) + datagram(0x91, 16) + datagram(0xA7, 24)
    )
    assert block.accel[:, 0].tolist() == [0, 0x010101, 0, 0]
    assert (block.device_time * 2000).tolist() == [0, 8, 16, 24]
    assert np.isnan(block.temperature).tolist() == [True, True, True, False]


def test_24_bits_keep_their_sign() -> None:
    octets = np.array([[0x80, 0, 0], [0x7F, 0xFF, 0xFF], [0xFF, 0xFF, 0xFF], [0, 0, 1]], dtype=np.uint8)
    assert stim300.int24(octets).tolist() == [-(2**23), 2**23 - 1, -1, 1]


def test_the_crc_is_the_bitwise_one() -> None:
    rng = np.random.default_rng(5)
    assert mpeg2_crc(b"123456789") == bitwise_crc(b"123456789") == 0x0376E6E7
    for size in range(70):
        data = rng.bytes(size)
        assert mpeg2_crc(data) == bitwise_crc(data)
        assert mpeg2_is_intact(data + bitwise_crc(data).to_bytes(4, "big"))


def test_a_temperature_with_a_bad_status_is_unknown() -> None:
    block = Decoder(WIRE).feed(datagram(0xA7, gyro_temp=5120, gyro_temp_status=1) + datagram(0xA7, gyro_temp=5120))
    assert np.isnan(block.temperature[0])
    assert block.temperature[1] == 20.0
    assert block.healthy.all()
    assert block.status[0] == 1 << 24
