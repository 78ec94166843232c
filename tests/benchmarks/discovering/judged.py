"""Whether what was found is the law that was planted: the same function on the campaign's inputs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from drivers.simulated.effects import Planted
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import solve
from procedures.campaign.plan_steps import Step
from procedures.diagnosis.declared_effects import solve_declared
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.linear_model import Term, fit_linear
from procedures.diagnosis.residual_rows import Evidence
from procedures.diagnosis.result import Diagnosis
from procedures.discovery.discover import Discovery, discover
from procedures.discovery.next_plan import next_measurement
from procedures.effects.effect import INSTRUMENT
from station.files.campaign_folder.plan_toml import read_plan
from station.results.diagnosis.next_measurements import Measurement, next_measurements, write_plans
from station.results.diagnosis.next_of_proposals import planned
from tests.benchmarks.discovering.laws import Law
from tests.benchmarks.discovering.planting import Drawn, bare_evidence, beside_model, size_of
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of, carried_out, truth_of

SAME = 0.98  # correlation of what was planted with what the term can do at its best
IN_CATALOGUE = {  # laws that it has had since they were written
    "source warms up": "gyroscope.scale_settling", "bias warms up": "gyroscope.bias_settling",
    "range ends": "gyroscope.counts_lost", "counts lost": "gyroscope.counts_lost",
}  # fmt: skip
SURE = ("established", "likely")


AGAIN, FRESH = 300_000, 600_000  # seeds apart
IN_A_ROOM: dict[str, dict[str, float]] = {  # what a measurement says of the room, added to the truth
    "other_order": {"temperature_start_c": 5.0},
    "heated": {"temperature_rise_k": 15.0, "temperature_tau_s": 1000.0},
    "heating": {"temperature_rise_k": 15.0, "temperature_tau_s": 1000.0},
}


@dataclass(frozen=True)
class Fresh:
    """p of the global test with nothing planted, of the law without and with the file; how far the bias is off.

    ``off`` is against the solve where nothing is planted, the same noise, in sigmas of the solve with the file.
    """

    p_nothing: float
    p_without: float
    p_with: float
    off: float


@dataclass(frozen=True)
class Outcome:
    """A trial: ``word`` is named, a reading, in doubt, other, nothing; what was found; is a wrong name likely?

    In doubt is what leads a group of the catalogue and does the same, or has the law in it.

    ``first`` is the word before the measurement that was asked for, where one was.
    """

    law: str
    seed: int
    word: str
    verdict: str
    is_wrong: bool
    found: str
    seconds: float = 0.0
    first: str = ""
    fresh: Fresh | None = None


@dataclass(frozen=True, eq=False)
class Trial:
    """A unit with a law of a size planted, what was found in it, and what that is worth."""

    truth: Truth
    drawn: Drawn
    size: float
    more: Discovery
    outcome: Outcome

    def planted(self) -> Planted:
        """Return the law for another campaign."""
        return self.drawn.planted(self.size, np.array(self.truth.magnetic_enu_ut))


def searched(law: Law, seed: int) -> Trial:
    """Plant a law in another unit, diagnose and search; once more with what is to be measured next."""
    truth, drawn = truth_of(law.design, seed), Drawn.of(law, seed)
    enu = np.array(truth.magnetic_enu_ut)
    bare = bare_evidence(campaigns_of(truth, law.design, seed).campaigns)
    size = size_of(drawn, bare, seed)
    first = campaigns_of(truth, law.design, seed, drawn.planted(size, enu), stated=truth).campaigns
    found = diagnose(first)
    more = discover(found)
    outcome = judged(drawn, seed, found, more)
    asked = None if outcome.word == "named" else asked_for(found, more)
    if asked is not None:
        room = {name: getattr(truth, name) + by for name, by in IN_A_ROOM.get(asked.name, {}).items()}
        also = drawn.planted(size, enu)
        again = carried_out(replace(truth, **room), law.design, steps_of(asked), seed + AGAIN, also, stated=truth)
        found = diagnose((*first, *again.campaigns))
        more = discover(found)
        later = judged(drawn, seed, found, more)
        said = f"{outcome.found} -> {asked.name} -> {later.found}"
        outcome = replace(later, first=outcome.word, found=said)
    return Trial(truth, drawn, size, more, outcome)


def trial(law: Law, seed: int) -> Outcome:
    """Return what is found of a law, and how a fresh campaign passes the global test with it."""
    one = searched(law, seed)
    return replace(one.outcome, fresh=fresh(one, seed)) if one.more.proposals else one.outcome


def asked_for(found: Diagnosis, more: Discovery) -> Measurement | None:
    """Return the measurement that parts readings, or the one that a doubt about the instrument asks for."""
    if asked := [best.name for one in more.proposals if (best := next_measurement(more, one))]:
        return planned(asked)[0]
    doubts = [
        {
            "effect": one.effect,
            "kind": one.kind,
            "confidence": one.confidence,
            "aliases": one.aliases,
            "where": one.where,
        }
        for one in found.findings
        if one.kind == "instrument" and one.confidence == "ambiguous"
    ]
    wanted = next_measurements(doubts, ("+x", "+y", "+z")) if doubts and not more.proposals else []
    return next((one for one in wanted if one.steps), None)


def steps_of(asked: Measurement) -> list[Step]:
    """Return a measurement's steps as `station calibrate --plan` does them."""
    with TemporaryDirectory() as folder:
        (file,) = write_plans(Path(folder) / "next.toml", [asked])
        return list(read_plan(file))


