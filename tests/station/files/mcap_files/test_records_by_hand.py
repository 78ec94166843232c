"""An MCAP file's records, from files put together byte by byte as the specification lays them out."""

import struct
import zlib
from pathlib import Path

import pytest
from mcap.records import Channel, Schema, Statistics

from station.files.mcap_files.records import UNSYNCED, CutShort, Message, Record, file_records

MAGIC = b"\x89MCAP0\r\n"
LARGEST = 2**28


def record(opcode: int, content: bytes = b"") -> bytes:
    return struct.pack("<BQ", opcode, len(content)) + content


def text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def message(channel: int, data: bytes) -> bytes:
    return record(5, struct.pack("<HIQQ", channel, 1, 2, 3) + data)


def chunk(records: bytes, size: int | None = None, crc: int | None = None) -> bytes:
    """Return an uncompressed chunk, its size and checksum right unless others are given."""
    size, crc = len(records) if size is None else size, zlib.crc32(records) if crc is None else crc
    head = struct.pack("<QQQI", 0, 0, size, crc) + text("")
    return record(6, head + struct.pack("<Q", len(records)) + records)


HEADER = record(1, text("") + text(""))
SCHEMA = record(3, struct.pack("<H", 9) + text("S") + text("x") + struct.pack("<I", 0))
CHANNEL = record(4, struct.pack("<HH", 258, 9) + text("/t") + text("raw") + struct.pack("<I", 0))
STATISTICS = record(11, struct.pack("<QHIIIIQQI", 42, 1, 1, 0, 0, 0, 0, 0, 0))
DATA = HEADER + SCHEMA + CHANNEL + message(258, b"abc") + message(1, b"")


def data_end(data: bytes, crc: int | None = None) -> bytes:
    return record(15, struct.pack("<I", zlib.crc32(MAGIC + data) if crc is None else crc))


def footer(index: bytes, crc: int | None = None) -> bytes:
    begin = struct.pack("<BQQQ", 2, 20, 0, 0)
    return begin + struct.pack("<I", zlib.crc32(index + begin) if crc is None else crc)


def finished(
    data: bytes = DATA, index: bytes = STATISTICS, *, crc: int | None = None, of: int | None = None
) -> bytes:
    """Return a whole file; ``crc`` is that of its data, ``of`` that of its index, right unless given."""
    return MAGIC + data + data_end(data, crc) + index + footer(index, of) + MAGIC


def read(folder: Path, content: bytes) -> tuple[list[Record], Exception | None]:
    """Return the records of a file until it ends or is refused, and by what."""
    path, found = folder / "a.mcap", list[Record]()
    path.write_bytes(content)
    with path.open("rb") as stream:
        try:
            for each in file_records(stream):
                found.append(each)
        except Exception as error:
            return found, error
    return found, None


def kinds(records: list[Record]) -> list[type]:
    return [type(each) for each in records]


def test_schemas_channels_messages_and_statistics_are_read_in_their_order(tmp_path: Path) -> None:
    found, error = read(tmp_path, finished())
    assert error is None
    assert kinds(found) == [Schema, Channel, Message, Message, Statistics]
    assert found[2:4] == [Message(258, b"abc"), Message(1, b"")]
    assert isinstance(found[4], Statistics)
    assert found[4].message_count == 42


def test_a_chunk_holds_records_as_the_file_does(tmp_path: Path) -> None:
    inside = SCHEMA + CHANNEL + message(258, b"abc") + record(200, b"z") + message(65535, b"de")
    found, error = read(tmp_path, finished(HEADER + chunk(inside) + chunk(b"") + message(2, b"f"), b""))
    assert error is None
    assert kinds(found[:2]) == [Schema, Channel]
    assert found[2:] == [Message(258, b"abc"), Message(65535, b"de"), Message(2, b"f")]


@pytest.mark.parametrize("content", [finished(crc=0), finished(of=0), finished(crc=0, of=0), finished(index=b"")])
def test_a_checksum_of_zero_is_none(content: bytes, tmp_path: Path) -> None:
    found, error = read(tmp_path, content)
    assert error is None
    assert found[2:4] == [Message(258, b"abc"), Message(1, b"")]


def test_a_wrong_checksum_of_the_data_is_reported_after_them(tmp_path: Path) -> None:
    found, error = read(tmp_path, finished(crc=1))
    assert isinstance(error, ValueError)
    assert not isinstance(error, CutShort)
    assert len(found) == 4


