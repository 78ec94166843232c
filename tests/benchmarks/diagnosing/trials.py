"""One trial: a campaign with something planted, diagnosed, and what became of the name."""

from dataclasses import dataclass

import numpy as np

from procedures.diagnosis.diagnose import diagnose
from procedures.inference.result import Diagnosis
from tests.benchmarks.diagnosing.coefficients import error_of
from tests.benchmarks.diagnosing.designs import CERTIFIED, DESIGNS, unit
from tests.benchmarks.diagnosing.outside import outside
from tests.benchmarks.diagnosing.plants import LEAST, MOST, PLANTS, drawn_sizes
from tests.benchmarks.diagnosing.sigmas import Sigmas


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one trial.

    ``word``: right (alone), group, missed, wrong, unexplained; of nothing planted: right, false alarm (the
    instrument is accused), odd (something else untrue). ``worst``: error of a coefficient over its u, or nan.
    """

    word: str
    worst: float = float("nan")


def planted(name: str, sigmas: Sigmas, seed: int) -> Outcome:
    """Plant one effect, on one coefficient or on several, and diagnose."""
    plant = PLANTS[name]
    sizes = drawn_sizes(name, sigmas, np.random.default_rng([seed, 5]), LEAST, MOST)
    made = DESIGNS[plant.design]
    truth = unit(seed, **made.truth, effects={plant.effect: sizes})
    diagnosis = diagnose(made.make(truth, seed, ()))
    found = [f for f in diagnosis.findings if f.effect == plant.effect]
    groups = [f for f in diagnosis.findings if plant.effect in {f.effect, *f.aliases}]
    is_alone = any(f.confidence != "possible" for f in found)
    word = "right" if is_alone else "group" if groups else "missed"
    if untrue(diagnosis, (plant.effect, *of_bench(plant.design))):
        word = "wrong"
    return Outcome(word, min((error_of(each, sizes, truth) for each in found), default=float("nan")))


def nothing(design: str, seed: int) -> Outcome:
    """Diagnose a campaign with nothing planted."""
    made = DESIGNS[design]
    diagnosis = diagnose(made.make(unit(seed, **made.truth), seed, ()))
    claims = [f for f in diagnosis.findings if f.kind == "instrument" and f.confidence != "possible"]
    return Outcome("false alarm" if claims else "odd" if untrue(diagnosis, of_bench(design)) else "right")


def unheard(name: str, seed: int) -> Outcome:
    """Diagnose a campaign with an effect of no catalogue in it."""
    size = float(np.random.default_rng([seed, 9]).uniform(1.5e-6, 4e-6)) * (1.0 if "heading" in name else 0.3)
    made = DESIGNS["warm" if "temperature" in name else "plain"]
    diagnosis = diagnose(made.make(unit(seed, **made.truth), seed, outside(name, size)))
    word = "wrong" if untrue(diagnosis, of_bench("plain")) else "missed"
    return Outcome("unexplained" if diagnosis.verdict == "unexplained" and word != "wrong" else word)


def untrue(diagnosis: Diagnosis, true: tuple[str, ...]) -> list[str]:
    """Return the findings that name nothing true, nor hold it in their group."""
    return [f.effect for f in diagnosis.findings if not {f.effect, *f.aliases} & set(true)]


def of_bench(design: str) -> tuple[str, ...]:
    """Return what is true of every bench of a design, unplanted."""
    return ("slab.tilt",) if design in CERTIFIED else ("slab.tilt", "fixture.parallelism", "fixture.face_tilt")
