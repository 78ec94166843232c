"""How a diagnosis does on undeclared effects, in the catalogue and in none.

Each trial is another unit, surface plate, cube and order of steps; the effect is of 6 to 20 sigma of what it does.
"""

from collections.abc import Sequence

from tests.benchmarks.undeclared_kinds.catalogue import KINDS
from tests.benchmarks.undeclared_kinds.innocent import INNOCENT, none_told
from tests.benchmarks.undeclared_kinds.judged import Outcome, told
from tests.proof.evidence import Figure, spread

APART = 10_000  # seeds between kinds
WRONG = ("wrong, likely", "wrong, established")
RIGHT = ("named", "group led by it")


def _run(item: tuple[str, range]) -> list[Outcome]:
    name, seeds = item
    return [told(KINDS[name], seed) if name in KINDS else none_told(name, seed) for seed in seeds]


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return what ``size`` campaigns of each kind were taken for."""
    names = [*KINDS, *INNOCENT]
    items = [(name, range(begin := seed + i * APART, begin + size)) for i, name in enumerate(names)]
    every = [outcome for each in spread(_run, items) for outcome in each]
    inside = [e for e in every if e.kind in KINDS and KINDS[e.kind].right]
    outside = [e for e in every if e.kind in KINDS and not KINDS[e.kind].right]
    nothing = [e for e in every if e.kind not in KINDS]
    both = [*inside, *outside]
    honest = [e for e in outside if (e.verdict in {"unexplained", "partly"} and e.word not in WRONG) or e.also]
    return {
        "kinds of campaigns": Figure(len(items)),
        "a wrong name, established": share([e for e in both if e.word == WRONG[1]], both, at_most=1),
        "a wrong name, established or likely": share([e for e in both if e.word in WRONG], both, at_most=3),
        "in the catalogue: named, or first of its group": share(
            [e for e in inside if e.word in RIGHT], inside, at_least=95
        ),
        "in no catalogue: unexplained, partly, or a name that does the same": share(honest, outside, at_least=95),
        "of these by a name that does the same": share([e for e in honest if e.also], outside),
        "nothing, or the bench: an effect of the instrument": share(
            [e for e in nothing if e.word in WRONG], nothing, at_most=2
        ),
    }


def share(
    found: Sequence[Outcome], every: Sequence[Outcome], at_least: float | None = None, at_most: float | None = None
) -> Figure:
    """Return how many [%] of all these are."""
    return Figure(100 * len(found) / len(every), "%", at_most, at_least, of=len(every))
