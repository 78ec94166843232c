"""Edits of signed certificates: each that changes what is signed is told, each that does not is let pass."""

from tests.benchmarks.certificate_edits import false_alarms, missed


def test_two_hundred_edits_are_reported(files: tuple[bytes, bytes]) -> None:
    made, lost = missed(208, 7, files)
    assert len(made) == 16
    assert lost == []


def test_what_says_the_same_holds(files: tuple[bytes, bytes]) -> None:
    assert false_alarms(20, 7, files) == 0
