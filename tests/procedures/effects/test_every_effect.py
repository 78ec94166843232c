"""Every effect against the simulator's own, which shares no code with it: what it adds to the evidence."""

import pkgutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from drivers.errors import TruthRefused
from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.effects import EFFECTS as PLANTED
from drivers.simulated.effects.bench import auxiliary
from drivers.simulated.truth import Truth
from procedures import effects
from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits, fit_reduced
from procedures.calibration.reduced_steps import ReducedSteps, reduce_steps
from procedures.campaign.campaign import ProcedureSigma
from procedures.campaign.observations import TriadDwells
from procedures.campaign.plan_steps import Turn
from procedures.counts.sample_records import CountSeries, RateSeries
from procedures.effects import EFFECTS
from procedures.effects.effect import BENCH, INSTRUMENT, Effect, no_columns
from procedures.effects.excitation import TAU, Columns
from procedures.effects.term.law import orders_of
from procedures.evidence.residual_rows import KINDS, Evidence, evidence_of
from procedures.frames import AXES, rotation
from procedures.positions import TURN_START

BY_NAME = {effect.name: effect for effect in EFFECTS}

UNIT = Truth(
    sample_period_s=0.05, gravity_m_s2=9.79, magnetic_enu_ut=np.array([-3.0, 34.0, -36.0]),
    accel_k=np.full(3, 1e9), gyro_k=np.full(3, 1e10), accel_noise_g=0.0, gyro_arw_deg_rt_s=0.0,
    accel_e=np.array([[1, 1e-5, 0], [0, 1, -1e-5], [1e-5, 0, 1.0]]), accel_d_g=np.array([1e-3, -2e-3, 5e-4]),
    gyro_e=np.array([[1, 1e-5, 0], [0, 1, 0], [0, -1e-5, 1.0]]), gyro_d_deg_s=np.array([1e-4, 2e-4, -1e-4]),
    gyro_instability_dph=0.0, heading_std_deg=0.0, closure_std_deg=0.0, imu_axes=("-y", "+x", "+z"),
    temperature_start_c=20.0, temperature_rise_k=8.0, temperature_tau_s=800.0,
)  # fmt: skip
TURNS = tuple(
    Turn(axis, direction, 1, TURN_START[axis], 2.0, speed)
    for axis in "xyz"
    for direction in "+-"
    for speed in (20, 60)
)
TILTS = tuple(
    rotation(np.array(v)) for v in ((0.8, 0.3, 0.1), (-0.4, 0.7, 0.9), (2.5, 0.6, -0.4), (0.2, -2.0, 1.0))
)


def carried_out(effects: Mapping[str, Mapping[str, float]], unit: Truth = UNIT, **more: Any) -> ReducedSteps:
    """A campaign without noise, with two speeds, free positions, a warming unit and a channel next to it."""
    truth = replace(unit, effects={name: dict(sizes) for name, sizes in effects.items()})
    how: dict[str, Any] = {"turns": TURNS, "free": TILTS, **more}
    campaign = simulate_campaign(truth, 1, dwell_s=12.0, draw_stated=False, move_s=20.0, **how)
    steps = {
        name: tuple(replace(each, series=as_rates(each.series)) for each in getattr(campaign, name))
        for name in ("dwells", "turns", "rests", "moves")
    }
    return reduce_steps([replace(campaign, counts=False, sigma=ProcedureSigma(1e-3, 2e-4), **steps)])


def as_rates(counts: CountSeries) -> RateSeries:
    """The same as rates, which are quicker to reduce, with a channel whose value is known five times a second."""
    values = auxiliary(counts.t - counts.period / 2)
    values[np.arange(len(values)) % 4 > 0] = np.nan
    gyro, accel = (n / counts.period for n in (counts.gyro, counts.accel))
    return RateSeries(counts.t, gyro, accel, counts.temperature, counts.period, extra={"aux_volts": values})


