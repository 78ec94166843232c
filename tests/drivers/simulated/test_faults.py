import tomllib

import numpy as np
import pytest

from drivers.errors import TruthRefused
from drivers.framing import Decoder
from drivers.simulated.faults import KINDS, Fault, FaultyLine, Silence, faults_from
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from procedures.counts.sample_records import CountBlock

WIRE = FORMATS["counts"]


def through(faults: list[Fault], cuts: tuple[int, ...] = (500,)) -> tuple[Decoder, np.ndarray, list[Silence]]:
    imu, line, decoder = SimulatedImu(Truth.example(1), 1), FaultyLine(WIRE, faults, 0.02, 1), Decoder(WIRE)
    sent = [part for cut in cuts for part in line.send(imu.read(cut))]
    blocks = [decoder.feed(part) for part in sent if not isinstance(part, Silence)]
    blocks.append(decoder.finish())
    return (
        decoder,
        np.concatenate([block.counter for block in blocks]),
        [s for s in sent if isinstance(s, Silence)],
    )


def test_no_faults_change_nothing() -> None:
    decoder, counter, silences = through([])
    assert counter.tolist() == list(range(500))
    assert decoder.counters.skipped_bytes == 0
    assert not silences


@pytest.mark.parametrize("cuts", [(500,), (101, 1, 398), (1,) * 500])
def test_each_fault_does_what_it_says_however_the_blocks_are_cut(cuts: tuple[int, ...]) -> None:
    decoder, counter, _ = through([Fault("bad_crc", 2.0, count=3)], cuts)
    assert decoder.counters.bad_crc == 3
    assert counter.tolist() == [*range(100), *range(103, 500)]
    decoder, counter, _ = through([Fault("lost", 2.0, every_s=4.0, count=2)], cuts)
    assert counter.tolist() == [*range(100), *range(102, 300), *range(302, 500)]
    assert decoder.counters.skipped_bytes == 0
    decoder, counter, _ = through([Fault("garbage", 2.0, count=77)], cuts)
    assert len(counter) == 500
    assert decoder.counters.skipped_bytes == 77
    _, counter, _ = through([Fault("repeated", 2.0, count=2)], cuts)
    assert counter.tolist() == [*range(101), 100, 100, *range(101, 500)]
    _, counter, _ = through([Fault("counter_restart", 2.0)], cuts)
    assert counter.tolist() == [*range(100), *range(400)]


@pytest.mark.parametrize("kind", ["stall", "unplug"])
def test_a_silence_loses_what_was_taken_during_it(kind: str) -> None:
    _, counter, silences = through([Fault(kind, 2.0, seconds=1.0)])
    assert silences == [Silence(1.0, kind)]
    assert counter.tolist() == [*range(100), *range(150, 500)]


def test_equal_seeds_spoil_equally() -> None:
    faults = [Fault("garbage", 0.5, every_s=1.0, count=20), Fault("bad_crc", 0.7, every_s=1.0)]
    streams = []
    for _ in range(2):
        imu, line = SimulatedImu(Truth.example(1), 1), FaultyLine(WIRE, faults, 0.02, 4)
        streams.append(line.send(imu.read(500)))
    assert streams[0] == streams[1]


def test_a_format_without_counter_loses_frames_too() -> None:
    wire = FORMATS["rawimusx"]
    line = FaultyLine(wire, [Fault("lost", 1.0, count=5)], 0.02, 1)
    sent = line.send(SimulatedImu(Truth.example(1), 1).read(100))
    decoded: CountBlock = Decoder(wire).feed(b"".join(part for part in sent if isinstance(part, bytes)))
    assert len(decoded) == 95


def test_faults_are_read_from_toml() -> None:
    text = '[[fault]]\nkind = "lost"\nat_s = 3\ncount = 2\n[[fault]]\nkind = "unplug"\nat_s = 9.5\nseconds = 2\n'
    assert faults_from(tomllib.loads(text)["fault"]) == (
        Fault("lost", 3, count=2),
        Fault("unplug", 9.5, seconds=2),
    )
    assert faults_from(()) == ()


@pytest.mark.parametrize(
    ("table", "named"),
    [
        ({"kind": "explode", "at_s": 1}, ", ".join(KINDS)),
        ({"kind": "lost"}, "at_s"),
        ({"kind": "lost", "at_s": -1}, "not negative"),
        ({"kind": "lost", "at_s": "soon"}, "a number"),
        ({"kind": "lost", "at_s": 1, "often": 3}, "every_s"),
    ],
)
def test_a_fault_that_breaks_a_rule_is_refused(table: dict, named: str) -> None:
    with pytest.raises(TruthRefused, match=named):
        faults_from([table])
