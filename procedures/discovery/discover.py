"""Terms found: what a diagnosis leaves is searched for a law that no catalogue holds, simplest first.

The terms of the library are hypotheses like all others (`procedures.inference`): together they have the prior odds
of `priors.ODDS_TERMS`, shared out by their simplicity, and they compete with the catalogue, with functions without
a name and with wider noise. Those that come into question at all are chosen by their own marginal likelihood. A
term is proposed where the terms are likelier than everything else; neither verdict nor solution changes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.caches import clear_caches
from procedures.discovery.library import LibraryTerm, Rows, library
from procedures.effects import EFFECTS
from procedures.effects.effect import with_slope
from procedures.effects.excitation import LOG_RANGE, Columns
from procedures.effects.term.effect_of_term import TermEffect
from procedures.evidence.candidates import Candidate, Candidates
from procedures.evidence.linear_model import LinearFit, Term, fit_linear, predict_left_out
from procedures.evidence.residual_rows import Evidence
from procedures.frames import AXES
from procedures.inference import priors
from procedures.inference.board import Block, Board
from procedures.inference.held_out_errors import left_out_groups
from procedures.inference.hypotheses import Library, library_of
from procedures.inference.marginal import gains_of
from procedures.inference.posterior import posterior
from procedures.inference.result import Diagnosis
from procedures.inference.search import Search

MAX_PROPOSALS = 3
FINALISTS = 60  # terms that are searched with all else: the next one is less likely by far more than the window
BLOCK = 800  # terms whose columns are held at a time
TOLERANCE = 2e-3  # of a parameter's logarithm
TIMES_FOUND = 3.0  # a coefficient's plausible size, of the largest found
WIDE = 1e3  # times what one sigma of all rows together is: as good as free
Say = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """A term that this campaign cannot separate from the proposed one: how similar, how much less likely it is.

    ``worse`` is the difference of their ln probabilities.
    """

    term: TermEffect
    similarity: float
    worse: float


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A term with its coefficients (k,) and 1 sigma, parameters last; its probability; what reads the same.

    ``probability`` is that one of the terms acts, the readings included. ``share`` is by how much of its square it
    reduces the error held out, ``held_out`` the rms of its rows' errors left out, in sigmas, without and with it.
    ``candidate`` has its columns, ``columns`` and ``found`` those of every reading, the term's own first.
    """

    term: TermEffect
    coefficients: tuple[str, ...]
    value: FloatArray
    std: FloatArray
    probability: float
    share: float
    held_out: tuple[float, float]
    readings: tuple[Reading, ...]
    candidate: Candidate
    columns: tuple[Term, ...]
    found: tuple[LibraryTerm, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Discovery:
    """What was found beyond a diagnosis' sure findings; ``others`` are their columns, ``tried`` how many terms."""

    proposals: tuple[Proposal, ...]
    tried: int
    evidence: Evidence
    others: tuple[Term, ...]


@clear_caches()
def discover(found: Diagnosis, say: Say = lambda line: None) -> Discovery:
    """Search what a diagnosis of dwells, turns and rests leaves; ``say`` receives its progress."""
    evidence = found.evidence
    sure = {each.effect for each in found.findings if each.probability >= priors.LIKELY}
    others = tuple(each.term for each in found.added[len(found.declared) :] if each.effect.name in sure)
    triads = [name for name in ("accelerometer", "gyroscope") if getattr(found.after, name) is not None]
    if not triads:
        return Discovery((), 0, evidence, others)
    rows, terms = Rows(evidence), library(evidence.excitation, triads)
    say(f"{len(terms)} terms are made")
    known = library_of(evidence, Candidates(evidence, found.after, EFFECTS))
    proposals = list[Proposal]()
    for number in range(MAX_PROPOSALS):
        say(f"{len(terms)} terms are tried{f' in addition to {number} proposed' if number else ''}")
        included = [*others, *(each.columns[0] for each in proposals)]
        one = _likeliest(rows, terms, known, included, number)
        if one is None:
            break
        proposals.append(one)
    return Discovery(tuple(proposals), len(terms), evidence, others)


def fit_as_is(evidence: Evidence, terms: Sequence[Term]) -> LinearFit:
    """Fit terms with the rows' own sigma."""
    return fit_linear(evidence, terms, factor=np.ones(len(evidence.residual)))


def _likeliest(
    rows: Rows, terms: Sequence[LibraryTerm], known: Library, others: Sequence[Term], number: int
) -> Proposal | None:
    """Return the term that is the likeliest cause with others, which are in the model; or None."""
    evidence = rows.evidence
    held = replace(evidence, A=np.hstack([evidence.A, *(-each.H for each in others)]))
    model = Library((), ()).on(held)
    final = _finalists(model, rows, terms)
    ways = {f"term {i}": (term, _candidate(rows, term)) for i, term in enumerate(final)}
    log_odds = _log_odds(terms)
    library = known.with_terms(evidence, [(name, way, log_odds(term)) for name, (term, way) in ways.items()])
    search = Search(library.on(held))
    search.run()
    for cause in posterior(search).causes:
        shares = {name: share for name, share in cause.shares.items() if name in ways}
        if sum(shares.values()) >= priors.PRESENT:
            order = sorted(shares, key=lambda name: -shares[name])
            worse = [float(np.log(shares[order[0]] / shares[name])) for name in order]
            probability = sum(shares.values()) * cause.joint
            return _proposal(rows, [ways[name] for name in order], worse, probability, others, number)
    return None


def _log_odds(terms: Sequence[LibraryTerm]) -> Callable[[LibraryTerm], float]:
    """Return what gives ln of a term's prior odds: the simpler, the likelier."""
    weights = np.array([each.weight for each in terms])
    all_together = float(np.log(priors.ODDS_TERMS) - np.log(np.sum(np.exp(-priors.SIMPLER * weights))))
    return lambda term: all_together - priors.SIMPLER * term.weight


def _finalists(model: Board, rows: Rows, terms: Sequence[LibraryTerm]) -> list[LibraryTerm]:
    """Return the terms that are likeliest by themselves, each once, at its best parameter."""
    worth = np.array([-priors.SIMPLER * each.weight for each in terms])
    kinds = [(len(each.products), each.triad) for each in terms]
    for kind in sorted(set(kinds)):
        numbers = [i for i, each in enumerate(kinds) if each == kind]
        for begin in range(0, len(numbers), BLOCK):
            block = numbers[begin : begin + BLOCK]
            worth[block] += _gains(model, rows.of([terms[i] for i in block]))
    chosen = dict[tuple[str, tuple[str, ...]], LibraryTerm]()
    for i in np.argsort(-worth).tolist():
        if len(chosen) == FINALISTS:
            break
        chosen.setdefault(terms[i].key, terms[i])
    return [_fitted(model, rows, each) for each in chosen.values()]


def _gains(model: Board, W: FloatArray) -> FloatArray:
    """Return ln of the marginal likelihood (t,) of terms W (n, t, k) in sigmas, or their best sensor."""
    inside = np.tensordot(model.basis, W, axes=(0, 0))  # (m, t, k)
    sensors = len(inside[0, 0]) // 3
    found = np.full(W.shape[1], -np.inf)
    for columns in (slice(None), *(slice(axis, None, 3) for axis in range(3))):
        part = np.moveaxis(inside[:, :, columns], 0, 2)  # (t, k, m)
        size = np.linalg.norm(W[:, :, columns], axis=(0, 2))
        part = part / np.maximum(size, np.finfo(float).tiny)[:, None, None]
        G, g = part @ np.swapaxes(part, 1, 2), part @ model.y
        amplitudes = np.tile(priors.OF_NAMELESS, (len(g), 1))
        every, none = np.arange(len(g)), np.zeros((len(g), sensors), np.int64)
        block = Block(every, none, G, g, amplitudes, np.zeros_like(amplitudes), is_loss=False)
        values = gains_of(model, float(model.y @ model.y), G, g, block)
        found = np.maximum(found, np.where(size > 0, np.max(values, axis=1), -np.inf))
    return found


def _fitted(model: Board, rows: Rows, term: LibraryTerm) -> LibraryTerm:
    """Return a term with its parameter where it is likeliest, between its neighbours on the grid."""
    if not term.shape:
        return term
    ((name, shape),) = term.shape.items()

    def less(log: float) -> float:
        return -float(_gains(model, rows.of([at(term, name, float(np.exp(log)))]))[0])

    found = minimize_scalar(
        less, bounds=(np.log(shape.low), np.log(shape.high)), method="bounded", options={"xatol": TOLERANCE}
    )
    best = float(np.exp(found.x)) if found.fun < less(float(np.log(shape.value))) else shape.value
    return at(term, name, best)


def at(term: LibraryTerm, name: str, value: float) -> LibraryTerm:
    """Return a term with its parameter at another value."""
    shape = {name: replace(term.shape[name], value=value)}
    products = tuple(
        tuple(replace(factor, shape=shape) if factor.shape else factor for factor in product)
        for product in term.products
    )
    return LibraryTerm(term.triad, products, shape)


def _candidate(rows: Rows, term: LibraryTerm) -> Candidate:
    """Return a term as a way in which an effect acts, its coefficients in units of one sigma of all rows."""
    W = rows.of([term])[:, 0]
    size = np.linalg.norm(W, axis=0)
    acts = np.flatnonzero(size > 0)
    names = tuple(f"{AXES[i % len(AXES)]}.{i // len(AXES)}" for i in acts.tolist())
    columns = Term(W[:, acts] * rows.evidence.sigma[:, None], 1 / size[acts])
    none = np.zeros(len(rows.evidence.x), dtype=bool)
    return Candidate(term.as_effect("found", 1.0, "").effect(), Columns(names), columns, none)


def _proposal(
    rows: Rows, found: Sequence[tuple[LibraryTerm, Candidate]], worse: Sequence[float], probability: float,
    others: Sequence[Term], number: int,
) -> Proposal:  # fmt: skip
    """Return the likeliest of some terms, the others as its readings; ``worse`` are nats below the likeliest."""
    evidence, terms = rows.evidence, [term for term, _ in found]
    columns = [way.term for _, way in found]
    does = [_does(evidence, others, each) for each in columns]
    similarity = [float(does[0] @ each / (np.linalg.norm(does[0]) * np.linalg.norm(each))) for each in does]
    term, value, std = _solved(evidence, terms[0], others, f"found_{number + 1}")
    before, after = _errors(evidence, columns[0], others, left_out_groups(evidence))
    readings = tuple(
        Reading(each.as_effect(f"reading_{i}", 1.0, "a reading"), same, less)
        for i, (each, same, less) in enumerate(zip(terms, similarity, worse, strict=True))
        if i
    )
    return Proposal(
        term, (*term.coefficients, *term.parameters), value, std, probability,
        max(1 - (after / before) ** 2, 0.0) if before > 0 else 0.0, (before, after), readings, found[0][1],
        tuple(columns), tuple(terms),
    )  # fmt: skip


def _free(term: Term) -> Term:
    return replace(term, plausible=WIDE * term.plausible)


def _does(evidence: Evidence, others: Sequence[Term], columns: Term) -> FloatArray:
    """Return what columns do to the rows (n,) [sigma], fitted with others."""
    c, _ = fit_as_is(evidence, [*others, _free(columns)]).coefficients()
    found: FloatArray = columns.H @ c / evidence.sigma
    return found


def _solved(
    evidence: Evidence, best: LibraryTerm, others: Sequence[Term], name: str
) -> tuple[TermEffect, FloatArray, FloatArray]:
    """Return the term with coefficients and parameters, and their sigmas, by a Gauss-Newton step of all."""
    term = best.as_effect(name, 1.0, "found by station diagnose --discover")
    effect, seen = term.effect(), evidence.excitation
    start = {key: one.value for key, one in best.shape.items()}
    way = term.at(seen, Columns((), nonlinear=start))
    linear = len(way.coefficients) - len(start)
    H = evidence.column(way)[:, :linear]
    size = np.linalg.norm(H / evidence.sigma[:, None], axis=0)
    wide = WIDE / np.maximum(size, np.finfo(float).tiny)
    c = fit_as_is(evidence, [*others, Term(H, wide)]).coefficients()[0]
    bent = with_slope(effect, seen, way, np.append(c, np.zeros(len(start))))
    whole = Term(evidence.column(bent), np.append(wide, np.full(len(start), LOG_RANGE)))
    value, C = fit_as_is(evidence, [*others, whole]).coefficients()
    std = np.sqrt(np.diag(C))
    value = np.append(value[:linear], list(start.values()))  # a parameter stays where it was fitted best
    std = np.append(std[:linear], std[linear:] * list(start.values()))
    plausible = TIMES_FOUND * float(np.max(np.abs(value[:linear])))
    wider = best.as_effect(name, float(f"{plausible:.1g}"), "found by station diagnose --discover")
    return wider, value, std


def _errors(
    evidence: Evidence, term: Term, others: Sequence[Term], left_out: Sequence[IntArray]
) -> tuple[float, float]:
    """Return the rms of errors of the term's rows where they are left out [sigma], without it and with it."""
    rows = evidence.is_data & np.any(term.H != 0, axis=1)

    def rms(fit: LinearFit) -> float:
        errors = predict_left_out(evidence, fit, left_out)[1][rows]
        return float(np.sqrt(np.nanmean(errors**2))) if np.isfinite(errors).any() else 0.0

    return rms(fit_as_is(evidence, others)), rms(fit_as_is(evidence, [*others, _free(term)]))
