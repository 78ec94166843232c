"""Campaigns that stop by themselves: minutes beside the plan, and coverage.

``python -m tests.benchmarks.sequential_plan --campaigns 500 --asked gyro``

Every campaign is of a unit whose white noise is off the model's by a factor of its own (sigma 0.25 of its
logarithm), which the rule learns from the first dwell on. Which placing comes next is asked for the noise of the
first dwell rounded to a grid of 5 %, so that few searches do for many campaigns; when a dwell ends, when the
campaign is over and every sigma are by the noise as it was learned. Biases wander from step to step, with
``--tau 200`` as a Gauss-Markov process of so many seconds. Errors are those of the linear fit of what was done.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np

from procedures.bench.dwell_length import SHORTEST_S
from procedures.planning.campaign_design import CampaignDesign, Placing, usual_design
from procedures.planning.design_sigmas import DesignSigmas
from procedures.planning.least_time import least_time
from procedures.planning.placing_rows import BENCH, OWN, SHARED
from procedures.planning.sequential import NextPlacing, is_enough, next_placing
from procedures.planning.step_information import TOLD
from procedures.planning.wanted_sigmas import WantedSigmas, with_all_solved
from tests.procedures.planning.bench_of_moves import OFF_DIAGONAL, accelerometer_bias, bench, gyroscopes, unit

NO_TIME_S = 1e-3  # s: of a wander that is another in every step
LEAST_SIGMA = 1e-30  # of an element of E that is one by definition
SPREAD, GRID, SAMPLES_PER_S = 0.25, 1.05, 50.0
ASKED = {
    "gyro": gyroscopes(bias=0.02),
    "accel": accelerometer_bias(1e-7),
    "accel-1ug": accelerometer_bias(1e-6),
    "both": gyroscopes(k=4e-6, bias=0.025),
}
ROWS = {
    "gyro k": [15, 16, 17],
    "gyro E": [15 + i for i in OFF_DIAGONAL],
    "gyro D": [27, 28, 29],
    "accel D": [12, 13, 14],
}


def main() -> None:
    """Draw campaigns and print minutes and coverage."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=500)
    parser.add_argument("--asked", choices=ASKED, default="gyro")
    parser.add_argument("--tau", type=float, default=0.0, help="s, of the wander; 0: from step to step")
    asked = parser.parse_args()
    ratios, minutes, fixed = [], [], []
    for seed in range(asked.campaigns):
        rng = np.random.default_rng(seed)
        factor = float(np.exp(SPREAD * rng.standard_normal()))
        done, seen = followed(asked.asked, factor, rng)
        engine, design = of_noise(factor), CampaignDesign(tuple(done))
        stated = of_noise(seen).of(design)
        ratios.append(errors(engine, design, asked.tau, rng) / np.maximum(stated, LEAST_SIGMA))
        minutes.append(design.minutes(engine.steps.hands))
        fixed.append(planned_minutes(asked.asked, grid(factor)))
    told = np.array(ratios)
    mean = f"{np.mean(minutes):.1f} min, planned with the noise known {np.mean(fixed):.1f}"
    print(f"{asked.asked}: {asked.campaigns} campaigns, {mean}")
    for name, rows in ROWS.items():
        off, held = np.sqrt(np.mean(told[:, rows] ** 2)), np.mean(np.abs(told[:, rows]) < 1.96)
        print(f"{name:8s} rms of error / sigma {off:.2f}   within 1.96 sigma {held:.1%}")
    told = told[:, [row for rows in ROWS.values() for row in rows]]
    print(f"all of these within 1.96 sigma: {np.mean(np.abs(told) < 1.96):.1%}")


def of_noise(factor: float) -> DesignSigmas:
    """The bench with a unit whose white noise is that of the model times a factor."""
    usual = unit()
    noise = replace(usual, accel_white=usual.accel_white * factor, gyro_white=usual.gyro_white * factor)
    return DesignSigmas(the_bench().steps.with_noise(noise))


@cache
def the_bench() -> DesignSigmas:
    """The bench with the model's unit."""
    return bench(unit())


@cache
def wanted(asked: str) -> WantedSigmas:
    """What is wanted, the rest as well as with the model's noise."""
    return with_all_solved(ASKED[asked], of_noise(1.0).of(usual_design()))


@cache
def step(asked: str, factor: float, done: tuple[Placing, ...]) -> NextPlacing:
    """The rule's answer; the same of the same."""
    return next_placing(of_noise(factor), wanted(asked), done)


@cache
def planned_minutes(asked: str, factor: float) -> float:
    """How long the fixed plan for a noise of the grid takes."""
    engine = of_noise(factor)
    return least_time(engine, wanted(asked), turns=False).design.minutes(engine.steps.hands)


def grid(factor: float) -> float:
    """The nearest step of the grid: few different noises, few different searches."""
    return float(GRID ** np.round(np.log(factor) / np.log(GRID)))