@dataclass(frozen=True, eq=False)
class Baseline:
    steps: ReducedSteps
    fits: CampaignFits
    evidence: Evidence


@cache
def baseline() -> Baseline:
    steps = carried_out({})
    fits = fit_reduced(steps)
    return Baseline(steps, fits, evidence_of(fits))


def planted(name: str, sizes: Mapping[str, float], *, as_text: bool = False) -> FloatArray:
    """What planting it, by its twin or its law's text, adds to all evidence but the known [g, deg/s; deg]."""
    before, evidence = baseline().steps, baseline().evidence
    has_twin = name in PLANTED and not as_text
    after = carried_out({name: sizes}) if has_twin else carried_out(*as_a_written_term(name, sizes))
    k = (UNIT.accel_k, UNIT.gyro_k)
    queues = {
        (triad, kind): iter(rows)
        for triad, of in enumerate(("accel", "gyro"))
        for kind, rows in changes(getattr(before, of), getattr(after, of)).items()
    }
    queues[0, "norm"] = iter(after.rests.rate - before.rests.rate)
    queues[1, "turn"] = iter([b.total - a.total for a, b in zip(before.turns, after.turns, strict=True)])
    found = np.zeros(len(evidence.residual))
    for each in evidence.weights:
        rows = next(queues[each.triad, KINDS[evidence.kind[each.rows.start]]]) / k[each.triad]
        found[each.rows] = rows if each.mix is None else each.mix @ rows
    return found


def as_a_written_term(name: str, sizes: Mapping[str, float]) -> tuple[dict[str, Mapping[str, float]], Truth]:
    """Return what to plant of an effect without a twin: its equation, which the simulator reads by itself."""
    law = BY_NAME[name].laws[0]
    keys = AXES if len(law.terms) == 1 else [f"{axis}.{i + 1}" for axis in AXES for i in range(len(law.terms))]
    written = dict(zip(law.coefficients, keys, strict=True))
    lines = [f"{key} = {{unit = '{one.unit}', low = 1.0, high = 1.0}}" for key, one in law.parameters.items()]
    text = "\n".join([
        f"name = '{law.name}'", f"triad = '{law.triad}'", f"term = {list(law.written())}", f"unit = '{law.unit}'",
        "[shape]", *lines,
    ])  # fmt: skip
    return {name: {written.get(key, key): size for key, size in sizes.items()}}, replace(UNIT, terms={name: text})


def changes(before: TriadDwells, after: TriadDwells) -> dict[str, FloatArray]:
    """By how much each dwell's rate, slope and curvature changed (n, 3)."""
    found = {"mean": after.rate - before.rate}
    for kind in ("slope", "curvature"):
        a, b = ([[getattr(e, kind) for e in row] for row in each.estimates] for each in (before, after))
        found[kind] = np.array(b) - np.array(a)
    return found


def predicted(
    name: str,
    sizes: Mapping[str, float],
    where: Mapping[str, object],
    shape: str,
    evidence: Evidence | None = None,
) -> FloatArray:
    """The same by the effect's columns."""
    evidence = evidence or baseline().evidence
    effect, seen = BY_NAME[name], evidence.excitation
    ways = [way for way in effect.columns(seen) if way.shape == shape and where.items() <= way.where.items()]
    if effect.at is None:
        assert len(ways) == 1
        way = ways[0]
    else:  # one of many with which a search begins
        begin = ways[0] if ways else Columns((), nonlinear=dict.fromkeys(effect.laws[0].parameters, 0.0))
        found = {key: sizes.get(key, value) for key, value in begin.nonlinear.items()}
        way = replace(begin, nonlinear=found)
        way = effect.at(seen, replace(way, orders=orders_of(list(sizes)) if way.orders else ()))
    c = [0.0 if key in way.nonlinear else sizes.get(key, 0.0) for key in way.coefficients]
    return evidence.column(way) @ np.array(c)


