"""Print how terms are found: `python -m tests.benchmarks.discovery --trials 2 --nulls 4`.

The page is `docs/discovering-effects.md`.

Each of thirty laws outside the catalogue is planted by plain numpy at 8 to 20 sigma of what it does; each trial is
another unit, slab, cube and order of steps.
"""

import argparse
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np

from procedures.diagnosis.diagnose import diagnose
from procedures.discovery.discover import discover
from tests.benchmarks.discovering.judged import Outcome, trial
from tests.benchmarks.discovering.laws import LAWS
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, truth_of
from tests.benchmarks.undeclared_kinds.innocent import INNOCENT

SOUND_P = 1e-3
WORDS = ("named", "a reading", "other", "nothing")


def timed(number: int, seed: int) -> Outcome:
    """Run a trial of a law."""
    begin = time.perf_counter()
    return replace(trial(LAWS[number], seed), seconds=time.perf_counter() - begin)


def null(name: str, seed: int) -> Outcome:
    """Search a campaign of a good instrument."""
    begin, one = time.perf_counter(), INNOCENT[name]
    stated = truth_of(one.design, seed)
    truth = one.changed(stated, np.random.default_rng([seed, 47]))
    found = diagnose(campaigns_of(truth, one.design, seed, stated=stated).campaigns)
    more = discover(found)
    said = "; ".join(" & ".join(each.term.terms) for each in more.proposals)
    word = "other" if more.proposals else "nothing"
    return Outcome(f"none: {name}", seed, word, found.verdict, False, said, time.perf_counter() - begin)


def row(outcomes: Sequence[Outcome]) -> str:
    """Return a law's line."""
    words = Counter(each.word for each in outcomes)
    cells = [outcomes[0].law, str(len(outcomes)), *(str(words[word] or "") for word in WORDS)]
    told = [each.fresh for each in outcomes if each.fresh is not None]
    cells.append(" ".join(f"{e.p_nothing:.2g}/{e.p_without:.1g}/{e.p_with:.2g} {e.off:.1f}" for e in told))
    cells += [str(sum(each.is_wrong for each in outcomes) or ""), f"{np.mean([e.seconds for e in outcomes]):.0f}"]
    said = "; ".join(
        f"{each.seed} {each.verdict}{f', first {each.first}' if each.first else ''}: {each.found or '-'}"
        for each in outcomes
    )
    return f"| {' | '.join(cells)} | {said} |"


def main() -> None:
    """Run the trials."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--laws", type=int, default=len(LAWS), help="the first so many")
    parser.add_argument("--trials", type=int, default=2, help="campaigns of each law")
    parser.add_argument("--nulls", type=int, default=0, help="campaigns of each good bench")
    parser.add_argument("--first", type=int, default=3000, help="the first seed")
    parser.add_argument("--only", default="", help="a part of the law's name")
    parser.add_argument("--processes", type=int, default=1)
    options = parser.parse_args()
    fresh = "fresh: p nothing/without/with, off"
    print(f"| law | campaigns | {' | '.join(WORDS)} | {fresh} | wrong >= likely | s | found |")
    print("|---" * (len(WORDS) + 6) + "|")
    outcomes = list[Outcome]()
    with ProcessPoolExecutor(options.processes) as pool:
        rows = [(timed, i, law.name, options.trials) for i, law in enumerate(LAWS[: options.laws])]
        rows += [(null, name, f"none: {name}", options.nulls) for name in INNOCENT]
        for number, (one, what, name, count) in enumerate(rows):
            if count and options.only in name:
                seeds = [options.first + 1000 * number + i for i in range(count)]
                outcomes += (found := list(pool.map(one, [what] * count, seeds)))
                print(row(found), flush=True)
    laws = [each for each in outcomes if not each.law.startswith("none")]
    if laws:
        right = sum(each.word in WORDS[:2] for each in laws)
        print(f"\n{right} of {len(laws)} laws named, or among the readings; "
              f"{sum(each.is_wrong for each in laws)} wrong names likely or established")  # fmt: skip
        told = [each.fresh for each in laws if each.fresh is not None]
        sound = [each for each in told if each.p_nothing > SOUND_P]
        print(f"{sum(each.p_with > SOUND_P for each in sound)} of {len(sound)} fresh campaigns pass the test "
              f"with the file ({sum(each.p_without > SOUND_P for each in sound)} without)")  # fmt: skip
    if nulls := outcomes[len(laws) :]:
        print(f"{sum(each.word == 'other' for each in nulls)} of {len(nulls)} good benches: a term proposed")


if __name__ == "__main__":
    main()
