"""Damaged slcan text neither crashes the port nor becomes samples; a short run of the benchmark."""

from tests.benchmarks.hostile_slcan import attack


def test_damaged_text_never_crashes_and_hardly_passes() -> None:
    got = attack(6000, seed=3)
    assert got.crashes == 0
    assert got.checks_failed > 1000, "too few were damaged in what the check is for"
    assert 0 < got.wrong <= 2 * got.expected, "some pass eight bits, no more than chance lets"
    assert got.wrong_samples <= 3, "20 in a million lines"
    assert got.samples > 20
