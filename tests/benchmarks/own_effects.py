"""Print how effects of one's own do once declared: `python -m tests.benchmarks.own_effects --trials 5`.

Each law of `tests.procedures.effects.terms.laws` that a simulated unit can have is planted at 8 to 20 sigma of
what a coefficient is known to in that campaign, nought where it is hardly known, and solved with its file, its
parameters fitted. p is that of the global test.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import solve
from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign
from procedures.campaign.plan_steps import Turn
from procedures.diagnosis.declared_effects import solve_declared
from procedures.effects.term.effect_of_term import Parameter, TermEffect
from procedures.frames import TURN_START
from tests.drivers.simulated.test_written_term import KNOWN, text_of
from tests.procedures.effects.terms.laws import Law

WARM = {"temperature_rise_k": 8.0, "temperature_tau_s": 600.0, "temperature_swing_k": 3.0,
        "temperature_swing_period_s": 1200.0, "sample_period_s": 0.05}  # fmt: skip
TURNS = tuple(
    Turn(axis, direction, 1, TURN_START[axis], 3.0, speed)
    for axis in "xyz" for direction in "+-" for speed in (12.0, 35.0, 80.0)
)  # fmt: skip
DWELL_S, SOUND_P, HARDLY = 30.0, 1e-3, 100.0


@dataclass(frozen=True)
class Outcome:
    """A trial: was it fitted, p of nothing planted, without and with the file, largest errors in their sigmas."""

    is_fitted: bool
    p_nothing: float = 0.0
    p_without: float = 0.0
    p_with: float = 0.0
    coefficients: float = np.inf
    bias: float = np.inf


def term_of(law: Law, *, is_fixed: bool = False) -> TermEffect:
    """Return a law as a term; its parameters fitted, or held where they are planted."""
    terms = (law.term,) if isinstance(law.term, str) else law.term
    ends = {
        key: (law.at[key], law.at[key]) if is_fixed else (low, high) for key, (_, low, high) in law.shape.items()
    }
    shape = {key: Parameter(law.shape[key][0], *each) for key, each in ends.items()}
    return TermEffect(law.name, law.triad, terms, law.unit, 1e6, law.source, shape)


def campaign_of(truth: Truth, seed: int) -> Campaign:
    """Return a campaign of twelve positions, turns at three speeds, in a certified cube."""
    return simulate_campaign(
        truth, seed, dwell_s=DWELL_S, turns=TURNS, repeats=1, certificate_sigma=2e-6, move_s=30.0
    )


def trial(law: Law, seed: int) -> Outcome:
    """Plant a law in another unit and solve it with its file."""
    rng = np.random.default_rng([seed, 77])
    truth = replace(Truth.example(seed), **WARM)
    nothing = solve_declared([campaign_of(truth, seed)], [term_of(law, is_fixed=True)])
    null, p_nothing = nothing.effects, nothing.solution.quality.p_value
    if not null:
        return Outcome(False)
    linear = [i for i, name in enumerate(null[0].coefficients) if name not in law.shape]
    std = null[0].std[linear]
    told = std < HARDLY * std.min()
    size = rng.uniform(8, 20, len(std)) * rng.choice([-1, 1], len(std)) * np.where(told, std, 0.0)
    name, keys = f"{law.triad}.{law.name}", [null[0].coefficients[i] for i in linear]
    sizes = dict(zip(keys, size.tolist(), strict=True)) | law.at
    planted = campaign_of(replace(truth, effects={name: sizes}, terms={name: text_of(law)}), seed)
    without, found = solve([planted]), solve_declared([planted], [term_of(law)])
    if not found.effects:
        return Outcome(False)
    (effect,) = found.effects
    off = (effect.value - [sizes[key] for key in effect.coefficients]) / effect.std
    return Outcome(
        True, p_nothing, without.quality.p_value, found.solution.quality.p_value, float(np.max(abs(off))),
        bias_error(found.solution, law, truth, seed),
    )  # fmt: skip


def bias_error(solution: Solution, law: Law, truth: Truth, seed: int) -> float:
    """Return the largest error of the triad's bias in its sigmas."""
    power = np.random.default_rng(np.random.SeedSequence(seed).spawn(3)[1])
    on = truth.powered_on(power)
    part = solution.accelerometer if law.triad == "accelerometer" else solution.gyroscope
    if part is None:
        return np.inf
    true = on.accel_d_g if law.triad == "accelerometer" else on.gyro_d_deg_s * 3600
    return float(np.max(abs(part.bias.value - true) / part.bias.std))


def row(law: Law, outcomes: Sequence[Outcome]) -> str:
    """Return a law's line."""
    fitted = [each for each in outcomes if each.is_fitted]
    sound = ("p_nothing", "p_without", "p_with")
    cells = [
        law.name, str(len(outcomes)), str(len(fitted)),
        *(str(sum(getattr(each, name) > SOUND_P for each in fitted)) for name in sound),
        *(" ".join(f"{getattr(each, name):.1f}" for each in fitted) for name in ("coefficients", "bias")),
    ]  # fmt: skip
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Run the trials."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=5, help="campaigns of each law")
    parser.add_argument("--only", default="", help="laws, parted by commas; errors are in sigmas")
    options = parser.parse_args()
    print("| law | campaigns | fitted | p > 0.001 of nothing | without | with it | coefficients off | bias off |")
    print("|---" * 8 + "|")
    for law in (law for law in KNOWN if not options.only or law.name in options.only.split(",")):
        print(row(law, [trial(law, 100 + i) for i in range(options.trials)]), flush=True)


if __name__ == "__main__":
    main()
