"""How well the guide finds the heading by the Earth rate, and a cube that stands tilted."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from drivers.simulated.bench_in_memory import SimulatedBench, world_with_effects
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.bench.seating_check import PositionRates, judge, seating
from procedures.campaign.campaign import Fixture
from procedures.campaign.plan_steps import Dwell
from procedures.counts.count_rate import estimate_counts
from procedures.counts.sample_records import CountSeries
from procedures.frames import vertical_rotation
from procedures.geodesy import earth_rate_n
from procedures.gyrocompass import CertainDwell, QuarterHeading, find_heading
from procedures.positions import cross_axes, face_normal, face_of, nominal_C_lb
from procedures.units import RAD_PER_ARCSEC, RAD_S_PER_DEG_H
from tests.proof.evidence import Figure, spread, zero

LATITUDES = (0, 20, 31, 45, 50, 55, 60, 65, 70, 75, 80, 85, 89)
LOOKS_S = (1.0, 2.0, 3.0, 6.0, 10.0, 20.0, 40.0, 70.0, 100.0)
TILTS, CERTAIN = (5.0, 10.0, 20.0, 50.0, 100.0), 50.0  # arcsec
HEADING_STD = float(np.radians(0.05))
DRAWS: dict[str, Callable[[np.random.Generator], FloatArray]] = {
    "normal 1": lambda rng: rng.standard_normal(3),
    "normal 2": lambda rng: 2 * rng.standard_normal(3),
    "even +-3": lambda rng: rng.uniform(-3, 3, 3),
}


def looked_at(rng: np.random.Generator, latitude: float, draw: str, is_known: bool) -> tuple[QuarterHeading, int]:
    """Return what is found of a unit in a face and heading drawn, and the quarter it stands in."""
    k = 2e6 * (1 + 0.03 * rng.standard_normal(3))  # count/rad
    bias, std = RAD_S_PER_DEG_H * DRAWS[draw](rng), np.full(3, 2e6 * 0.1 * RAD_S_PER_DEG_H)

    def rate(position: int, quarter: int) -> FloatArray:
        C = nominal_C_lb(position).T @ vertical_rotation(-(quarter * np.pi / 2 + 1e-2 * rng.standard_normal()))
        return k * (C @ earth_rate_n(latitude) + bias) + std * rng.standard_normal(3)

    first, quarter, other = 2 * int(rng.integers(6)) + 1, int(rng.integers(4)), int(rng.integers(1, 13))
    known = [CertainDwell(other, rate(other, 0), std)] if is_known else []
    return find_heading(rate(first, quarter), std, face_of(first), latitude, np.eye(3), known), quarter


def headings(item: tuple[int, str, bool, int, int]) -> tuple[int, int]:
    """Return how often one is sure, and how often sure and wrong."""
    latitude, draw, is_known, trials, seed = item
    rng = np.random.default_rng([seed, latitude, list(DRAWS).index(draw), is_known])
    found = [looked_at(rng, np.radians(latitude), draw, is_known) for _ in range(trials)]
    sure = [(heading, quarter) for heading, quarter in found if heading.is_sure]
    return len(sure), sum(heading.quarter != quarter for heading, quarter in sure)


def proof_heading(size: int, seed: int) -> dict[str, Figure]:
    """Return how often a heading was sure at each latitude, and how often it was sure and wrong."""
    result, wrong, trials = dict[str, Figure](), 0, 0
    for latitude in LATITUDES:
        cases = [(draw, is_known) for draw in DRAWS for is_known in (False, True)]
        found = spread(headings, [(latitude, draw, is_known, size, seed) for draw, is_known in cases])
        wrong, trials = wrong + sum(each[1] for each in found), trials + len(cases) * size
        sure = sum(each[0] for each in found) / len(cases) / size
        result[f"latitude {latitude} deg: sure"] = Figure(100 * sure, "%")
    return {f"sure and wrong, of {trials}": zero(wrong), **result}


def rates(series: CountSeries, seconds: float) -> tuple[FloatArray, FloatArray]:
    """Return accelerometer rates (3,) and 1 sigma (3,) of a recording's first seconds."""
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


def proof_seating(size: int, seed: int) -> dict[str, Figure]:
    """Return false alarms, and how many of the tilted cubes were detected."""
    result = dict[str, Figure]()
    for k in (1e3, 1e5):
        found = spread(partial(seated, k=k, tilts=TILTS), range(seed, seed + size))
        clean = np.concatenate([each[0] for each in found])
        alarms = Figure(np.isfinite(clean).sum(), of=len(clean), at_most=max(1.0, len(clean) / 100))
        result[f"{k:g} count/(g s): false alarms"] = alarms
        for tilt in TILTS:
            look = np.concatenate([each[1][tilt] for each in found])
            share = Figure(100 * np.mean(np.isfinite(look)), "%", at_least=100.0 if tilt >= CERTAIN else None)
            result[f"{k:g} count/(g s): tilt of {tilt:g} arcsec detected within 100 s"] = share
    return result
