"""A name that is outdone by a plain curve of what the cause goes with is in doubt."""

from functools import cache

from tests.benchmarks.undeclared_kinds.catalogue import KINDS
from tests.benchmarks.undeclared_kinds.judged import Outcome, told


@cache
def outcome(kind: str, seed: int) -> Outcome:
    return told(KINDS[kind], seed)


def test_undeclared_kinds_get_no_wrong_name() -> None:
    """The benchmark's short version: two that are in no catalogue, and one that is."""
    assert outcome("g squared", 1).word in {"unexplained", "partly", "group without it"}
    assert outcome("Shupe effect", 3).word in {"named", "group led by it"}
