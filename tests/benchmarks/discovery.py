"""How terms of laws outside the catalogue are found.

Each of thirty laws is planted by plain numpy at 8 to 20 sigma of what it does; each trial is another unit, surface
plate, cube and order of steps. Campaigns of a good instrument stand beside them.
"""

import numpy as np

from procedures.diagnosis.diagnose import diagnose
from procedures.discovery.discover import discover
from tests.benchmarks.discovering.judged import Outcome, trial
from tests.benchmarks.discovering.laws import LAWS
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, truth_of
from tests.benchmarks.undeclared_kinds.innocent import INNOCENT
from tests.proof.evidence import Figure, spread

APART = 1000  # seeds between laws


def null(name: str, seed: int) -> Outcome:
    """Search a campaign of a good instrument."""
    one = INNOCENT[name]
    stated = truth_of(one.design, seed)
    truth = one.changed(stated, np.random.default_rng([seed, 47]))
    more = discover(diagnose(campaigns_of(truth, one.design, seed, stated=stated).campaigns))
    return Outcome(name, seed, "other" if more.proposals else "nothing", False)


def _run(item: tuple[int, int, int]) -> list[Outcome]:
    number, size, seed = item
    seeds = range(begin := seed + APART * number, begin + size)
    if number < len(LAWS):
        return [trial(LAWS[number], one) for one in seeds]
    return [null(list(INNOCENT)[number - len(LAWS)], one) for one in seeds]


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return what was found of ``size`` campaigns of each law, and of each good bench."""
    found = spread(_run, [(number, size, seed) for number in range(len(LAWS) + len(INNOCENT))])
    laws = [one for each in found[: len(LAWS)] for one in each]
    nothing = [one for each in found[len(LAWS) :] for one in each]
    of = len(laws)
    right = Figure(sum(one.word in {"named", "a reading"} for one in laws), of=of, at_least=round(0.8 * of, 1))
    return {
        "law named, or among the readings": right,
        "law in an ambiguous group": Figure(sum(one.word == "ambiguous" for one in laws), of=of),
        "another term proposed": Figure(sum(one.word == "other" for one in laws), of=of),
        "a wrong name, established or likely": Figure(sum(one.is_wrong for one in laws), of=of, at_most=0.03 * of),
        "good instrument: a term proposed": Figure(
            sum(one.word == "other" for one in nothing), of=len(nothing), at_most=0.05 * len(nothing)
        ),
    }
