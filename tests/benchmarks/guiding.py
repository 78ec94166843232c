"""Print a table of docs/guiding.md: `python -m tests.benchmarks.guiding TABLE --trials N`."""

import argparse
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import product
from time import perf_counter

import numpy as np

from drivers.simulated.bench_in_memory import SimulatedBench, simulate_campaign, turn_segment, world_with_effects
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.bench.dwell_length import dwell_seconds
from procedures.bench.seating_check import PositionRates, judge, seating
from procedures.bench.turn_closing import MAX_TURNS_PER_AXIS, Closing, TurnCounts, judge_closing
from procedures.bench.warm_up import IntervalMeans, warm_up
from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Fixture, TurnRecord
from procedures.campaign.plan_steps import Dwell, Turn
from procedures.counts.count_rate import estimate_counts
from procedures.counts.sample_records import CountSeries
from procedures.earth.gravity_and_rate import earth_rate_n
from procedures.earth.gyrocompass import CertainDwell, QuarterHeading, find_heading
from procedures.frames import cross_axes, face_normal, face_of, nominal_C_lb, vertical_rotation
from procedures.units import RAD_PER_ARCSEC, RAD_S_PER_DEG_H
from station.guide.resumed_campaign import turn_seen

LATITUDES = (0, 20, 31, 45, 50, 55, 60, 65, 70, 75, 80, 85, 89)
LOOKS_S = (1.0, 2.0, 3.0, 6.0, 10.0, 20.0, 40.0, 70.0, 100.0)
HEADING_STD = float(np.radians(0.05))
DRAWS: dict[str, Callable[[np.random.Generator], FloatArray]] = {
    "normal 1": lambda rng: rng.standard_normal(3),
    "normal 2": lambda rng: 2 * rng.standard_normal(3),
    "normal 3": lambda rng: 3 * rng.standard_normal(3),
    "even +-3": lambda rng: rng.uniform(-3, 3, 3),
}


def looked_at(rng: np.random.Generator, latitude: float, draw: str, is_known: bool) -> tuple[QuarterHeading, int]:
    """Return what is found of a unit in a face and heading drawn, and the quarter it stands in."""
    k = 2e6 * (1 + 0.03 * rng.standard_normal(3))  # count/rad
    bias, std = RAD_S_PER_DEG_H * DRAWS[draw](rng), np.full(3, 2e6 * 0.1 * RAD_S_PER_DEG_H)

    def rate(position: int, quarter: int) -> FloatArray:
        C = nominal_C_lb(position).T @ vertical_rotation(-(quarter * np.pi / 2 + 1e-2 * rng.standard_normal()))
        seen: FloatArray = k * (C @ earth_rate_n(latitude) + bias) + std * rng.standard_normal(3)
        return seen

    first, quarter, other = 2 * int(rng.integers(6)) + 1, int(rng.integers(4)), int(rng.integers(1, 13))
    known = [CertainDwell(other, rate(other, 0), std)] if is_known else []
    return find_heading(rate(first, quarter), std, face_of(first), latitude, np.eye(3), known), quarter


def heading_cell(case: tuple[int, str, bool], trials: int) -> str:
    """Return how often one is sure, in per cent, and how often sure and wrong."""
    rng = np.random.default_rng([case[0], list(DRAWS).index(case[1]), case[2]])
    found = [looked_at(rng, np.radians(case[0]), *case[1:]) for _ in range(trials)]
    wrong = sum(heading.is_sure and heading.quarter != quarter for heading, quarter in found)
    return f"{100 * np.mean([heading.is_sure for heading, _ in found]):5.1f} / {wrong}"


def print_heading(trials: int) -> None:
    """Print per latitude: sure in per cent / sure and wrong of ``trials``."""
    cases = [(lat, draw, False) for lat in LATITUDES for draw in DRAWS]
    cases += [(lat, "even +-3", True) for lat in LATITUDES]
    with ProcessPoolExecutor(2) as pool:
        cells = dict(zip(cases, pool.map(partial(heading_cell, trials=trials), cases), strict=True))
    print("latitude", *(f"{name:>12s}" for name in (*DRAWS, "one known")))
    for lat in LATITUDES:
        row = [cells[lat, draw, False] for draw in DRAWS] + [cells[lat, "even +-3", True]]
        print(f"{lat:8d}", *(f"{cell:>12s}" for cell in row))


def rates(series: CountSeries, seconds: float) -> tuple[FloatArray, FloatArray]:
    """Return accelerometer rates (3,) and 1 sigma (3,) of a recording's first seconds."""
    assert series.accel is not None
    n = round(seconds / series.period)
    found = [estimate_counts([series.accel[:n, i]], series.period)[0] for i in range(3)]
    return np.array([each.rate for each in found]), np.array([each.std for each in found])


