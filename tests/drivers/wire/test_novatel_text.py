"""Lines of text read many at once give what they give one by one, whatever stands in them."""

import random
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.framing import MIN_BATCH_BYTES, Decoder
from drivers.wire import FORMATS, WireFormat, novatel_binary
from procedures.counts.sample_records import BLOCK_FIELDS, joined_blocks
from tests.benchmarks.damage import DAMAGES, Shape, damaged
from tests.drivers.wire.blocks import a_block, each_format, frames_of

of_text = each_format(lambda wire: wire.imu.text is not None)
ODD = [
    b"+5", b"-0", b"1_0", b" 7", b"007", b"-", b"", b"x", b"2147483647", b"-2147483648", b"2147483648", b"-1",
    b"99999999999", b"12345678901234567", b"70000", b"256", b"AB", b"ab", b"ffffffff", b"123456789", b"1.5",
    b"nan", b"1e5", b".5", b"5.", b"-0.5", b"604799.999999999", b"1234567.5", b"0.1234567891", b"1.+5", b"1,2",
    b"3;4", b"5*6", b"\r\n", b"\xff",
]  # fmt: skip


def one_by_one(wire: WireFormat) -> WireFormat:
    assert wire.imu.text is not None
    kind = replace(wire.imu, text=replace(wire.imu.text, lines=None))
    return replace(wire, imu=kind, identity=kind if wire.identity is wire.imu else wire.identity)


def assert_alike(wire: WireFormat, pieces: list[bytes]) -> int:
    """Feed the same to both; return the number of samples."""
    both = []
    for each in (wire, one_by_one(wire)):
        decoder, blocks, edges = Decoder(each), [], []
        for piece in [*pieces, None]:
            blocks.append(decoder.finish() if piece is None else decoder.feed(piece))
            edges.append(decoder.edges.tolist())
        both.append((joined_blocks(blocks), edges, decoder.counters, decoder.identity))
    (many, *rest), (single, *others) = both
    for name in BLOCK_FIELDS:
        np.testing.assert_array_equal(getattr(many, name), getattr(single, name), err_msg=name)
    assert rest == others
    return len(many)


@cache
def some_lines(wire: WireFormat) -> list[bytes]:
    return frames_of(wire, a_block(wire, 60, largest=2**31 - 1))


@of_text
def test_regular_lines_are_read_together(wire: WireFormat) -> None:
    stream = b"".join(some_lines(wire))
    [found] = wire.imu.text.lines(stream)
    assert len(found.edges) == 60
    assert assert_alike(wire, [stream]) == 60


@of_text
@settings(max_examples=20)
@given(seed=st.integers(0, 2**32), cut=st.integers(MIN_BATCH_BYTES, 3 * MIN_BATCH_BYTES))
def test_damaged_lines_give_the_same_either_way(wire: WireFormat, seed: int, cut: int) -> None:
    shape = Shape((wire.imu.prefix, b"\r\n"), len(wire.imu.prefix), 120)
    rng = random.Random(seed)
    ways = (*DAMAGES, *[lambda _, frame, *__: frame] * 8)
    stream = b"".join(damaged(rng, some_lines(wire), shape, ways)[0])
    assert assert_alike(wire, [stream[at : at + cut] for at in range(0, len(stream), cut)]) > 10


@of_text
@settings(max_examples=30)
@given(data=st.data())
def test_odd_lines_whose_crc_is_right_give_the_same_either_way(wire: WireFormat, data: st.DataObject) -> None:
    lines = list(some_lines(wire))
    for _ in range(data.draw(st.integers(1, 6))):
        row = data.draw(st.integers(0, len(lines) - 1))
        head, _, tail = lines[row].rpartition(b"*")[0].partition(b";")
        fields = tail.split(b",")
        fields[data.draw(st.integers(0, len(fields) - 1))] = data.draw(st.sampled_from(ODD))
        body = head + b";" + b",".join(fields)
        lines[row] = (
            body
            + b"*%08x" % novatel_binary.crc(body[1:])
            + data.draw(st.sampled_from([b"\r\n", b"\n", b"", b"\r\n\r\n"]))
        )
    assert assert_alike(wire, [b"".join(lines)]) >= 54


@pytest.mark.parametrize("seconds", ["0.1", "484620.664389000", "604799.999999999", "0.000000001", "123456.7"])
def test_seconds_are_the_nearest_float(seconds: str) -> None:
    wire = FORMATS["rawimusa"]
    body = b"%%RAWIMUSA,2209,491612.254;2209,%s,ea5afe00,1,2,3,4,5,6" % seconds.encode()
    line = body + b"*%08x\r\n" % novatel_binary.crc(body[1:])
    [found] = wire.imu.text.lines(line * 3)
    assert np.frombuffer(found.rows, wire.imu.dtype)["seconds"].tolist() == [float(seconds)] * 3


@of_text
def test_a_file_of_thousands_of_lines_says_what_each_line_says(wire: WireFormat) -> None:
    """Arrays of more than some thousand columns lie in memory otherwise than small ones."""
    alone, block = Decoder(wire).feed(wire.example + b"\r\n"), Decoder(wire).feed(5000 * (wire.example + b"\r\n"))
    assert len(block) == 5000
    for name in ("device_time", "gyro", "accel", "status"):
        assert (getattr(block, name) == getattr(alone, name)[0]).all()  # some counts have nine digits
