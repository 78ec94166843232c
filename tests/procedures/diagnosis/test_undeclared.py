"""A cause of no catalogue gets no sure name; the proof `undeclared` tries thirty of them."""

from tests.benchmarks.discovering.judged import trial
from tests.benchmarks.discovering.laws import LAWS


def test_a_law_of_no_catalogue_is_reported_as_unexplained_and_gets_no_sure_name() -> None:
    found = trial(next(law for law in LAWS if law.name == "g squared"), 1)
    assert found.verdict in {"unexplained", "partly"}
    assert found.wrong == ""