def followed(asked: str, factor: float, rng: np.random.Generator) -> tuple[list[Placing], float]:
    """Do what the rule asks for until it stops; return that, and the noise as it was estimated at the end."""
    done, seen, usual = list[Placing](), 1.0, 1.0
    while (following := step(asked, usual, tuple(done)).placing) is not None:
        samples = SAMPLES_PER_S * sum(at.seconds for at in (*done, following))
        seen = factor * (1 + rng.standard_normal() / np.sqrt(2 * samples))
        done.append(as_long_as_it_pays(of_noise(seen), wanted(asked), done, following))
        usual = usual if len(done) > 1 else grid(seen)
        if is_enough(of_noise(seen), wanted(asked), CampaignDesign(tuple(done))):
            break
    return done, seen


def as_long_as_it_pays(
    engine: DesignSigmas, asked: WantedSigmas, done: list[Placing], placing: Placing
) -> Placing:
    """Return a dwell as long as it lasts: to the second in which all is met, at most its own length."""
    low, high = SHORTEST_S, placing.seconds
    if not is_enough(engine, asked, CampaignDesign((*done, placing))):
        return placing
    while high - low > 1:
        middle = (low + high) / 2
        met = is_enough(engine, asked, CampaignDesign((*done, replace(placing, seconds=middle))))
        low, high = (low, middle) if met else (middle, high)
    return replace(placing, seconds=high)


def errors(engine: DesignSigmas, design: CampaignDesign, tau: float, rng: np.random.Generator) -> np.ndarray:
    """Return the errors (30,) of a fit of what was done."""
    steps, places = engine.steps, design.placings
    seconds = np.array([at.seconds for at in places])
    n = OWN * len(places)
    wander = gauss_markov(design, engine, tau, rng)
    accel = np.sqrt(steps.noise.accel_variance(seconds)) * rng.standard_normal((len(places), 3))
    calm = replace(steps.noise, wander=0.0)
    gyro = np.sqrt(calm.gyro_variance(seconds)) * rng.standard_normal((len(places), 3)) + wander[::2]
    moved = np.sqrt(calm.move_variance(steps.hands.move)) * rng.standard_normal((len(places) - 1, 3))
    moved += np.radians(wander[1::2]) * steps.hands.move
    N, b = np.zeros((n + SHARED, n + SHARED)), np.zeros(n + SHARED)
    M, c = np.zeros((len(TOLD), len(TOLD))), np.zeros(len(TOLD))
    shared = np.arange(n, n + SHARED)

    def add(rows: np.ndarray, columns: np.ndarray, error: np.ndarray, variance: np.ndarray) -> None:
        N[np.ix_(columns, columns)] += rows.T @ (rows / variance[:, None])
        b[columns] += rows.T @ (error / variance)

    weight = steps.noise
    for i, at in enumerate(places):
        columns = np.concatenate((np.arange(OWN * i, OWN * (i + 1)), shared))
        own = np.array([steps.campaign.sigma.heading, steps.campaign.sigma.seat, steps.campaign.sigma.seat, 1e-9])
        add(np.eye(OWN), columns[:OWN], own * rng.standard_normal(OWN), own**2)
        variance = weight.accel_variance(seconds[i : i + 1])[0]
        rows = steps.rows.accel[at.position - 1]
        add(rows, columns, accel[i], variance)
        add(steps.rows.gyro[at.position - 1], columns, gyro[i], weight.gyro_variance(seconds[i : i + 1])[0])
        told = rows[:, OWN:][:, TOLD]
        M += told.T @ (told / variance[:, None])
        c += told.T @ (accel[i] / variance)
    for i, (before, after) in enumerate(pairwise(places)):
        columns = np.concatenate((np.arange(OWN * i, OWN * (i + 2)), shared))
        rows = steps.rows.move[before.position - 1, after.position - 1]
        add(rows, columns, moved[i], np.full(3, weight.move_variance(steps.hands.move)))
    known = [steps.bench(moves).priors().matrix[:, : steps.rows.bench.shared] for moves in (False, True)]
    add(known[1], shared[BENCH], rng.standard_normal(len(known[1])), np.ones(len(known[1])))
    M += engine.known[False][np.ix_(TOLD, TOLD)]
    c[12:] += known[0].T @ rng.standard_normal(len(known[0]))
    gyroscopes_off = engine.gyroscope_vector[0] @ solved(N, b)[n:]
    return np.concatenate((engine.accelerometer_vector[0] @ solved(M, c), gyroscopes_off))


def solved(N: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Solve normal equations whose columns differ in size."""
    scale = 1 / np.sqrt(np.diag(N))
    return scale * np.linalg.solve(N * np.outer(scale, scale), b * scale)


def gauss_markov(design: CampaignDesign, engine: DesignSigmas, tau: float, rng: np.random.Generator) -> np.ndarray:
    """Return the bias (2 n - 1, 3) [deg/s] in the middle of every dwell and every move, in turn."""
    hands, lengths = engine.steps.hands, list[float]()
    for at in design.placings:
        lengths += [at.seconds, hands.placing]
    ends = np.cumsum(lengths[:-1])
    middle = ends - np.array(lengths[:-1]) / 2
    covariance = engine.steps.noise.wander**2 * np.exp(
        -np.abs(np.subtract.outer(middle, middle)) / max(tau, NO_TIME_S)
    )
    L: Sequence[Sequence[float]] = np.linalg.cholesky(covariance + 1e-20 * np.eye(len(middle)))
    return np.asarray(L) @ rng.standard_normal((len(middle), 3))


if __name__ == "__main__":
    main()
