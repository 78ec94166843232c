"""Whether what was found is the law that was planted: the same function on the campaign's inputs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.diagnosis.diagnose import diagnose
from procedures.discovery.discover import Discovery, discover
from procedures.effects.effect import INSTRUMENT
from procedures.evidence.linear_model import Term, fit_linear
from procedures.evidence.residual_rows import Evidence
from tests.benchmarks.discovering.laws import Law
from tests.benchmarks.discovering.planting import outside_model, with_law
from tests.benchmarks.undeclared_kinds.literature import Kind

SAME = 0.98  # correlation of what was planted with what the term can do at its best
SURE = ("established", "likely")


@dataclass(frozen=True)
class Outcome:
    """What a law was taken for, and whether it was found.

    ``verdict`` is the diagnosis's; ``is_same`` where it named an effect that does the same; ``wrong`` is the
    confidence of a name that does not, or empty. ``word`` is the search's: named, a reading, other, nothing.
    """

    law: str
    verdict: str
    is_same: bool
    wrong: str
    word: str


def trial(law: Law, seed: int) -> Outcome:
    """Plant a law in another unit, diagnose and search."""
    drawn, _, campaigns = with_law(law, seed)
    found = diagnose(campaigns)
    more = discover(found)
    does = drawn.done(more.evidence)
    own = [each for each in found.findings if each.kind == "instrument"]
    added = [each.term for each in found.added if each.effect.name.split(".")[0] in INSTRUMENT]
    is_same = bool(added) and similarity(more.evidence, added, does) > SAME
    sure = [word for word in SURE if any(each.confidence == word for each in own)]
    return Outcome(law.name, found.verdict, is_same, "" if is_same or not sure else sure[0], _word(more, does))


def named(kind: Kind, seed: int) -> Outcome:
    """Diagnose a kind of the literature: a name is the same if its physics allows it; nothing is searched for."""
    found = diagnose(kind.campaigns(seed))
    is_same = any(each.effect in kind.acceptable for each in found.findings)
    wrong = {f.confidence for f in found.findings if f.kind == "instrument" and f.effect not in kind.acceptable}
    return Outcome(kind.name, found.verdict, is_same, next((word for word in SURE if word in wrong), ""), "")


def _word(more: Discovery, does: np.ndarray) -> str:
    if not more.proposals:
        return "nothing"
    own = [each.columns[0] for each in more.proposals]
    if similarity(more.evidence, own, does) > SAME:
        return "named"
    for i, each in enumerate(more.proposals):
        for reading in each.columns[1:]:
            if similarity(more.evidence, [*own[:i], reading, *own[i + 1 :]], does) > SAME:
                return "a reading"
    return "other"


def similarity(evidence: Evidence, terms: Sequence[Term], does: np.ndarray) -> float:
    """Return how much of what was planted (n,) terms can do in addition to the model, as a correlation."""
    fit = fit_linear(evidence, [], factor=np.ones(len(evidence.residual)))
    H = np.hstack([each.H for each in terms]) / evidence.sigma[:, None]
    left = np.column_stack([outside_model(fit.Q, column) for column in H.T])
    U, s, _ = np.linalg.svd(left, full_matrices=False)
    U = U[:, s > 1e-9 * s[0]]
    wanted = outside_model(fit.Q, does)
    return float(np.linalg.norm(U.T @ wanted) / np.linalg.norm(wanted))