def agree(got: FloatArray, expected: FloatArray, part: float) -> None:
    """They agree to ``part`` of what there is, in every kind of row of each triad that is not nought."""
    evidence = baseline().evidence
    assert np.any(expected)
    for triad in (0, 1):
        for number in np.unique(evidence.kind):
            rows = (evidence.triad == triad) & (evidence.kind == number)
            size = np.linalg.norm(got[rows])
            still = (FLOOR[triad] if KINDS[number] != "turn" else TURN_FLOOR) * np.sqrt(rows.sum())
            off = np.linalg.norm((got - expected)[rows])
            assert off <= part * size + still, f"{KINDS[number]} of triad {triad}: {off:.3g} of {size:.3g}"


FLOOR = (1e-8, 1e-9)  # g, deg/s: rounding to whole counts, and products of effect and misalignment
TURN_FLOOR = 1e-5  # deg: a third of a real count
JUMP_S = 200.0  # of device time, while the cube is moved from the sixth to the seventh position
BEGUN_S = 20.0  # of device time, when the first dwell begins
PHASE = 2 * np.pi * BEGUN_S / 400  # rad, of a cycle of 400 s by then
# effect, what is planted, the coefficients that must come to it, where, shape; all others: `plausible_case`
CASES = [
    ("accelerometer.quadratic", {"x": 4e-4, "y": -2e-4}, None, {}, ""),
    ("accelerometer.cubic", {"x": 4e-4, "z": 1e-4}, None, {}, ""),
    ("accelerometer.scale_asymmetry", {"x": 400.0, "z": -300.0}, None, {}, ""),
    ("accelerometer.cross_product", {"xxy": 3e-4, "yxz": 2e-4, "zyz": -4e-4}, None, {}, ""),
    ("accelerometer.bias_temperature", {"x": 1e-4, "y": 2e-4, "z": -3e-4}, None, {}, ""),
    ("accelerometer.scale_temperature", {"x": 100.0, "y": -50.0, "z": 70.0}, None, {}, ""),
    ("accelerometer.bias_drift", {"x": 1e-2, "y": -3e-2}, None, {}, ""),
    ("accelerometer.relaxation", {"x": 1e-4, "z": 2e-4, "tau_s": 8.0},
     {"x": 1e-4 * np.exp(-5 / 8), "z": 2e-4 * np.exp(-5 / 8), "tau_s": 8.0}, {}, ""),
    ("accelerometer.relaxation", {"x": 1e-4, "z": 2e-4, "tau_s": 60.0, "by_force": 1.0},
     {"x": 1e-4 * np.exp(-5 / 60), "z": 2e-4 * np.exp(-5 / 60), "tau_s": 60.0}, {}, "by f"),
    ("accelerometer.bias_temperature", {"x.1": 1e-5, "x.2": 2e-6, "x.3": -1e-7, "z.1": 2e-5}, None, {}, ""),
    ("gyroscope.scale_temperature", {"x.1": 50.0, "x.2": -8.0, "y.1": 30.0}, None, {}, ""),
    ("accelerometer.temperature_lag", {"x": 1e-4, "z.1": -2e-4, "z.2": 1e-6, "tau_s": 300.0},
     {"x.1": 1e-4, "z.1": -2e-4, "z.2": 1e-6, "tau_s": 300.0}, {}, ""),
    ("gyroscope.temperature_lag", {"y": 0.3, "tau_s": 1500.0}, None, {}, ""),
    ("gyroscope.temperature_rate_lag", {"y": 3.0, "tau_s": 900.0}, None, {}, ""),
    ("accelerometer.temperature_hysteresis", {"x": 1e-4, "z": -2e-4}, None, {}, ""),
    ("accelerometer.temperature_hysteresis", {"x": 1e-4, "z": -2e-4, "play_k": 1.3}, None, {}, "with a play"),
    ("gyroscope.temperature_hysteresis", {"y": 5.0, "play_k": 1.3}, None, {}, "with a play"),
    ("accelerometer.scale_temperature_lag", {"x": 100.0, "z.1": -200.0, "z.2": 2.0, "tau_s": 300.0},
     {"x.1": 100.0, "z.1": -200.0, "z.2": 2.0, "tau_s": 300.0}, {}, ""),
    ("gyroscope.scale_temperature_lag", {"x": 50.0, "y": -80.0, "tau_s": 900.0}, None, {}, ""),
    ("accelerometer.bias_settling", {"x": 1e-4, "z": -2e-4, "tau_s": 300.0},
     {"x": 1e-4 * np.exp(-BEGUN_S / 300), "z": -2e-4 * np.exp(-BEGUN_S / 300), "tau_s": 300.0}, {}, ""),
    ("gyroscope.bias_settling", {"y": 150.0, "tau_s": 500.0},
     {"y": 150.0 * np.exp(-BEGUN_S / 500), "tau_s": 500.0}, {}, ""),
    ("accelerometer.scale_settling", {"x": 100.0, "z": -200.0, "tau_s": 300.0},
     {"x": 100.0 * np.exp(-BEGUN_S / 300), "z": -200.0 * np.exp(-BEGUN_S / 300), "tau_s": 300.0}, {}, ""),
    ("gyroscope.scale_settling", {"y": 150.0, "tau_s": 500.0},
     {"y": 150.0 * np.exp(-BEGUN_S / 500), "tau_s": 500.0}, {}, ""),
    ("accelerometer.bias_cycle", {"x.sin": 1e-4, "z.cos": -2e-4, "period_s": 400.0},
     {"x.sin": 1e-4 * np.cos(PHASE), "x.cos": 1e-4 * np.sin(PHASE),
      "z.sin": 2e-4 * np.sin(PHASE), "z.cos": -2e-4 * np.cos(PHASE), "period_s": 400.0}, {}, ""),
    ("gyroscope.bias_cycle", {"y.sin": 150.0, "period_s": 400.0},
     {"y.sin": 150.0 * np.cos(PHASE), "y.cos": 150.0 * np.sin(PHASE), "period_s": 400.0}, {}, ""),
    ("gyroscope.g_sensitivity", {"xx": 1.0, "yz": -2.0, "zx": 1.5}, None, {}, ""),
    ("gyroscope.bias_temperature", {"x": 0.3, "z": -0.2}, None, {}, ""),
    ("gyroscope.scale_temperature", {"x": 50.0, "y": -80.0, "z": 70.0}, None, {}, ""),
    ("gyroscope.temperature_rate", {"x": 2.0, "y": -3.0}, None, {}, ""),
    ("gyroscope.bias_drift", {"y": 300.0, "z": -200.0}, None, {}, ""),
    ("gyroscope.magnetic", {"xx": 0.1, "xy": -0.05, "zx": 0.08}, None, {}, ""),
    ("gyroscope.scale_asymmetry", {"x": 100.0, "y": -200.0, "z": 50.0}, None, {}, ""),
    ("gyroscope.scale_nonlinearity", {"x": 20.0, "y": -10.0}, None, {}, "u |u|"),
    ("gyroscope.sagnac_sine", {"x": 1e-3, "z": 8e-4}, {"x": 1e-6, "z": 6.4e-7}, {}, ""),
    ("gyroscope.counts_lost", {"x": 100.0, "z": -300.0, "knee_deg_s": 12.0}, None, {}, ""),
    ("slab.tilt", {"east": 1e-4, "north": -2e-4}, None, {}, ""),
    ("fixture.face_tilt", {"x_up.y": 1e-4, "y_down.x": -2e-4, "z_up.y": 1e-4}, None, {}, ""),
    ("fixture.parallelism", {"x.z": 2e-4, "y.x": -1e-4, "z.y": 1e-4}, None, {}, ""),
    ("placement.dwell", {"position": 7, "x": 1e-4, "y": 3e-4, "z": -2e-4}, None, {"position": 7}, ""),
    ("accelerometer.jump", {"x": 1e-4, "z": -2e-4, "after_s": JUMP_S}, None, {"after": "dwell_06"}, "bias"),
    ("accelerometer.jump", {"x": 100, "y": -50, "after_s": JUMP_S, "scale": 1}, None, {"after": "dwell_06"},
     "scale factor"),
    ("gyroscope.jump", {"x": 5.0, "z": -2.0, "after_s": JUMP_S}, None, {"after": "dwell_06"}, "bias"),
    ("gyroscope.jump", {"x": 100, "y": -50, "after_s": JUMP_S, "scale": 1}, None, {"after": "dwell_06"},
     "scale factor"),
    ("site.azimuth", {"value": 0.01}, None, {}, ""),
    ("site.latitude", {"value": 0.005}, None, {}, ""),
    ("site.gravity", {"value": 1e-3}, None, {"campaign": 1}, ""),
    ("clock.rate", {"value": 200.0}, None, {}, ""),
    ("auxiliary.channel", {"ax": 1e-4, "az": -2e-4, "gy": 2.0}, None, {"channel": "volts"}, ""),
]  # fmt: skip


