"""A step's MCAP file: what was flushed survives, damage is never data, other tools can read it."""

import hashlib
import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_protobuf.decoder import DecoderFactory

from procedures.counts.sample_records import CountBlock
from procedures.errors import ErrorCode
from station.errors import CannotWrite, DataRefused
from station.files.mcap_files import COUNTS, StepContents, StepWriter, read_step, read_table
from station.files.mcap_files.schemas import COUNTS_TOPIC, SCHEMA
from tests.paths import ROOT
from tests.refusals import refused

HOST = 1_760_000_000_000_000_000


def block(first: int, n: int) -> CountBlock:
    counter = first + np.arange(n)
    gyro = np.stack([counter, -counter, counter * 0 + 2**40], axis=1)
    return CountBlock(
        counter, counter * 0.001, gyro, gyro + 1, np.full(n, 21.5), np.full(n, 3), np.ones(n, dtype=np.bool_)
    )


def write(path: Path, blocks: int = 10) -> str:
    writer = StepWriter(path)
    for i in range(blocks):
        writer.write_raw(HOST + i, b"\x55\xaa" + bytes([i]))
        writer.write_block(HOST + i, block(100 * i, 100))
        writer.flush(sync=False)
    return writer.close()


def check_prefix(step: StepContents) -> None:
    n = len(step)
    assert step.counter.tolist() == list(range(n))
    assert step.device_ns.tolist() == [i * 1_000_000 for i in range(n)]
    if n:
        assert step.gyro is not None
        assert step.accel is not None
        assert np.array_equal(step.gyro, block(0, n).gyro)
        assert np.array_equal(step.accel, block(0, n).accel)
    assert all(data == b"\x55\xaa" + bytes([i]) for i, (_, data) in enumerate(step.raw))


def test_a_step_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    path = tmp_path / "step.mcap"
    sha256 = write(path)
    step = read_step(path)
    assert (len(step), len(step.raw), step.output, step.damage) == (1000, 10, COUNTS, None)
    assert step.sha256 == sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert set(step.status.tolist()) == {3}
    assert set(step.host_ns.tolist()) == set(range(HOST, HOST + 10))
    check_prefix(step)


def test_another_reader_decodes_it_by_the_schema_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "step.mcap"
    write(path, 2)
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        samples = [m for _, _, _, m in reader.iter_decoded_messages(topics=["/imu/counts"])]
        raw = [m for _, _, _, m in reader.iter_decoded_messages(topics=["/imu/raw"])]
    assert [s.counter for s in samples] == list(range(200))
    assert list(samples[7].gyro) == [7, -7, 2**40]
    assert samples[7].temperature_c == 21.5
    assert [r.data for r in raw] == [b"\x55\xaa\x00", b"\x55\xaa\x01"]


def test_a_file_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "step.mcap"
    write(path, 1)
    with refused(CannotWrite, ErrorCode.CANNOT_WRITE):
        StepWriter(path)


def test_a_file_cut_anywhere_gives_what_is_whole_and_says_so(tmp_path: Path) -> None:
    whole, cut = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    write(whole)
    content = whole.read_bytes()
    lengths = []
    for size in random.Random(1).sample(range(len(content)), 25):
        cut.write_bytes(content[:size])
        step = read_step(cut)
        assert step.damage == "the recording was cut short"
        check_prefix(step)
        lengths.append((size, len(step)))
    counts = [n for _, n in sorted(lengths)]
    assert counts == sorted(counts)
    assert counts[-1] >= 900


def test_no_flipped_bit_becomes_a_wrong_value(tmp_path: Path) -> None:
    whole, bad = tmp_path / "whole.mcap", tmp_path / "bad.mcap"
    write(whole)
    content = whole.read_bytes()
    not_read, chance = 0, random.Random(2)
    for _ in range(80):
        damaged = bytearray(content)
        damaged[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        bad.write_bytes(damaged)
        try:
            step = read_step(bad)
        except DataRefused:
            not_read += 1
            continue
        check_prefix(step)
        assert len(step) == 1000 or step.damage
    assert not_read > 40


@given(st.binary(max_size=200))
def test_arbitrary_bytes_are_refused_or_hold_nothing(
    tmp_path_factory: pytest.TempPathFactory, content: bytes
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.mcap"
    path.write_bytes(content)
    try:
        step = read_step(path)
    except DataRefused:
        return
    assert (len(step), step.damage) == (0, "the recording was cut short")


def _foreign(path: Path, *, name: str = COUNTS, data: bytes = b"", schema: bytes = SCHEMA) -> Path:
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        identity = writer.register_schema(name=name, encoding="protobuf", data=schema)
        channel = writer.register_channel(topic=COUNTS_TOPIC, message_encoding="protobuf", schema_id=identity)
        writer.add_message(channel, log_time=1, data=data, publish_time=1)
        writer.finish()  # type: ignore[no-untyped-call]
    return path


@pytest.mark.parametrize(
    "change",
    [
        {"name": "other.Imu"}, {"data": b"\xff\xff\xff"}, {"data": b"\x1a\x02\x01\x01"},  # 2 values of gyro
        {"schema": SCHEMA.replace(b"accel", b"gyro2").replace(b"status", b"accel\0")[:10]},
    ],
)  # fmt: skip
def test_a_foreign_file_that_does_not_fit_is_refused(tmp_path: Path, change: dict[str, bytes]) -> None:
    with refused(DataRefused, ErrorCode.DATA, "x.mcap"):
        read_step(_foreign(tmp_path / "x.mcap", **change))  # type: ignore[arg-type]


def test_rates_are_refused_where_counts_are_stated(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    write(path, 1)
    with path.open("rb") as stream, refused(DataRefused, None, "imu.output"):
        read_table(stream, path, counts=False)


def test_a_kill_loses_only_what_was_not_flushed(tmp_path: Path) -> None:
    path = tmp_path / "step.mcap"
    program = f"""
import sys
sys.path.insert(0, {str(ROOT)!r})
from pathlib import Path
import numpy as np
from procedures.counts.sample_records import CountBlock
from station.files.mcap_files import StepWriter
w = StepWriter(Path({str(path)!r}))
for i in range(10**6):
    n = np.arange(100 * i, 100 * i + 100)
    g = np.stack([n, -n, n * 0 + 2**40], axis=1)
    w.write_raw({HOST} + i, b"\\x55\\xaa" + bytes([i % 256]))
    w.write_block({HOST} + i, CountBlock(n, n * 0.001, g, g + 1, n * 0.0, n * 0, n == n))
    w.flush(sync=False)
    print(100 * i + 100, flush=True)
"""
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        for _ in range(20):
            reported = int(child.stdout.readline())
        os.kill(child.pid, signal.SIGKILL)
    step = read_step(path)
    assert step.damage == "the recording was cut short"
    assert len(step) >= reported
    check_prefix(step)
    with path.open("rb") as stream, pytest.raises(McapError):
        list(make_reader(stream).iter_messages())
