"""Print how a diagnosis does on undeclared effects: `python -m tests.benchmarks.undeclared --trials 4`.

`docs/undeclared.md` lists them. Each trial is another unit, slab, cube and order of steps; the effect is of 6 to
20 sigma of what it does.
"""

import argparse
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from tests.benchmarks.undeclared_kinds.catalogue import KINDS
from tests.benchmarks.undeclared_kinds.innocent import INNOCENT, none_told
from tests.benchmarks.undeclared_kinds.judged import WORDS, Outcome, told

APART = 10_000  # seeds between kinds
WRONG = ("wrong, likely", "wrong, established")
RIGHT = ("named", "group led by it")
Trial = Callable[[int], Outcome]


def trials() -> dict[str, Trial]:
    """Return each row's name and its trial, by a seed."""
    return {name: partial(_told, name) for name in KINDS} | {
        f"none: {name}": partial(none_told, name) for name in INNOCENT
    }


def _told(name: str, seed: int) -> Outcome:
    return told(KINDS[name], seed)


def row(outcomes: Sequence[Outcome]) -> str:
    """Return a line of one kind's campaigns."""
    words = Counter(each.word for each in outcomes)
    others = Counter(name for each in outcomes for name in each.named)
    cells = [outcomes[0].kind, str(len(outcomes)), *(str(words[word] or "") for word in WORDS)]
    verdicts = ", ".join(f"{v} {n}" for v, n in Counter(each.verdict for each in outcomes).most_common())
    lost = " ".join(f"{e.seed}:{'+'.join(e.named)}" for e in outcomes if e.word in WRONG)
    cells += [verdicts, ", ".join(f"{name} {n}" for name, n in others.most_common(4)), lost]
    return "| " + " | ".join(cells) + " |"


def figures(outcomes: Sequence[Outcome]) -> str:
    """Return what is asked and what was measured."""
    catalogue = [e for e in outcomes if e.kind in KINDS and KINDS[e.kind].right]
    outside = [e for e in outcomes if e.kind in KINDS and not KINDS[e.kind].right]
    nothing = [e for e in outcomes if e.kind not in KINDS]
    every = [*catalogue, *outside]
    honest = [e for e in outside if (e.verdict in {"unexplained", "partly"} and e.word not in WRONG) or e.also]
    asked = [
        ("wrong name established", "<= 1 %", [e for e in every if e.word == WRONG[1]], every),
        ("wrong name at all", "<= 3 %", [e for e in every if e.word in WRONG], every),
        ("in the catalogue: named, or first of its group", ">= 95 %", [e for e in catalogue if e.word in RIGHT],
         catalogue),
        ("in no catalogue: unexplained or partly, or a name that does the same", ">= 95 %", honest, outside),
        ("  of these by a name that does the same", "", [e for e in honest if e.also], outside),
        ("nothing, or the bench: an instrument's effect", "<= 2 %", [e for e in nothing if e.word in WRONG],
         nothing),
    ]  # fmt: skip
    lines = [
        f"| {what} | {limit} | {len(a)} of {len(b)}, {len(a) / len(b):.1%} |" for what, limit, a, b in asked if b
    ]
    return "\n".join(("| | asked | measured |", "|---|---|---|", *lines))


def main() -> None:
    """Run the trials."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=2, help="campaigns of each kind")
    parser.add_argument("--only", default="", help="a part of the kind's name; 'none' for a good instrument")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--seed", type=int, help="this one alone, as a row's last column gives it")
    parser.add_argument("--processes", type=int, default=1)
    options = parser.parse_args()
    print("| kind | campaigns | " + " | ".join(WORDS) + " | verdicts | names | wrong |")
    print("|---" * (len(WORDS) + 5) + "|")
    outcomes = list[Outcome]()
    with ProcessPoolExecutor(options.processes) as pool:
        for number, (name, trial) in enumerate(trials().items()):
            begin = options.first + APART * number
            seeds = range(begin, begin + options.trials) if options.seed is None else [options.seed]
            if options.only in name:
                outcomes += (found := list(pool.map(trial, seeds)))
                print(row(found), flush=True)
    print()
    print(figures(outcomes))


if __name__ == "__main__":
    main()
