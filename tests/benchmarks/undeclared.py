"""What becomes of laws outside the catalogue, of kinds of the literature, and of a good instrument on a bench.

Each trial is another unit, surface plate, cube and order of steps. The diagnosis shall say that something is
unexplained, or name an effect that does the same to the campaign; the search for terms shall find the law.
"""

from collections.abc import Sequence

from procedures.diagnosis.diagnose import diagnose
from procedures.discovery.discover import discover
from tests.benchmarks.discovering.judged import Outcome, named, trial
from tests.benchmarks.discovering.laws import LAWS
from tests.benchmarks.undeclared_kinds.innocent import INNOCENT, innocent
from tests.benchmarks.undeclared_kinds.literature import LITERATURE
from tests.proof.evidence import Figure, spread

APART = 10_000  # seeds between kinds
OPEN = {"unexplained", "partly"}
Item = tuple[int, int]


def law(item: Item) -> Outcome:
    """Try a law of a number, by a seed."""
    return trial(LAWS[item[0]], item[1])


def kind(item: Item) -> Outcome:
    """Try a kind of the literature of a number, by a seed."""
    return named(list(LITERATURE.values())[item[0]], item[1])


def good(item: Item) -> tuple[bool, bool]:
    """Return whether an effect of the instrument was claimed of a good one, and whether a term was proposed."""
    _, campaigns = innocent(list(INNOCENT)[item[0]], item[1])
    found = diagnose(campaigns)
    claims = [each for each in found.findings if each.kind == "instrument" and each.confidence != "possible"]
    return bool(claims), bool(discover(found).proposals)


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return what ``size`` campaigns of each law, and of each good bench, were taken for."""
    laws = spread(law, _items(len(LAWS), size, seed))
    benches = spread(good, _items(len(INNOCENT), size, seed + APART * len(LAWS)))
    kinds = spread(kind, _items(len(LITERATURE), size, seed + APART * (len(LAWS) + len(INNOCENT))))
    honest = [one.is_same or (one.verdict in OPEN and not one.wrong) for one in laws]
    return {
        "law: unexplained, partly explained, or a name that does the same": _share(honest, at_least=95),
        "law: a wrong name, established": _share([x.wrong == "established" for x in laws], at_most=1),
        "law: a wrong name, established or likely": _share([x.wrong != "" for x in laws], at_most=3),
        "law: found by the search for terms": _share([x.word in {"named", "a reading"} for x in laws]),
        "law: another term proposed": _share([x.word == "other" for x in laws]),
        "kind: its name, one that does the same, or unexplained where it has none": _share(
            [_is_right(x) for x in kinds], at_least=95
        ),
        "kind: a wrong name, established or likely": _share([x.wrong != "" for x in kinds], at_most=3),
        "good instrument: an effect claimed": _share([claim for claim, _ in benches], at_most=2),
        "good instrument: a term proposed": _share([term for _, term in benches], at_most=5),
    }


def _is_right(one: Outcome) -> bool:
    has_name = bool(LITERATURE[one.law].truth)
    return not one.wrong and (one.is_same or (one.verdict in OPEN and not has_name))


def _items(kinds: int, size: int, seed: int) -> list[Item]:
    return [(number, seed + APART * number + i) for number in range(kinds) for i in range(size)]


def _share(marks: Sequence[bool], at_least: float | None = None, at_most: float | None = None) -> Figure:
    return Figure(100 * sum(marks) / len(marks), "%", at_most, at_least, len(marks))
