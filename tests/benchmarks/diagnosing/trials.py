"""One trial: a campaign with something planted, diagnosed, and what became of the name."""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drivers.simulated.truth import Truth
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis
from tests.benchmarks.diagnosing.coefficients import error_of
from tests.benchmarks.diagnosing.designs import CERTIFIED, DESIGNS, unit
from tests.benchmarks.diagnosing.outside import outside
from tests.benchmarks.diagnosing.plants import LEAST, MOST, PLANTS, Sizes, drawn_sizes
from tests.benchmarks.diagnosing.sigmas import Sigmas


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one trial.

    ``word``: right (alone), group, missed, wrong, false alarm (of nothing planted, an instrument accused), odd (of
    nothing planted, something else of the procedure or bench claimed). ``worst``: error of a coefficient over its
    sigma, nan where none compares. ``seconds`` of CPU.
    """

    effect: str
    seed: int
    word: str
    named: tuple[str, ...]
    worst: float
    verdict: str
    seconds: float
    is_alone: bool = False


def planted(name: str, sigmas: Sigmas, seed: int) -> Outcome:
    """Plant one effect, on one coefficient or on several, and diagnose."""
    plant = PLANTS[name]
    sizes = drawn_sizes(name, sigmas, np.random.default_rng([seed, 5]), LEAST, MOST)
    truth, diagnosis, seconds = diagnosed(plant.design, seed, {plant.effect: sizes})
    word = judge(diagnosis, (plant.effect,), plant.design)[plant.effect]
    found = [f for f in diagnosis.findings if f.effect == plant.effect]
    worst = min((error_of(each, sizes, truth) for each in found), default=float("nan"))
    alone = any(f.confidence != "ambiguous" or set(f.aliases) <= set(plant.but_for) for f in found)
    return Outcome(name, seed, word, _names(diagnosis), worst, diagnosis.verdict, seconds, alone)


def diagnosed(design: str, seed: int, effects: Mapping[str, Sizes]) -> tuple[Truth, Diagnosis, float]:
    """Plant effects in a design and diagnose; return what was true, the diagnosis and its CPU time [s]."""
    made = DESIGNS[design]
    truth = unit(seed, **made.truth, effects=effects)
    campaigns = made.make(truth, seed, ())
    begun = time.process_time()
    return truth, diagnose(campaigns), time.process_time() - begun


def judge(diagnosis: Diagnosis, effects: tuple[str, ...], design: str) -> dict[str, str]:
    """Return the word for what was found of each planted effect.

    Wrong is a finding, or a group, in which there is nothing true; every bench here has a tilted slab, and faces
    that no certificate states unless it has one.
    """
    if untrue(diagnosis, (*effects, *of_bench(design))):
        return dict.fromkeys(effects, "wrong")
    found = dict[str, str]()
    for effect in effects:
        groups = [f for f in diagnosis.findings if effect in {f.effect, *f.aliases}]
        alone = any(f.effect == effect and f.confidence != "ambiguous" for f in groups)
        found[effect] = "right" if alone else "group" if groups else "missed"
    return found


def untrue(diagnosis: Diagnosis, true: tuple[str, ...]) -> list[str]:
    """Return the findings that name nothing true, nor hold it in their group."""
    return [f.effect for f in diagnosis.findings if not {f.effect, *f.aliases} & set(true)]


def of_bench(design: str) -> tuple[str, ...]:
    """Return what is true of every bench of a design, unplanted."""
    return ("slab.tilt",) if design in CERTIFIED else ("slab.tilt", "fixture.parallelism", "fixture.face_tilt")


def accused(diagnosis: Diagnosis) -> list[str]:
    """Return what is claimed of the instrument."""
    return [f.effect for f in diagnosis.findings if f.kind == "instrument" and f.confidence != "ambiguous"]


def unheard(name: str, seed: int) -> Outcome:
    """Diagnose a campaign with an effect of no catalogue in it."""
    size = float(np.random.default_rng([seed, 9]).uniform(1.5e-6, 4e-6)) * (1.0 if "heading" in name else 0.3)
    made = DESIGNS["warm" if "temperature" in name else "plain"]
    campaigns = made.make(unit(seed, **made.truth), seed, outside(name, size))
    begun = time.process_time()
    diagnosis = diagnose(campaigns)
    word = "wrong" if untrue(diagnosis, of_bench("plain")) else "missed"
    word = "unexplained" if diagnosis.verdict == "unexplained" and word != "wrong" else word
    seconds = time.process_time() - begun
    return Outcome(f"outside, {name}", seed, word, _names(diagnosis), float("nan"), diagnosis.verdict, seconds)


def _names(diagnosis: Diagnosis) -> tuple[str, ...]:
    return tuple(f.effect + ("?" if f.confidence == "ambiguous" else "") for f in diagnosis.findings)
