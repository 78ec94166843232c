"""Terms found: what a diagnosis leaves is searched for a law that no catalogue holds, simplest first.

    what is left -> scores of ten thousand terms -> finalists -> one that stands, and what reads the same -> again

A term stands that is seen over all that were tried, foretells positions, turns, rests and campaigns left out,
hangs on no single step, and does what no effect of the catalogue does. It is proposed, no more: neither verdict
nor solution changes.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.candidates import Candidate, Candidates, raising_does_not_fit
from procedures.diagnosis.effect_selection import density_gain, holds_in_every_campaign, stands_without_any
from procedures.diagnosis.explained_share import explained_share
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear, predict_left_out, significance
from procedures.diagnosis.residual_rows import Evidence
from procedures.diagnosis.result import Diagnosis
from procedures.discovery.finalists import Finalist, candidate, finalists, sized
from procedures.discovery.known_effects import DECISIVE, is_known
from procedures.discovery.library import LibraryTerm, Rows, library
from procedures.discovery.search import Scores, blocks_of, scores
from procedures.effects import EFFECTS
from procedures.effects.effect import Columns
from procedures.effects.term.effect_of_term import TermEffect
from procedures.effects.time_constant import LOG_RANGE, with_slope
from procedures.errors import DoesNotFit

MAX_P = 0.01  # over the whole library
MAX_PROPOSALS = 3
ONE = 0.999  # correlation of what two terms do, from which on they are one whatever they foretell
SURE = ("established", "likely")
TIMES_FOUND = 3.0  # a coefficient's plausible size, of the largest found
Say = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """A term that this campaign cannot tell from the one proposed: how alike they are, by how much it is worse.

    ``worse`` is in ln marginal likelihood, complexity counted.
    """

    term: TermEffect
    likeness: float
    worse: float


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A term with its coefficients (k,) and 1 sigma, parameters last; p over the library; what reads the same.

    ``share`` is that of the excess held out, ``held_out`` the rms of its rows' errors left out, in sigmas,
    without and with it. ``candidate`` has its columns, ``columns`` and ``found`` those of every reading, the
    term's own first.
    """

    term: TermEffect
    coefficients: tuple[str, ...]
    value: FloatArray
    std: FloatArray
    p: float
    gain: float
    share: float
    held_out: tuple[float, float]
    readings: tuple[Reading, ...]
    candidate: Candidate
    columns: tuple[Term, ...]
    found: tuple[LibraryTerm, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Discovery:
    """What was found beside a diagnosis' sure findings; ``others`` are their columns, ``tried`` how many terms."""

    proposals: tuple[Proposal, ...]
    tried: int
    evidence: Evidence
    others: tuple[Term, ...]


def discover(found: Diagnosis, say: Say = lambda line: None) -> Discovery:
    """Search what a diagnosis of dwells, turns and rests leaves; ``say`` is told how far it is."""
    evidence = found.evidence
    sure = {each.effect for each in found.findings if each.confidence in SURE}
    added = found.added[len(found.declared) :]
    doubtful = [each for each in added if each.effect.name not in sure]
    others = tuple(each.term for each in added if each.effect.name in sure)
    triads = [name for name in ("accelerometer", "gyroscope") if getattr(found.after, name) is not None]
    if not triads:
        return Discovery((), 0, evidence, others)
    rows, terms = Rows(evidence), library(evidence.excitation, triads)
    say(f"{len(terms)} terms are made")
    blocks, pool = blocks_of(rows, terms), Candidates(evidence, found.after, EFFECTS)
    proposals = list[Proposal]()
    for number in range(MAX_PROPOSALS):
        say(f"{len(terms)} terms are tried{f' beside {number} proposed' if number else ''}")
        beside = [*others, *(each.columns[0] for each in proposals)]
        found_so = scores(fit_as_is(evidence, beside), blocks, evidence.noise_dof)
        if found_so.family_p(int(np.argmin(found_so.log_p))) > MAX_P:
            break
        one = _best(rows, terms, found_so, beside, pool, doubtful if not proposals else (), len(proposals))
        if one is None:
            break
        proposals.append(one)
    return Discovery(tuple(proposals), len(terms), evidence, others)


def fit_as_is(evidence: Evidence, terms: Sequence[Term]) -> LinearFit:
    """Fit terms with the rows' own sigma."""
    return fit_linear(evidence, terms, factor=np.ones(len(evidence.residual)))


def _best(
    rows: Rows, terms: Sequence[LibraryTerm], found: Scores, others: Sequence[Term], pool: Candidates,
    doubtful: Sequence[Candidate], number: int,
) -> Proposal | None:  # fmt: skip
    evidence, left_out = rows.evidence, left_out_groups(rows.evidence)
    fit = fit_as_is(evidence, others)
    final = finalists(rows, fit, others, terms, found, left_out)
    best = next((each for each in final if _stands(evidence, each, others, left_out, len(terms))), None)
    if best is None or is_known(evidence, fit, others, best, pool, doubtful, left_out, len(terms)):
        return None
    p = found.family_p(int(np.argmin(found.log_p)))
    return _proposal(evidence, best, _readings(best, final), others, left_out, p, number)


def _stands(
    evidence: Evidence, one: Finalist, others: Sequence[Term], left_out: Sequence[IntArray], tried: int
) -> bool:
    """Say whether a term is significant where all that scatters widens sigma, foretells, hangs on no step."""
    way = candidate(evidence, one)
    with suppress(DoesNotFit), raising_does_not_fit():
        return bool(
            one.density > 0
            and significance(evidence, way.fit(evidence, others)).log_p + np.log(tried) < np.log(MAX_P)
            and density_gain(evidence, way, others, left_out) > 0
            and stands_without_any(evidence, way, others, left_out)
            and holds_in_every_campaign(evidence, way, others)
        )
    return False


def _readings(best: Finalist, final: Sequence[Finalist]) -> list[tuple[Finalist, float]]:
    """Return what does the same here, or is not outdone by enough, the best first; with its correlation."""
    alike = [(each, best.likeness(each.does)) for each in final if each is not best]
    return [
        (each, same) for each, same in alike
        if best.density - each.density < DECISIVE or same > ONE
    ]  # fmt: skip


def _proposal(
    evidence: Evidence, best: Finalist, alike: Sequence[tuple[Finalist, float]], others: Sequence[Term],
    left_out: Sequence[IntArray], p: float, number: int,
) -> Proposal:  # fmt: skip
    way = candidate(evidence, best)
    term, value, std = _solved(evidence, best, others, f"found_{number + 1}")
    readings = tuple(
        Reading(each.term.as_effect(f"reading_{i}", 1.0, "a reading"), same, best.density - each.density)
        for i, (each, same) in enumerate(alike, 1)
    )
    return Proposal(
        term, (*term.coefficients, *term.parameters), value, std, p, best.density,
        explained_share(evidence, way, others, left_out), _errors(evidence, way, others, left_out), readings, way,
        (best.columns, *(each.columns for each, _ in alike)), (best.term, *(each.term for each, _ in alike)),
    )  # fmt: skip


def _solved(
    evidence: Evidence, best: Finalist, others: Sequence[Term], name: str
) -> tuple[TermEffect, FloatArray, FloatArray]:
    """Return the term with coefficients and parameters, and their sigmas, by a Gauss-Newton step of all."""
    term = best.term.as_effect(name, 1.0, "found by station diagnose --discover")
    effect, seen = term.effect(), evidence.excitation
    start = {key: one.value for key, one in best.term.shape.items()}
    way = term.at(seen, Columns((), nonlinear=start))
    linear = len(way.coefficients) - len(start)
    H = evidence.column(way)[:, :linear]
    wide = 1e3 * sized(evidence, fit_as_is(evidence, others), H).plausible  # of its own unit: as good as free
    c = fit_as_is(evidence, [*others, Term(H, wide)]).coefficients()[0]
    bent = with_slope(effect, seen, way, np.append(c, np.zeros(len(start))))
    whole = Term(evidence.column(bent), np.append(wide, np.full(len(start), LOG_RANGE)))
    value, C = fit_as_is(evidence, [*others, whole]).coefficients()
    std = np.sqrt(np.diag(C))
    value = np.append(value[:linear], list(start.values()))  # a parameter stays where it was fitted best
    std = np.append(std[:linear], std[linear:] * list(start.values()))
    plausible = TIMES_FOUND * float(np.max(np.abs(value[:linear])))
    wider = best.term.as_effect(name, float(f"{plausible:.1g}"), "found by station diagnose --discover")
    return wider, value, std


def _errors(
    evidence: Evidence, way: Candidate, others: Sequence[Term], left_out: Sequence[IntArray]
) -> tuple[float, float]:
    """Return the rms of errors of the term's rows where they are left out [sigma], without it and with it."""
    as_is = np.ones(len(evidence.residual))
    rows = evidence.is_data & np.any(way.term.H != 0, axis=1)

    def rms(fit: LinearFit) -> float:
        errors = predict_left_out(evidence, fit, left_out)[1][rows]
        return float(np.sqrt(np.nanmean(errors**2))) if np.isfinite(errors).any() else 0.0

    return rms(way.without(evidence, others, as_is)), rms(way.fit(evidence, others, as_is))