SHAKEN = {f"{triad}.vibration_rectification" for triad in ("accelerometer", "gyroscope")}  # a test of their own
# tests of soaks, and of many rests, have them
OF_SOAKS = {
    "disturbance.rest",
    "accelerometer.bias_cycle", "gyroscope.bias_cycle",
    "accelerometer.turn_on_bias", "gyroscope.turn_on_bias", "accelerometer.bias_instability",
    "gyroscope.bias_instability", "accelerometer.acceleration_random_walk", "gyroscope.rate_random_walk",
}  # fmt: skip
TILTED = {"placement.tilt"}  # the same in soaks, `test_a_unit_that_slips_...` between dwells
SCATTERS = {effect.name for effect in EFFECTS if effect.is_scatter}  # test_scatters_by_their_columns.py has them
OTHERS = sorted(
    {effect.name for effect in EFFECTS if effect.columns is not no_columns}
    - {c[0] for c in CASES}
    - SCATTERS
    - SHAKEN
    - OF_SOAKS
    - TILTED
)


@pytest.mark.parametrize("case", [*CASES, *((name,) for name in OTHERS)], ids=lambda case: case[0])
def test_a_planted_effect_changes_the_evidence_by_its_columns(case) -> None:
    if any(lacks(BY_NAME[case[0]])):
        pytest.skip("incomplete, as its own test says")
    name, sizes, coefficients, where, shape = case if len(case) > 1 else plausible_case(*case)
    try:
        found = planted(name, sizes)
    except TruthRefused as refused:
        pytest.fail(
            f"{name} has no twin, and the simulator cannot work out its equation ({refused}): add a "
            "PlantedEffect(...) to drivers/simulated/effects.",
            pytrace=False,
        )
    agree(found, predicted(name, coefficients or sizes, where, shape), 0.03)