@pytest.mark.parametrize(
    "index",
    [
        STATISTICS + footer(STATISTICS, 1) + MAGIC,
        footer(STATISTICS) + MAGIC,
        STATISTICS + bytes(100) + footer(STATISTICS) + MAGIC,
        STATISTICS + footer(STATISTICS) + b"x" + MAGIC,
        record(11, b"too short") + footer(b"") + MAGIC,
    ],
)
def test_an_index_that_is_not_as_written_is_not_read(index: bytes, tmp_path: Path) -> None:
    """What is lost begins behind the last record that says something."""
    ending = data_end(DATA) + index
    found, error = read(tmp_path, MAGIC + DATA + ending)
    assert isinstance(error, CutShort)
    assert error.lost == len(ending)
    assert kinds(found) == [Schema, Channel, Message, Message]


@pytest.mark.parametrize("cut", [0, 1, 8, 9, 12])
def test_a_file_that_ends_within_a_record_was_cut_short(cut: int, tmp_path: Path) -> None:
    found, error = read(tmp_path, MAGIC + DATA + message(3, b"xyz")[:cut])
    assert isinstance(error, CutShort)
    assert error.lost == 0
    assert len(found) == 4


@pytest.mark.parametrize("end", [b"", MAGIC])
def test_zeros_are_what_never_came_to_the_disk(end: bytes, tmp_path: Path) -> None:
    found, error = read(tmp_path, MAGIC + DATA + record(200, b"said nothing") + bytes(50) + end)
    assert isinstance(error, CutShort)
    assert error.lost == len(record(200, b"said nothing")) + 50 + len(end)
    assert len(found) == 4


@pytest.mark.parametrize(("lost", "is_cut"), [(UNSYNCED, True), (UNSYNCED + 1, False)])
def test_no_more_than_was_not_synced_can_be_lost(lost: int, is_cut: bool, tmp_path: Path) -> None:
    found, error = read(tmp_path, MAGIC + DATA + bytes(lost))
    assert isinstance(error, CutShort) is is_cut
    assert isinstance(error, ValueError) is not is_cut
    assert len(found) == 4


@pytest.mark.parametrize("end", [b"", MAGIC])
def test_damage_is_a_cut_only_where_the_file_was_never_finished(end: bytes, tmp_path: Path) -> None:
    damaged = chunk(message(1, b"q"), crc=5)
    found, error = read(tmp_path, MAGIC + DATA + damaged + end)
    assert len(found) == 4
    if end:
        assert isinstance(error, ValueError)
        assert not isinstance(error, CutShort)
    else:
        assert isinstance(error, CutShort)
        assert error.lost == len(damaged)


@pytest.mark.parametrize("content", [b"", MAGIC[:7]])
def test_a_file_without_its_magic_was_cut_short(content: bytes, tmp_path: Path) -> None:
    found, error = read(tmp_path, content)
    assert isinstance(error, CutShort)
    assert (found, error.lost) == ([], 0)


def test_another_magic_is_refused(tmp_path: Path) -> None:
    other = b"\x89MCAP1\r\n"
    found, error = read(tmp_path, other + DATA)
    assert found == []
    assert isinstance(error, ValueError)


@pytest.mark.parametrize(("length", "is_cut"), [(LARGEST, True), (LARGEST + 1, False)])
def test_a_record_is_of_256_mebibytes_at_most(length: int, is_cut: bool, tmp_path: Path) -> None:
    _, error = read(tmp_path, MAGIC + struct.pack("<BQ", 5, length) + b"few")
    assert isinstance(error, CutShort) is is_cut


@pytest.mark.parametrize("short", [1, 3])
def test_a_record_that_leaves_its_chunk_is_refused(short: int, tmp_path: Path) -> None:
    found, error = read(tmp_path, finished(chunk(message(1, b"fits") + message(1, b"long")[:-short])))
    assert found == []
    assert isinstance(error, ValueError)


@pytest.mark.parametrize("within", [True, False])
def test_a_message_shorter_than_its_head_is_refused(within: bool, tmp_path: Path) -> None:
    short = record(5, bytes(21))
    found, error = read(tmp_path, finished(chunk(short) if within else short))
    assert found == []
    assert isinstance(error, struct.error)