def tilted(truth: Truth, position: int, tilt: float, seed: int) -> CountSeries:
    """Record a dwell with the cube tilted [rad] in a random direction."""
    way, rng = np.zeros(3), np.random.default_rng(seed)
    way[list(cross_axes(face_of(position)))] = tilt * np.array([np.cos(a := rng.uniform(0, 6.28)), np.sin(a)])
    seat = {position: np.cross(face_normal(face_of(position)), way)}
    world = replace(world_with_effects(truth), seatings=seat)
    return SimulatedBench(truth, seed, world=world).perform(Dwell(position, 100.0))


def first_alarm(accepted: Sequence[PositionRates], position: int, series: CountSeries) -> float:
    """Return the look at which the seat is called off, inf if at none."""
    for look in LOOKS_S:
        found = seating(accepted, (position, *rates(series, look)), Fixture(), HEADING_STD)
        if found is not None and judge(found):
            return look
    return np.inf


def seated(seed: int, k: float, tilts: Sequence[float]) -> tuple[list[float], dict[float, list[float]]]:
    """Return the looks at which clean dwells and, from the second pair on, tilted ones were called off."""
    truth = Truth.example(seed)
    truth = replace(truth, accel_k=truth.accel_k * k / 1e3)
    bench, accepted = SimulatedBench(truth, seed), list[PositionRates]()
    clean, caught = list[float](), {tilt: list[float]() for tilt in tilts}
    for position in range(1, 13):
        series = bench.perform(Dwell(position, 100.0))
        if position % 2 == 0:
            clean.append(first_alarm(accepted, position, series))
        for tilt in tilts if position % 2 == 0 and position > 2 else ():
            off = tilted(truth, position, tilt * RAD_PER_ARCSEC, 100 * seed + position)
            caught[tilt].append(first_alarm(accepted, position, off))
        accepted.append((position, *rates(series, 100.0)))
    return clean, caught


def print_seating(trials: int) -> None:
    """Print false alarms, and how many of the tilted cubes were caught by when."""
    tilts = (5.0, 10.0, 20.0, 50.0, 100.0)
    for k in (1e3, 1e5):
        with ProcessPoolExecutor(2) as pool:
            found = list(pool.map(partial(seated, k=k, tilts=tilts), range(trials)))
        clean = np.concatenate([each[0] for each in found])
        print(f"{k:g} count/(g s): {np.isfinite(clean).sum()} false alarms in {len(clean)} dwells")
        print("arcsec", *(f"{look:6.0f} s" for look in LOOKS_S), "  never")
        for tilt in tilts:
            look = np.concatenate([each[1][tilt] for each in found])
            print(f"{tilt:6.0f}", *(f"{100 * np.mean(look <= by):6.1f} %" for by in LOOKS_S), end="")
            print(f" {100 * np.mean(np.isinf(look)):6.1f} %")


def warming(seed: int, n: int, rise: float, step: float | None) -> IntervalMeans:
    """Return 10 s means of a unit that warms by ``rise`` [K], tau 600 s, 0.05 deg/h/K on its worst gyro.

    ``step`` [K] of the thermometer, None for no thermometer.
    """
    rng, t = np.random.default_rng(seed), 10.0 * np.arange(1, n + 1)
    warmth = rise * (1 - np.exp(-(t - 5) / 600))
    per_k, std = np.array([0.05, -0.025, 0.015]) * 10, np.full((n, 3), 3.6 / np.sqrt(10))  # 10 count/s a deg/h
    gyro = np.array([50.0, 3.0, 120.0]) + np.outer(warmth, per_k) + std * rng.standard_normal((n, 3))
    seen = 23 + rng.uniform() + warmth + 3e-3 * rng.standard_normal(n)
    temperature = np.full(n, np.nan) if step is None else np.round(seen / step) * step
    return IntervalMeans(t, gyro, std, temperature)


def ready_at(means: IntervalMeans) -> float:
    """Return when the unit was first said to be ready [s]."""
    for n in range(2, len(means.t) + 1):
        part = IntervalMeans(means.t[:n], means.gyro[:n], means.gyro_std[:n], means.temperature[:n])
        if warm_up(part, 100.0, 290.0).is_ready:
            return float(part.t[-1])
    return np.inf


def print_warm_up(trials: int) -> None:
    """Print when a stable and a warming unit are said to be ready, and what was then left of the drift."""
    print("thermometer    stable, s: median, latest    warming, s: earliest, median, latest    drift left / limit")
    for name, step in (("fine", 1e-3), ("0.06 K", 0.0625), ("0.25 K", 0.25), ("1 K", 1.0), ("none", None)):
        cold = np.array([ready_at(warming(seed, 250, 0.0, step)) for seed in range(trials)])
        warm = np.array([ready_at(warming(seed, 400, 10.0, step)) for seed in range(trials)])
        left = 10 / 600 * np.exp(-warm / 600) * 0.5 * 290 / 0.36
        print(
            f"{name:14s} {np.median(cold):6.0f} {cold.max():6.0f} {warm.min():20.0f} {np.median(warm):8.0f}",
            end="",
        )
        print(f" {warm.max():8.0f} {left.min():22.2f} to {left.max():.2f}")