WRITTEN = ("accelerometer.cross_product", "gyroscope.temperature_lag")


@pytest.mark.parametrize("case", [case for case in CASES if case[0] in WRITTEN], ids=WRITTEN)
def test_the_text_of_a_law_is_planted_where_it_has_no_twin(case) -> None:
    name, sizes, coefficients, where, shape = case
    agree(planted(name, sizes, as_text=True), predicted(name, coefficients or sizes, where, shape), 0.03)


def plausible_case(name: str) -> tuple[str, dict[str, float], None, Mapping[str, object], str]:
    """Return an effect's first way as a case, every coefficient of its plausible size."""
    effect = BY_NAME[name]
    way = effect.columns(baseline().evidence.excitation)[0]
    size = effect.plausible_of(way) * np.resize([1.0, -1.0], len(way.coefficients))
    sizes = dict(zip(way.coefficients, size.tolist(), strict=True))
    return name, sizes | ({TAU: way.tau_s} if way.tau_s else {}), None, way.where, way.shape


FITTED = ("accelerometer.quadratic", "gyroscope.magnetic")


@pytest.mark.parametrize("case", [case for case in CASES if case[0] in FITTED], ids=FITTED)
def test_a_fit_leaves_of_it_what_the_base_model_cannot_take_up(case) -> None:
    name, sizes, coefficients, where, shape = case
    evidence = baseline().evidence
    after = evidence_of(fit_reduced(carried_out({name: sizes})))
    Q, _ = np.linalg.qr(evidence.A / evidence.sigma[:, None])
    got, expected = (
        white - Q @ (Q.T @ white)
        for white in (
            (after.residual - evidence.residual) / evidence.sigma,
            predicted(name, coefficients or sizes, where, shape) / evidence.sigma,
        )
    )
    assert np.linalg.norm(got - expected) < 0.01 * np.linalg.norm(expected)


