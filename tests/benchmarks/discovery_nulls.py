"""Print how often a term is proposed of noise alone: `python -m tests.benchmarks.discovery_nulls`.

A bench of each design is recorded and solved once; then 400 times noise of its rows' own sigma takes the place of
what was left, drawn by another seed than that of the search. Draws in which the best of the library is better than
in 99 % of the search's own are searched whole. What a diagnosis does before is not in it, that is what
`tests.benchmarks.discovery --nulls` does anew for each bench. `docs/discovering-effects.md` is the page.
"""

import argparse
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np

from procedures.calibration.joint_calibration import fit_reduced
from procedures.calibration.reduced_steps import reduce_steps
from procedures.diagnosis.residual_rows import evidence_of
from procedures.diagnosis.result import Diagnosis
from procedures.discovery.discover import MAX_P, discover, fit_as_is
from procedures.discovery.library import Rows, library
from procedures.discovery.search import blocks_of, noise_of, scores
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, truth_of

OTHER_SEED = 91


def nulls(design: str, seed: int) -> tuple[int, list[str]]:
    """Return how many draws were made, and what was proposed of each that is searched whole."""
    campaigns = campaigns_of(truth_of(design, seed), design, seed).campaigns
    after = fit_reduced(reduce_steps(campaigns))
    evidence = evidence_of(after)
    blocks, fit = blocks_of(Rows(evidence), library(evidence.excitation)), fit_as_is(evidence, ())
    rule = np.quantile(scores(fit, blocks, evidence.noise_dof).log_p_of_best, MAX_P)
    best = scores(fit, blocks, evidence.noise_dof, OTHER_SEED).log_p_of_best
    noise, said = noise_of(fit, evidence.noise_dof, OTHER_SEED), list[str]()
    for number in np.flatnonzero(best <= rule):
        z = noise[: len(evidence.residual), number]
        drawn = replace(evidence, residual=z * evidence.sigma)
        bench = SimpleNamespace(evidence=drawn, findings=(), added=(), declared=(), after=after)
        found = discover(cast("Diagnosis", bench)).proposals
        said.append("; ".join(" & ".join(one.term.terms) for one in found) or "nothing")
    return len(best), said


def main() -> None:
    """Print a line a design."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--designs", nargs="+", default=["plain", "speeds", "warm"])
    parser.add_argument("--first", type=int, default=400_000, help="the first seed")
    told = parser.parse_args()
    for number, design in enumerate(told.designs):
        many, said = nulls(design, told.first + 1000 * number)
        proposed = sum(each != "nothing" for each in said)
        print(
            f"{design}: {many} draws, {len(said)} searched whole, {proposed} with a term proposed: {said}",
            flush=True,
        )


if __name__ == "__main__":
    main()