def print_dwell(trials: int) -> None:
    """Print, per unit, the sigma that a campaign with the dwells proposed has, over the one wanted."""
    print("count/(g s)  noise g     wanted g  seconds  sigma/wanted: rms, worst axis")
    for k, (noise, wanted) in product((1e2, 1e3, 1e5), ((1e-5, 1e-7), (1e-4, 1e-6))):
        n = np.full(3, noise * np.sqrt(0.02) * k)
        length = dwell_seconds(n, np.full(3, k), wanted)
        std = np.empty((trials, 3))
        for seed in range(trials):
            truth = Truth.example(seed)
            truth = replace(truth, accel_k=truth.accel_k * k / 1e3, accel_noise_g=noise)
            found = solve([simulate_campaign(truth, seed, dwell_s=length.seconds, turns=())]).accelerometer
            assert found is not None
            std[seed] = found.bias.std
        ratio = np.sqrt(np.mean(std**2)) / wanted, std.max() / wanted
        print(f"{k:11g} {noise:8g} {wanted:12g} {length.seconds:8.0f}", *(f"{each:10.2f}" for each in ratio))


class Hands(SimulatedBench):
    """Hands whose turns close as they are told to, [rad]."""

    closure = 0.0

    def _turn(self, step: Turn) -> CountSeries:
        C_bn = self.world.attitude(step.start_position, self._draw(self.truth.heading_std_deg), seated=False)
        segment = turn_segment(self.world, C_bn, step, self.closure, self.truth.sample_period_s, self._hands)
        return self._record(segment, segment.samples or 0)


def pair_closed(seed: int, off: float, closure_std: float) -> tuple[bool, bool, int]:
    """Turn + and -, one of them ``off`` [sigma of the pair] beyond the other, until they close; 0: both honest.

    Return whether the pair was taken at once, whether the bad turn stands at the end, and how many turns it took.
    """
    rng, bench = np.random.default_rng([seed, round(1e3 * off)]), Hands(Truth.example(seed % 50), seed)
    bad, turns, standing = str(rng.choice(["+", "-"])), list[TurnCounts](), dict[str, bool]()
    direction, found = str(rng.choice(["+", "-"])), Closing.ALONE
    good = closure_std * rng.standard_normal()
    while found is not Closing.CLOSED and len(turns) < MAX_TURNS_PER_AXIS:
        is_bad = direction == bad and off > 0 and bad not in standing
        is_first = direction not in standing
        bench.closure = good if is_first and off > 0 else closure_std * rng.standard_normal()
        bench.closure += is_bad * off * closure_std * 2**0.5
        bench.closure *= {"+": 1, "-": -1}[direction]  # beyond closing is along the turn
        step = Turn("x", direction, 3, 1, 5.0)
        record = TurnRecord(step.name, "x", direction, 3, 1, bench.perform(step))
        turns.append(turn_seen(record, np.eye(3)))
        standing[direction] = is_bad
        found = judge_closing(turns, closure_std)
        other = {"+": "-", "-": "+"}[direction]
        direction = other if found in {Closing.ALONE, Closing.OTHER} else direction
    return len(turns) == 2, any(standing.values()), len(turns)


def print_closing(trials: int) -> None:
    """Print how often pairs are taken of which one turn is off, and how that ends; three pairs a campaign."""
    closure = float(np.radians(0.01))
    print("apart, sigma of the pair taken at once   bad turn stands   turns: mean, most")
    for off in (0.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 15.0, 50.0):
        with ProcessPoolExecutor(2) as pool:
            found = list(pool.map(partial(pair_closed, off=off, closure_std=closure), range(3 * trials)))
        taken, stands, turns = (np.array([each[i] for each in found]) for i in range(3))
        share = f"{100 * taken.mean():12.2f} % {100 * stands.mean():15.2f} %"
        print(f"{off:22.0f} {share} {turns.mean():12.2f} {turns.max():4d}")


def main() -> None:
    """Print one table."""
    parser = argparse.ArgumentParser(description=__doc__)
    tables = {
        "heading": print_heading, "seating": print_seating, "warm_up": print_warm_up, "dwell": print_dwell,
        "closing": print_closing,
    }  # fmt: skip
    parser.add_argument("table", choices=tables)
    parser.add_argument("--trials", type=int, default=20)
    arguments = parser.parse_args()
    begin = perf_counter()
    tables[arguments.table](arguments.trials)
    print(f"{arguments.trials} trials, {perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()