every_effect = pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)


@every_effect
def test_an_effect_is_complete(effect: Effect) -> None:
    if sentences := list(lacks(effect)):
        pytest.fail("\n".join(sentences), pytrace=False)


def lacks(effect: Effect) -> Iterator[str]:
    """Say what an effect lacks, a sentence each."""
    name, twin = effect.name, PLANTED.get(effect.name)
    for field in ("unit", "physics", "source", "separate_by"):
        if not getattr(effect, field).strip():
            yield f"{name} has no {field}: give its Effect(...) in procedures/effects one."
    if not effect.plausible > 0:
        yield f"{name} has no plausible size above nought: give its Effect(...) in procedures/effects one."
    if twin is None:
        if not effect.laws:
            yield f"{name} has neither law nor twin: add a PlantedEffect(...) to drivers/simulated/effects."
    elif twin.unit != effect.unit:
        yield f"{name} is fitted in {effect.unit!r}, and planted in {twin.unit!r}: let both be one unit."
    else:
        ways = effect.columns(baseline().evidence.excitation)
        keys = {key for way in ways for key in way.coefficients}
        if strange := ({"value"} if effect.is_scatter else keys) - {*twin.keys, *twin.options}:
            yield f"{name} cannot be planted in {sorted(strange)}: let its twin have these keys."


def test_every_file_of_effects_is_in_the_catalogue() -> None:
    found = {}
    for file in pkgutil.iter_modules(effects.__path__):
        module = import_module(f"{effects.__name__}.{file.name}")
        found |= {id(each): file.name for each in vars(module).values() if isinstance(each, Effect)}
    for number in found.keys() - {id(effect) for effect in EFFECTS}:
        pytest.fail(f"procedures/effects/{found[number]}.py has an effect that is not in EFFECTS.", pytrace=False)
    assert len(BY_NAME) == len(EFFECTS), "two effects have one name"


@every_effect
def test_an_effect_is_of_the_kind_that_its_name_says(effect: Effect) -> None:
    owner = effect.name.split(".")[0]
    kinds = dict.fromkeys(INSTRUMENT, "instrument") | dict.fromkeys(BENCH, "bench")
    assert effect.kind == kinds.get(owner, "procedure")


@every_effect
def test_its_columns_fit_its_coefficients_and_no_two_ways_are_called_the_same(effect: Effect) -> None:
    evidence = baseline().evidence
    seen, ways = evidence.excitation, effect.columns(evidence.excitation)
    assert bool(ways) == (effect.columns is not no_columns and effect.name not in OF_SOAKS)
    assert len({(str(way.where), way.shape, str(way.nonlinear), way.orders) for way in ways}) == len(ways)
    for way in ways:
        assert way.accel is not None or way.gyro is not None
        assert len(effect.plausible_of(way)) == len(way.coefficients) == len(set(way.coefficients))
        assert np.all(effect.plausible_of(way) > 0)
        assert np.all(np.isfinite(evidence.column(way)))
        for part in (way.accel, way.gyro):
            assert part is None or part.shape == (len(seen.t), 3, len(way.coefficients))
