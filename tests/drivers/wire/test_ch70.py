"""CH-70 against the maker's table, and the second look that its weak check needs."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from drivers.framing import Decoder, sniff
from drivers.wire import FORMATS, ch70
from procedures.counts.sample_records import CountBlock
from tests.drivers.wire.blocks import a_block
from tests.drivers.wire.captures import CAPTURES, needs_captures

WIRE = FORMATS["ch70"]


def counts(values: list[int]) -> CountBlock:
    block = a_block(WIRE, len(values))
    assert isinstance(block, CountBlock)
    gyro = np.zeros((len(values), 3), np.int64)
    gyro[:, 0] = values
    return replace(block, gyro=gyro)


@needs_captures
def test_the_makers_table_decodes_to_its_values() -> None:
    with (CAPTURES / "fog_ch70/expected.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    stream = (CAPTURES / "fog_ch70/ch70_frames.bin").read_bytes()
    assert stream.hex() == "".join(row["hex"] for row in rows)
    block = Decoder(WIRE).feed(stream)
    assert block.gyro[:, 0].tolist() == [int(row["raw_count_int32"]) for row in rows]
    assert block.temperature.tolist() == [float(row["temp_degC_raw/16"]) for row in rows]
    scale = ch70.FORMAT.scales["CH-70"]
    rates = np.degrees(block.gyro[:, 0] * scale.gyro * scale.rate_hz)
    assert rates == pytest.approx([float(row["rate_deg_s_at_47023.17"]) for row in rows], rel=1e-4)


def test_what_steps_too_far_is_marked_and_what_follows_is_not() -> None:
    values = [1000 + i for i in range(40)]
    values[20] += 2**25
    decoder = Decoder(WIRE)
    block = decoder.feed(WIRE.encode(counts(values)))
    assert np.flatnonzero(~block.healthy).tolist() == [20]
    assert block.gyro[:, 0].tolist() == values
    assert decoder.counters.bad_status == 1


def test_the_mark_does_not_depend_on_how_the_stream_is_cut() -> None:
    values = [0, 0, 2**24, 0, 2**24, 0, 0, 2**20, 2**20, 2**20, 2**20, 2**20, 2**20]
    stream = WIRE.encode(counts(values))
    whole = Decoder(WIRE).feed(stream).healthy
    decoder = Decoder(WIRE)
    cut = np.concatenate([decoder.feed(stream[at : at + 7]).healthy for at in range(0, len(stream), 7)])
    assert whole.tolist() == cut.tolist()
    assert np.flatnonzero(~whole).tolist() == [2, 4, 7, 8, 9]  # a new level is believed after a while


def test_a_first_sample_that_is_wrong_shuts_nothing_out() -> None:
    block = Decoder(WIRE).feed(WIRE.encode(counts([2**30, *[5] * 8000])))
    assert block.healthy[-1]


def test_other_bytes_are_not_taken_for_it() -> None:
    stream = b"\x80" + bytes(9) + np.random.default_rng(1).bytes(500)
    assert len(Decoder(WIRE).feed(stream)) == 1  # a frame by chance
    assert sniff(stream) == []
