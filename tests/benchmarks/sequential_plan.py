"""Campaigns that stop by themselves: minutes beside the plan, and coverage.

``python -m tests.benchmarks.sequential_plan --campaigns 500``

Every campaign is of a unit whose white noise is off the model's by a factor of its own (sigma 0.25 of its
logarithm), which the rule learns from the first dwell on. Biases wander as a Gauss-Markov process of 200 s. Errors
are those of the linear fit of what was done.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np

from procedures.planning.campaign_design import CampaignDesign, Placing, usual_design
from procedures.planning.design_sigmas import DesignSigmas
from procedures.planning.least_time import least_time
from procedures.planning.placing_rows import BENCH, OWN, SHARED
from procedures.planning.sequential import NextPlacing, next_placing
from procedures.planning.step_information import TOLD
from procedures.planning.wanted_sigmas import WantedSigmas, with_all_solved
from tests.procedures.planning.bench_of_moves import OFF_DIAGONAL, accelerometer_bias, bench, gyroscopes, unit

LEAST_SIGMA = 1e-30  # of an element of E that is one by definition
SPREAD, GRID, TAU_S, SAMPLES_PER_S = 0.25, 1.1, 200.0, 50.0
ASKED = {"gyro": gyroscopes(bias=0.02), "accel": accelerometer_bias(1e-7), "both": gyroscopes(k=4e-6, bias=0.025)}
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
    asked = parser.parse_args()
    ratios, minutes, fixed = [], [], []
    for seed in range(asked.campaigns):
        rng = np.random.default_rng(seed)
        factor = float(np.exp(SPREAD * rng.standard_normal()))
        done = followed(asked.asked, factor, rng)
        engine, design = of_noise(factor), CampaignDesign(tuple(done))
        ratios.append(errors(engine, design, rng) / np.maximum(engine.of(design), LEAST_SIGMA))
        minutes.append(design.minutes(engine.steps.hands))
        fixed.append(planned_minutes(asked.asked, grid(factor)))
    told = np.array(ratios)
    mean = f"{np.mean(minutes):.1f} min, planned with the noise known {np.mean(fixed):.1f}"
    print(f"{asked.asked}: {asked.campaigns} campaigns, {mean}")
    for name, rows in ROWS.items():
        off, held = np.sqrt(np.mean(told[:, rows] ** 2)), np.mean(np.abs(told[:, rows]) < 1.96)
        print(f"{name:8s} rms of error / sigma {off:.2f}   within 1.96 sigma {held:.1%}")


@cache
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
    """How long the fixed plan for this noise takes."""
    engine = of_noise(factor)
    return least_time(engine, wanted(asked), turns=False).design.minutes(engine.steps.hands)


def grid(factor: float) -> float:
    """The next step of the grid upwards: few different noises, few different searches."""
    return float(GRID ** np.ceil(np.log(factor) / np.log(GRID)))


def followed(asked: str, factor: float, rng: np.random.Generator) -> list[Placing]:
    """Do what the rule asks for until it stops; from the first dwell on the noise is estimated."""
    done, seen = list[Placing](), 1.0
    while (following := step(asked, seen, tuple(done)).placing) is not None:
        done.append(following)
        samples = SAMPLES_PER_S * sum(at.seconds for at in done)
        seen = grid(factor * (1 + rng.standard_normal() / np.sqrt(2 * samples)))
    return done


def errors(engine: DesignSigmas, design: CampaignDesign, rng: np.random.Generator) -> np.ndarray:
    """Return the errors (30,) of a fit of what was done."""
    steps, places = engine.steps, design.placings
    seconds = np.array([at.seconds for at in places])
    n = OWN * len(places)
    wander = gauss_markov(design, engine, rng)
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


def gauss_markov(design: CampaignDesign, engine: DesignSigmas, rng: np.random.Generator) -> np.ndarray:
    """Return the bias (2 n - 1, 3) [deg/s] in the middle of every dwell and every move, in turn."""
    hands, lengths = engine.steps.hands, list[float]()
    for at in design.placings:
        lengths += [at.seconds, hands.placing]
    ends = np.cumsum(lengths[:-1])
    middle = ends - np.array(lengths[:-1]) / 2
    covariance = engine.steps.noise.wander**2 * np.exp(-np.abs(np.subtract.outer(middle, middle)) / TAU_S)
    L: Sequence[Sequence[float]] = np.linalg.cholesky(covariance + 1e-20 * np.eye(len(middle)))
    return np.asarray(L) @ rng.standard_normal((len(middle), 3))


if __name__ == "__main__":
    main()
