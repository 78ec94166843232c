"""Damaged frames neither crash a decoder nor become data; a short form of the proof `hostile-frames`."""

import pytest

from drivers.wire import FORMATS
from tests.benchmarks.hostile_frames import CONTROL, attack


@pytest.mark.parametrize("name", FORMATS)
def test_damaged_frames_neither_crash_a_decoder_nor_become_data(name: str) -> None:
    wire = FORMATS[name]
    got = attack(wire, 10_000, 7)
    assert got.crashes == 0
    assert got.wrong == 0 if wire.check_bits >= 32 else got.wrong <= got.expected


def test_a_check_cut_to_8_bits_lets_wrong_frames_through_so_that_they_would_be_seen() -> None:
    assert attack(CONTROL, 10_000, 7).wrong > 0