def fresh(one: Trial, seed: int) -> Fresh:
    """Solve another campaign of the unit with what was proposed, beside a solve of it where nothing is planted."""
    design, terms = one.drawn.law.design, [each.term for each in one.more.proposals]
    with_law = campaigns_of(one.truth, design, seed + FRESH, one.planted(), stated=one.truth).campaigns
    plain = solve(campaigns_of(one.truth, design, seed + FRESH).campaigns)
    without, found = solve(with_law), solve_declared(with_law, terms).solution
    biases = [getattr(each, one.drawn.law.triad).bias for each in (plain, found)]
    off = np.max(np.abs(biases[1].value - biases[0].value) / biases[1].std)
    return Fresh(plain.quality.p_value, without.quality.p_value, found.quality.p_value, float(off))


def judged(drawn: Drawn, seed: int, found: Diagnosis, more: Discovery) -> Outcome:
    """Compare what was proposed with what was planted."""
    does = drawn.done(more.evidence)
    sure = {each.effect for each in found.findings if each.confidence in SURE and each.kind == "instrument"}
    added = [each.term for each in found.added if each.effect.name in sure]
    is_named = bool(added) and likeness(more.evidence, added, does) > SAME
    said = "; ".join([*sorted(sure), *(" & ".join(each.term.terms) for each in more.proposals)])
    word = "named" if is_named else _word(more, does)
    own = [each.term for each in found.added if each.effect.name.split(".")[0] in INSTRUMENT]
    group = {name for each in found.findings for name in (each.effect, *each.aliases)}
    if word == "nothing" and (
        (own and likeness(more.evidence, own, does) > SAME) or IN_CATALOGUE.get(drawn.law.name) in group
    ):
        word = "in doubt"  # of a group of the catalogue
    return Outcome(drawn.law.name, seed, word, found.verdict, bool(sure) and not is_named, said)


def _word(more: Discovery, does: np.ndarray) -> str:
    if not more.proposals:
        return "nothing"
    own = [each.columns[0] for each in more.proposals]
    if likeness(more.evidence, own, does) > SAME:
        return "named"
    for i, each in enumerate(more.proposals):
        for reading in each.columns[1:]:
            if likeness(more.evidence, [*own[:i], reading, *own[i + 1 :]], does) > SAME:
                return "a reading"
    return "other"


def likeness(evidence: Evidence, terms: Sequence[Term], does: np.ndarray) -> float:
    """Return how much of what was planted (n,) terms can do, beside the model, as a correlation."""
    fit = fit_linear(evidence, [], factor=np.ones(len(evidence.residual)))
    H = np.hstack([each.H for each in terms]) / evidence.sigma[:, None]
    left = np.column_stack([beside_model(fit.Q, column) for column in H.T])
    U, s, _ = np.linalg.svd(left, full_matrices=False)
    U = U[:, s > 1e-9 * s[0]]
    wanted = beside_model(fit.Q, does)
    return float(np.linalg.norm(U.T @ wanted) / np.linalg.norm(wanted))
