"""Print how a proposal does on a fresh campaign of its unit: `python -m tests.benchmarks.discovery_used`.

Each law of `tests.benchmarks.discovering.laws` is planted and looked for in one campaign; where it is not named,
in that and the steps that are to be measured next. What is proposed is in the model of another, in another order,
at other headings and 6 K warmer, beside a solve with the law itself in the model, its coefficients fitted (what a
solve is worth that knows the law), and one of the same noise where nothing is planted.
`docs/discovering-effects.md` is the page.
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import solve
from procedures.calibration.solution_values import Solution
from procedures.diagnosis.declared_effects import solve_declared
from procedures.units import DEG_H_PER_DEG_S
from tests.benchmarks.discovering.forms import known
from tests.benchmarks.discovering.judged import FRESH, searched
from tests.benchmarks.discovering.laws import LAWS, Law
from tests.benchmarks.undeclared_kinds.campaigns import campaigns_of

WARMER_K, SOUND_P, COVERAGE = 6.0, 1e-3, 1.959964
SOLVES = {
    "bare": "where nothing is planted", "known": "that knows the law", "without": "without it",
    "found": "with what was found",
}  # fmt: skip
OFF_DIAGONAL = ~np.eye(3, dtype=bool)


@dataclass(frozen=True, eq=False)
class Used:
    """A trial: the word of what was found, p of the global test and errors in their sigmas, of each solve.

    ``bare`` is where nothing is planted; where the law is, ``without`` it in the model, with the law as it is
    ``known``, and as ``found``. Errors are (n,) of the law's triad by parameter, in sigmas of the bare one; of
    misalignments, whose frame the faces make, from the bare one.
    """

    law: str
    seed: int
    word: str
    said: str
    is_wrong: bool
    p: dict[str, float]
    errors: dict[str, dict[str, FloatArray]]


def used(law: Law, seed: int) -> Used:
    """Find a law, with the measurement that is asked for, and solve another campaign with what was found."""
    one = searched(law, seed)
    word, said = one.outcome.word, one.outcome.found
    word = f"{word}, after {one.outcome.first}" if one.outcome.first else word
    if not one.more.proposals:
        return Used(law.name, seed, word, said, one.outcome.is_wrong, {}, {})
    truth = one.truth
    warmer = replace(truth, temperature_start_c=truth.temperature_start_c + WARMER_K)
    later = campaigns_of(warmer, law.design, seed + FRESH, one.planted(), stated=truth).campaigns
    solved = {
        "bare": solve(campaigns_of(warmer, law.design, seed + FRESH, stated=truth).campaigns),
        "without": solve(later),
        "known": solve_declared(later, [known(law)]).solution,
        "found": solve_declared(later, [each.term for each in one.more.proposals]).solution,
    }
    p = {name: each.quality.p_value for name, each in solved.items()}
    errors = {name: errors_of(each, solved["bare"], truth, law.triad) for name, each in solved.items()}
    return Used(law.name, seed, word, said, one.outcome.is_wrong, p, errors)


def errors_of(found: Solution, bare: Solution, truth: Truth, triad: str) -> dict[str, FloatArray]:
    """Return a triad's errors by parameter, in 1 sigma of the bare solve; and in its own, by `` own``."""
    own, best = (getattr(one, triad) for one in (found, bare))
    bias, k = (
        (truth.accel_d_g, truth.accel_k) if triad == "accelerometer"
        else (truth.gyro_d_deg_s * DEG_H_PER_DEG_S, truth.gyro_k)
    )  # fmt: skip
    off = {
        "bias": (own.bias.value - bias, own.bias.std, best.bias.std),
        "scale factor": (own.scale_factor.value - k, own.scale_factor.std, best.scale_factor.std),
        "misalignment": tuple(
            part[OFF_DIAGONAL]
            for part in (
                own.misalignment.value - best.misalignment.value,
                own.misalignment.std,
                best.misalignment.std,
            )
        ),
    }
    return {name: error / std for name, (error, _, std) in off.items()} | {
        f"{name} own": error / std for name, (error, std, _) in off.items()
    }


def table(every: Sequence[Used]) -> list[str]:
    """Return the lines of what came out of all trials."""
    words = Counter(each.word for each in every)
    told = [each for each in every if each.p and each.p["bare"] > SOUND_P]
    lines = [f"{len(every)} campaigns: {', '.join(f'{word} {n}' for word, n in words.most_common())}"]
    lines += [
        f"global test above {SOUND_P}: {sum(each.p[name] > SOUND_P for each in told)} of {len(told)}, {name}"
        for name in ("without", "known", "found")
    ]
    for name in ("bias", "scale factor", "misalignment"):
        rms = {
            how: float(np.sqrt(np.mean(np.concatenate([each.errors[how][name] for each in told]) ** 2)))
            for how in SOLVES
        }
        own = np.concatenate([each.errors["found"][f"{name} own"] for each in told])
        said = ", ".join(f"{title} {rms[how]:.2f}" for how, title in SOLVES.items())
        lines.append(
            f"{name}: rms error in sigmas of a bare solve {said}, {rms['found'] / rms['known']:.2f} times; "
            f"inside U {np.mean(np.abs(own) < COVERAGE):.1%} of {len(own)}"
        )
    return lines


def main() -> None:
    """Run the trials."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=1, help="campaigns of each law")
    parser.add_argument("--first", type=int, default=70_000, help="the first seed")
    parser.add_argument("--only", default="", help="a part of the law's name")
    told, every = parser.parse_args(), list[Used]()
    for number, law in enumerate(LAWS):
        for seed in range(told.trials if told.only in law.name else 0):
            every.append(one := used(law, told.first + 1000 * number + seed))
            p = " ".join(f"{name} {value:.2g}" for name, value in one.p.items())
            worst = [
                max((float(np.abs(each).max()) for each in one.errors.get(name, {}).values()), default=0.0)
                for name in ("known", "found")
            ]
            wrong = "wrong" if one.is_wrong else ""
            most = f"{worst[0]:.1f} {worst[1]:.1f}"
            print(f"{one.law} | {one.seed} | {one.word} | {wrong} | {p} | {most} | {one.said}", flush=True)
    if any(each.p for each in every):
        print("\n".join(table(every)))


if __name__ == "__main__":
    main()
