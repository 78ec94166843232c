"""The innocent part of a campaign: another unit, slab, cube and order each time, by the simulator of a bench."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from drivers.simulated.bench_in_memory import SimulatedBench, world_with_effects
from drivers.simulated.effects import Planted
from drivers.simulated.truth import Truth
from procedures.campaign.campaign import (
    Campaign,
    DwellRecord,
    FaceCertificate,
    Fixture,
    ProcedureSigma,
    RestRecord,
    Site,
    SoakRecord,
    TurnRecord,
)
from procedures.campaign.plan_steps import Dwell, FreePosition, Soak, Step, Turn
from procedures.counts.sample_records import CountSeries
from procedures.positions import FACES, TURN_START
from tests.benchmarks.diagnosing.designs import unit

DWELL_S, SOAK_S, FREE = 100.0, 2400.0, 16
CERTIFICATE = 5e-6  # rad
SPEEDS = (12.0, 35.0, 80.0)  # deg/s


@dataclass(frozen=True, slots=True)
class Design:
    """What a campaign has in addition to the twelve positions, and what of the truth it needs."""

    truth: Mapping[str, float] = field(default_factory=dict)
    speeds: tuple[float | None, ...] = (None,)
    free: int = 0
    soak_s: float = 0.0
    is_certified: bool = False
    warmer_k: float = 0.0


WARM = {
    "temperature_rise_k": 6.0, "temperature_tau_s": 900.0,
    "temperature_swing_k": 3.0, "temperature_swing_period_s": 1500.0,
}  # fmt: skip
DESIGNS = {
    "plain": Design(),
    "warm": Design(WARM),
    "soak": Design(WARM, soak_s=SOAK_S),
    "free": Design(free=FREE),
    "certified": Design(is_certified=True),
    "certified free": Design(free=FREE, is_certified=True),
    "speeds": Design(speeds=SPEEDS),
    "two temperatures": Design(warmer_k=20.0),
}


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """Campaigns of one unit, and each step's record in the order of time."""

    campaigns: tuple[Campaign, ...]
    steps: tuple[tuple[Step, CountSeries], ...]


def truth_of(design: str, seed: int) -> Truth:
    """Return the unit and its bench of a seed, somewhere between 20 and 60 deg of latitude."""
    latitude = float(np.random.default_rng([seed, 78]).uniform(20, 60))
    return unit(seed, **DESIGNS[design].truth, latitude_deg=latitude)


def campaigns_of(truth: Truth, design: str, seed: int, also: Planted = (), stated: Truth | None = None) -> Made:
    """Return what a bench records of a unit; ``stated`` is what its files say, if not ``truth``."""
    first = _carried_out(truth, design, seed, also, stated or truth)
    if not (warmer := DESIGNS[design].warmer_k):
        return first
    warm = replace(truth, temperature_start_c=truth.temperature_start_c + warmer)
    second = _carried_out(warm, design, seed + 1_000_000, also, stated or warm)
    return Made((*first.campaigns, *second.campaigns), (*first.steps, *second.steps))


def _carried_out(truth: Truth, name: str, seed: int, also: Planted, stated: Truth) -> Made:
    design, rng = DESIGNS[name], np.random.default_rng([seed, 79])
    bench = SimulatedBench(truth, seed, float(rng.uniform(30, 60)), world_with_effects(truth), also)
    done = [(step, _performed(bench, step, rng)) for step in _steps(design, rng)]
    east, north, up = truth.magnetic_enu_ut.tolist()
    off = CERTIFICATE * rng.standard_normal((6, 2))
    faces = {
        face: FaceCertificate(stated.faces_rad[i] + off[i], CERTIFICATE**2 * np.eye(2))
        for i, face in enumerate(FACES) if design.is_certified
    }  # fmt: skip
    site = Site(float(np.radians(stated.latitude_deg)), stated.local_gravity, 1e-5, (east, north, up))
    campaign = Campaign(
        truth.model, truth.serial, True, site,
        tuple(DwellRecord(s.name, s.position, r) for s, r in done if isinstance(s, Dwell)),
        tuple(_turned(i, s, r) for i, (s, r) in enumerate(done) if isinstance(s, Turn)),
        ProcedureSigma(float(np.radians(stated.heading_std_deg)), float(np.radians(stated.closure_std_deg))),
        Fixture(faces, bench.world.C_sb, id="CUBE"),
        tuple(RestRecord(s.name, None, r) for s, r in done if isinstance(s, FreePosition)),
        soaks=tuple(SoakRecord(s.name, s.position, None, r) for s, r in done if isinstance(s, Soak)),
    )  # fmt: skip
    return Made((campaign,), tuple(done))


def level_axes(f: np.ndarray, magnetic: np.ndarray, enu: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return North and East (n, 3) in IMU axes, by what acts on it and the magnetic field ``enu`` (3,)."""
    up = f / np.linalg.norm(f, axis=1, keepdims=True)
    flat = magnetic - np.sum(magnetic * up, axis=1, keepdims=True) * up
    flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    e, n = enu[:2] / np.hypot(*enu[:2])
    left = np.cross(up, flat)  # 90 deg to the left of the field, seen from above
    return n * flat + e * left, e * flat - n * left


def _steps(design: Design, rng: np.random.Generator) -> list[Step]:
    """Return the steps: positions in any order, turns before, between or after, a soak at one end."""
    steps: list[Step] = [Dwell(int(p), DWELL_S) for p in rng.permutation(np.arange(1, 13))]
    turns = [Turn(a, d, 3, TURN_START[a], 5.0, speed) for a in "xyz" for speed in design.speeds for d in "+-"]
    for turn in rng.permutation(np.arange(len(turns))):
        steps.insert(int(rng.integers(len(steps) + 1)), turns[turn])
    for number in range(design.free):
        steps.insert(int(rng.integers(len(steps) + 1)), FreePosition(number + 1, DWELL_S))
    if design.soak_s:
        soak = Soak(1, design.soak_s, position=int(rng.integers(1, 13)))
        steps.insert(len(steps) * int(rng.integers(2)), soak)
    return steps


def _performed(bench: SimulatedBench, step: Step, rng: np.random.Generator) -> CountSeries:
    if not isinstance(step, FreePosition):
        return bench.perform(step)
    C, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    return bench.free(C * np.linalg.det(C), step.seconds)


def _turned(number: int, turn: Turn, series: CountSeries) -> TurnRecord:
    name = turn.name if turn.speed_deg_s is None else f"{turn.name}_{number + 1}"
    return TurnRecord(name, turn.axis, turn.direction, turn.revolutions, turn.start_position, series)
