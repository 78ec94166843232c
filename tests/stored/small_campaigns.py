"""Campaigns of a few seconds a dwell, each with other error terms, and the effects that its diagnosis tries."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from drivers.simulated.bench_in_memory import ALL_POSITIONS, SimulatedBench, simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.campaign import Campaign, RateTable, RestRecord, SoakRecord
from procedures.campaign.plan_steps import Dwell, Turn
from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from procedures.frames import rotation
from procedures.inference.result import Diagnosis
from procedures.positions import TURN_START
from procedures.uncertainty.budget import ParameterBudget
from tests.procedures.diagnosis.planted import drifting, with_reference_time

SECONDS = 8.0  # of a dwell, of 80 samples but for moves
FREE = np.array([
    (0.5, 0.4, 0.1), (2.0, 0.7, -0.3), (-0.8, 0.2, 1.0), (0.3, -2.3, 0.4), (1.1, 1.2, 1.3), (0.6, 2.2, -0.9)
])  # fmt: skip
BETWEEN_FACES = {"accelerometer.cross_product": {"xy": 1e-3}}
Effects = Mapping[str, Mapping[str, float]]
Changed = Callable[[Campaign], Campaign]


WARM = {
    "temperature_rise_k": 6.0, "temperature_tau_s": 900.0, "temperature_swing_k": 2.0,
    "temperature_swing_period_s": 1300.0,
}  # fmt: skip


def unit(seed: int, **fields: object) -> Truth:
    """Return a unit at 10 Hz, as noisy as at 100 Hz, on a cube and a surface plate that are tilted."""
    rng, base = np.random.default_rng([seed, 77]), Truth.example(seed)
    noise = base.accel_noise_g * np.sqrt(base.sample_period_s / 0.1)
    return replace(
        base, sample_period_s=0.1, accel_noise_g=float(noise), faces_rad=4e-5 * rng.standard_normal((6, 2)),
        slab_tilt_rad=3e-5 * rng.standard_normal(2),
        **{"accel_k": 5 * base.accel_k, "gyro_k": 5 * base.gyro_k, **fields},
    )  # fmt: skip


@dataclass(frozen=True)
class Case:
    """What is planted, which effects are tried, and how the campaign is made of the bench."""

    planted: Effects
    tried: tuple[str, ...]
    bench: Mapping[str, Any] = field(default_factory=dict)
    truth: Mapping[str, Any] = field(default_factory=dict)
    then: Changed = lambda campaign: campaign
    twice: bool = False


def turns(*speeds: float) -> list[Turn]:
    """Return turns of one revolution about each axis."""
    return [Turn(axis, way, 1, TURN_START[axis], 2.0, speed) for axis in "xyz" for speed in speeds for way in "+-"]


def with_soak(campaign: Campaign) -> Campaign:
    """Add a soak of four minutes at 1 Hz, warming by what the truth says."""
    truth = unit(5, effects={"accelerometer.bias_temperature": {"x": 3e-4}}, **WARM)
    series = SimulatedBench(replace(truth, sample_period_s=1.0), 3).perform(Dwell(1, 240.0))
    return replace(campaign, soaks=(SoakRecord("soak", 1, None, series),))


def with_rests(campaign: Campaign) -> Campaign:
    """Add six rests of the same unit between the faces."""
    bench = SimulatedBench(unit(5, effects=BETWEEN_FACES), 4)
    rests = tuple(RestRecord(f"free_{i}", None, bench.free(rotation(C), SECONDS)) for i, C in enumerate(FREE))
    return replace(campaign, rests=rests)


def with_table(campaign: Campaign) -> Campaign:
    u = np.tile(np.concatenate((np.arange(0, 101, 20), -np.arange(0, 101, 20))), 3).astype(float)
    temperature = 40 + 10 * np.linspace(0, 1, len(u)) ** 0.7
    rate = (u + 0.01 - 2e-6 * u**3) * (1 - 4e-4 * (temperature - 25))
    output = np.full((len(u), 3), np.nan)
    output[:, 2] = -2e4 * (rate + 2e-3 * np.random.default_rng(7).standard_normal(len(u)))
    return replace(campaign, rate_tables=(RateTable("rates_z.csv", "z", u, output, temperature),))


def with_channel(campaign: Campaign) -> Campaign:
    def auxiliary(record: Any) -> Any:
        swing = np.sin(record.series.t / 30)
        return replace(record, series=replace(record.series, extra={"aux_pump": swing}))

    return replace(campaign, dwells=tuple(map(auxiliary, campaign.dwells)))


CERTIFIED = {"certificate_sigma": 5e-6}
CASES = {
    "quadratic, g sensitivity": Case(
        {"accelerometer.quadratic": {"x": 1e-4}, "gyroscope.g_sensitivity": {"xx": 6.0, "yz": -4.0}},
        ("accelerometer.quadratic", "fixture.parallelism", "gyroscope.g_sensitivity", "gyroscope.magnetic"),
        CERTIFIED | {"turns": turns(30.0)},
    ),
    "drift, jump": Case(
        {"accelerometer.bias_drift": {"y": 5e-3}, "gyroscope.jump": {"x": 80.0, "after_s": 150.0}},
        ("accelerometer.bias_drift", "accelerometer.jump", "gyroscope.bias_drift", "gyroscope.jump",
         "accelerometer.bias_settling", "gyroscope.bias_settling"),
        {"repeats": 1},
    ),
    "seat, slab, face": Case(
        {"placement.dwell": {"position": 5.0, "x": 2e-3, "y": -1e-3, "z": 3e-3}, "slab.tilt": {"east": 1e-3},
         "fixture.face_tilt": {"x_up.y": 1e-3}},
        ("placement.dwell", "placement.label", "slab.tilt", "fixture.face_tilt", "fixture.parallelism"),
        CERTIFIED,
    ),
    "two speeds": Case(
        {"gyroscope.scale_asymmetry": {"x": 400.0}},
        ("gyroscope.scale_asymmetry", "gyroscope.scale_nonlinearity", "gyroscope.sagnac_sine",
         "gyroscope.counts_lost", "procedure.closure"),
        {"positions": range(1, 7), "turns": turns(30.0, 60.0)},
    ),
    "clock": Case(
        {"clock.rate": {"value": 3000.0}}, ("clock.rate",), {"turns": turns(30.0)},
        then=lambda campaign: with_reference_time(campaign, 3000.0, 2),
    ),
    "a channel": Case(
        {"gyroscope.magnetic": {"xx": 0.5}}, ("auxiliary.channel", "gyroscope.magnetic"), {"turns": turns(30.0)},
        then=with_channel,
    ),
    "disturbed": Case(
        {"disturbance.dwell": {"x": 0.5, "z": 0.2, "position": 4.0, "at_s": 3.0, "duration_s": 2.0, "hz": 3.0}},
        ("disturbance.dwell", "accelerometer.quadratic"),
    ),
    "wandering": Case({}, ("accelerometer.relaxation",), then=lambda campaign: drifting(campaign, 1, 40.0)),
    "rests": Case(
        BETWEEN_FACES,
        ("accelerometer.cross_product", "accelerometer.cubic", "accelerometer.quadratic",
         "accelerometer.scale_asymmetry"),
        then=with_rests,
    ),
    "soak": Case(
        {"accelerometer.bias_temperature": {"x": 3e-4}},
        ("accelerometer.bias_temperature", "accelerometer.temperature_lag", "accelerometer.temperature_hysteresis",
         "accelerometer.bias_drift", "gyroscope.bias_temperature", "gyroscope.temperature_rate"),
        truth=WARM, then=with_soak,
    ),
    "a rate table": Case(
        {}, ("gyroscope.scale_nonlinearity", "gyroscope.scale_temperature", "gyroscope.sagnac_sine"),
        {"positions": range(1, 7)}, then=with_table,
    ),
    "two temperatures": Case(
        {"accelerometer.scale_temperature": {"x": 300.0}},
        ("accelerometer.scale_temperature", "accelerometer.bias_temperature", "gyroscope.bias_temperature",
         "accelerometer.turn_on_bias", "gyroscope.turn_on_bias"),
        twice=True,
    ),
    "moves": Case(
        {"gyroscope.g_sensitivity": {"xx": 3.0}},
        ("gyroscope.g_sensitivity", "gyroscope.scale_asymmetry", "placement.dwell", "procedure.heading"),
        {"moves": True}, truth={"sample_period_s": 0.04},
    ),
    "scatter": Case(
        {"placement.scatter": {"value": 1e-4}, "procedure.heading": {"value": 0.3}},
        ("placement.scatter", "procedure.heading", "placement.dwell", "site.azimuth", "site.latitude"),
        CERTIFIED | {"repeats": 3},
    ),
}  # fmt: skip


def campaigns_of(case: Case) -> list[Campaign]:
    """Return the campaigns of a case, two of one unit where it is measured ``twice``."""
    truth = replace(unit(5, effects=case.planted), **case.truth)
    bench: dict[str, Any] = {"dwell_s": SECONDS, "move_s": 6.0, "turns": (), "positions": ALL_POSITIONS}
    made = [simulate_campaign(truth, 5, **(bench | dict(case.bench)))]
    if case.twice:
        warm = replace(truth, temperature_start_c=truth.temperature_start_c + 20.0)
        made.append(simulate_campaign(warm, 6, **(bench | dict(case.bench))))
    return [case.then(replace(each, fixture=replace(each.fixture, id="CUBE"))) for each in made]


def some_effects(*names: str) -> list[Effect]:
    """Return effects of the catalogue by name: one that is added to it must not move what is stored of others."""
    return [effect for effect in EFFECTS if effect.name in names]


def outcome(found: Diagnosis) -> dict[str, Any]:
    """Return what a diagnosis says, not the rows and fits that it says it of."""
    rows = {"before", "after", "evidence", "added", "values", "solution_before", "looked_at"}
    reported = {each.name: getattr(found, each.name) for each in fields(found) if each.name not in rows}
    kept = ("accelerometer", "gyroscope", "slab_tilt", "parallelism", "quality")
    reported["solution"] = {name: getattr(found.solution, name) for name in kept}
    reported["probabilities"] = {name: p for name, p in found.probabilities.items() if p > 0.01}
    pairs = [(each.effect.name, v) for each, v in zip(found.added, found.values, strict=True)]
    pairs.sort(key=lambda pair: (pair[0], np.argmax(np.abs(pair[1]))))  # rounding orders those that tie
    return reported | {"added": [{"effect": name, "values": v} for name, v in pairs]}


def stated(budgets: tuple[ParameterBudget, ...]) -> list[dict[str, Any]]:
    """Return budgets; of their parts the names, from a hundredth on: rounding moves the fifth digit of one.

    The values are the solution's; of one that is zero rounding alone is left.
    """
    return [
        {each.name: getattr(one, each.name) for each in fields(one) if each.name != "value"}
        | {"contributions": [part.source for part in one.contributions if part.std > 0.01 * one.std]}
        for one in budgets
    ]
