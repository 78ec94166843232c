"""Print whether the loop closes: `python -m tests.benchmarks.closed_loop --seeds 30`.

The same campaigns, with and without an effect in them: how far the biases are from the truth when the effect is
there undeclared, when the diagnosis has added it, and when it was never there. Asked: 1.5 times as far at most.
"""

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np

from procedures.calibration.joint_calibration import fit_reduced, report
from procedures.calibration.reduced_steps import reduce_steps
from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.candidates import Candidate, Candidates
from procedures.diagnosis.refit import refit
from procedures.diagnosis.residual_rows import evidence_of
from procedures.diagnosis.result import Finding
from procedures.effects import EFFECTS
from tests.benchmarks.diagnosing.designs import DESIGNS, unit
from tests.benchmarks.diagnosing.plants import PLANTS, drawn_sizes
from tests.benchmarks.diagnosing.sigmas import Sigmas, sigmas_of
from tests.benchmarks.diagnosing.trials import diagnosed

ASKED = 1.5
HEAD = (
    "| effect | established | bias error before | after | never there | after / never there"
    " | after / never there but solved for | asked <= 1.5 |\n|---|---|---|---|---|---|---|---|"
)
NAMES = (
    "accelerometer.quadratic, certificate",
    "accelerometer.quadratic, separated",
    "accelerometer.cubic, separated",
    "accelerometer.scale_asymmetry, separated",
    "accelerometer.cross_product, separated",
    "accelerometer.bias_temperature",
    "accelerometer.bias_temperature, certified",
    "accelerometer.bias_drift",
    "accelerometer.bias_drift, certified",
    "accelerometer.relaxation",
    "gyroscope.g_sensitivity",
    "gyroscope.bias_temperature",
    "gyroscope.temperature_rate",
    "gyroscope.bias_drift",
    "gyroscope.magnetic",
    "gyroscope.scale_asymmetry",
    "placement.dwell",
    "disturbance.dwell",
    "placement.label",
)


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """How the effect was called, and errors of the biases (3,) [g or deg/h].

    ``before``: the effect is there, undeclared; ``after``: it was added; ``without``: never there; ``asked``:
    never there, but solved for all the same, which is what asking for it costs in this design.
    """

    called: str
    before: np.ndarray
    after: np.ndarray
    without: np.ndarray
    asked: np.ndarray


def loop(name: str, sigmas: Sigmas, seed: int) -> Loop:
    """Diagnose a unit with an effect, solve it without."""
    plant = PLANTS[name]
    sizes = drawn_sizes(name, sigmas, np.random.default_rng([seed, 5]))
    truth, found, _ = diagnosed(plant.design, seed, {plant.effect: sizes})
    made = DESIGNS[plant.design]
    without, asked = _solved(made.make(unit(seed, **made.truth), seed, ()), found.added)
    is_gyro = plant.effect.startswith("gyroscope")
    bias = truth.gyro_d_deg_s * 3600 if is_gyro else truth.accel_d_g
    errors = (_bias(each, is_gyro) - bias for each in (found.solution_before, found.solution, without, asked))
    return Loop(_called(found.findings, plant.effect, plant.but_for), *errors)


def _solved(campaigns: Sequence[Campaign], added: Sequence[Candidate]) -> tuple[Solution, Solution]:
    """Solve campaigns as they are, and with the same effects in the model."""
    steps = reduce_steps(campaigns)
    base = fit_reduced(steps)
    pool = Candidates(evidence_of(base), base, EFFECTS)
    ways = [
        way
        for each in added
        for way in pool.get(each.effect.name, ())
        if (way.columns.where, way.columns.shape) == (each.columns.where, each.columns.shape)
    ]
    return report(base), report(refit(steps, base, ways).fits)


def _bias(solution: Solution, is_gyro: bool) -> np.ndarray:
    triad = solution.gyroscope if is_gyro else solution.accelerometer
    assert triad is not None
    return triad.bias.value


def _called(findings: Sequence[Finding], effect: str, but_for: Sequence[str]) -> str:
    """Return how sure the effect's name was; a name but for what nothing there can tell counts as sure."""
    for each in findings:
        if each.effect == effect:
            return "established" if set(each.aliases) == set(but_for) & set(each.aliases) else "ambiguous"
        if effect in each.aliases:
            return "ambiguous"
    return "not found"


def row(name: str, loops: Sequence[Loop]) -> str:
    """Return a line of the rms errors of the loops that were closed, and their ratios."""
    closed = [each for each in loops if each.called == "established"]
    said = f"| {name} | {len(closed)} of {len(loops)} | "
    if not closed:
        return said + "- | - | - | - | - | never established |"
    before, after, without, asked = (
        float(np.sqrt(np.mean(np.array([getattr(each, part) for each in closed]) ** 2)))
        for part in ("before", "after", "without", "asked")
    )
    unit_, per = ("deg/h", 1.0) if name.startswith("gyroscope") else ("ug", 1e6)
    met = "pass" if after / without <= ASKED else "FAIL"
    met = "FAIL, as well as the design can" if met == "FAIL" and after / asked <= ASKED else met
    cells = (f"{before * per:.3g} {unit_}", f"{after * per:.3g}", f"{without * per:.3g}", f"{after / without:.2f}",
             f"{after / asked:.2f}", met)  # fmt: skip
    return said + " | ".join(cells) + " |"


def main() -> None:
    """Print a row per effect."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--only", default="", help="a part of the name")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    print(HEAD)
    with ProcessPoolExecutor(options.processes) as pool:
        for name in NAMES:
            if options.only in name:
                plant = PLANTS[name]
                sigmas = sigmas_of(plant.effect, plant.design, plant.beside, plant.but_for)
                seeds = range(options.first, options.first + options.seeds)
                print(row(name, list(pool.map(partial(loop, name, sigmas), seeds))), flush=True)


if __name__ == "__main__":
    main()
