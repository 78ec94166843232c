"""A power cut in the moment in which a file is finished: its end may be there, and its index torn."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from procedures.earth.gnss_records import FixType, GnssFix
from station.files.mcap_files import StepWriter, read_step
from station.files.mcap_files.fix_reader import read_fixes
from station.files.mcap_files.fix_writer import FixWriter
from station.files.mcap_files.schemas import RAW_TOPIC
from station.stream.reader.journal import Journal
from station.stream.reader.messages import Chunk
from tests.station.files.mcap_files.test_mcap_files import HOST, block

MAGIC = b"\x89MCAP0\r\n"


def step(path: Path) -> None:
    writer = StepWriter(path)
    writer.write_block(HOST, block(0, 100))
    writer.flush()
    writer.write_block(HOST + 1, block(100, 100))
    writer.close()


def fixes(path: Path) -> None:
    writer = FixWriter(path)
    for i in range(20):
        writer.write(GnssFix("HEARD", 1, HOST + i, FixType.FIX_3D, device_ns=i, latitude=0.8, longitude=0.2))
    writer.close()


def journal(path: Path) -> None:
    made = Journal(path, {"url": "here"}, lambda error: pytest.fail(str(error)), RAW_TOPIC)
    made.put(Chunk(HOST, b"abc"))
    made.close()


WRITERS: list[tuple[Callable[[Path], None], Callable[[Path], int]]] = [
    (step, lambda path: len(read_step(path))),
    (fixes, lambda path: len(read_fixes(path))),
    (journal, lambda path: len(read_step(path).raw)),
]


@pytest.mark.parametrize(("write", "number"), WRITERS)
def test_what_has_its_end_has_its_data_and_they_are_read_whatever_is_torn_of_the_index(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Callable[[Path], None], number: Callable[[Path], int]
) -> None:
    path, torn, synced, real = tmp_path / "a.mcap", tmp_path / "torn.mcap", list[bytes](), os.fsync

    def fsync(descriptor: int) -> None:
        real(descriptor)
        synced.append(path.read_bytes())

    monkeypatch.setattr(os, "fsync", fsync)
    write(path)
    whole, there = path.read_bytes(), number(path)
    data = max(len(content) for content in synced if not content.endswith(MAGIC))
    assert data < len(whole)
    for first in range(data, len(whole) - len(MAGIC), 256):
        last = min(first + 256, len(whole) - len(MAGIC))
        torn.write_bytes(whole[:first] + bytes(last - first) + whole[last:])
        assert number(torn) == there
