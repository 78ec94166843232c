"""The uncertainty budget: its parts are all of the sigma, each stands for what it says, GTC combines them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits, fit, report
from procedures.campaign.campaign import Campaign, RestRecord
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.diagnose import diagnose
from procedures.uncertainty import sources
from procedures.uncertainty.budget import ParameterBudget, budget, combined_budget
from procedures.uncertainty.sources import EXACT, SOURCES, GivenValues, SourceCell
from procedures.units import RAD_S_PER_DEG_H
from tests.procedures.free_positions.test_gyroscopes_from_moves import campaign_of

SHORT = 10.0  # s a dwell


@cache
def simulated(seed: int, certificate: float | None = None, swing: float = 0.0, drift: float = 0.0) -> Campaign:
    truth = replace(
        Truth.example(7), temperature_swing_k=swing, gyro_instability_dph=0.5, accel_noise_g=3e-4,
        effects={"accelerometer.bias_temperature": {"x": drift}} if drift else {},
    )  # fmt: skip
    return simulate_campaign(truth, seed, dwell_s=SHORT, certificate_sigma=certificate)


def as_rates(campaign: Campaign) -> Campaign:
    """The same campaign of a unit that puts out counts per second as reals."""

    def series(one: object) -> RateSeries:
        s = one.series  # type: ignore[attr-defined]
        return RateSeries(s.t, s.gyro / s.period, s.accel / s.period, s.temperature, s.period)

    dwells = tuple(replace(d, series=series(d)) for d in campaign.dwells)
    return replace(
        campaign, counts=False, dwells=dwells, turns=tuple(replace(t, series=series(t)) for t in campaign.turns)
    )


def tumbled() -> Campaign:
    """Six faces by name besides, and their headings unknown."""
    campaign = simulated(3)
    faces = {1: "x_up", 3: "x_down", 5: "y_up", 7: "y_down", 9: "z_up", 11: "z_down"}
    rests = tuple(RestRecord(f"rest {p}", face, campaign.dwells[p - 1].series) for p, face in faces.items())
    return replace(campaign, rests=rests)


def unsettled() -> Campaign:
    campaign = simulated(4)
    stated = replace(campaign.sigma, unsettled_gyro=0.3 * RAD_S_PER_DEG_H, unsettled_accelerometer=1e-4)
    return replace(campaign, sigma=stated)


KINDS = {
    "no certificate": lambda: [simulated(1)],
    "faces certified": lambda: [simulated(1, 5e-6)],
    "two days": lambda: [simulated(1), simulated(2)],
    "rates": lambda: [as_rates(simulated(1))],
    "faces without heading": lambda: [tumbled()],
    "unsettled": lambda: [unsettled()],
    "accelerometers alone": lambda: [replace(simulated(1), turns=())],
    "free attitudes and moves": lambda: [campaign_of(1, accel_noise=1e-3, gyro_noise=0.1)[0]],
}


@pytest.mark.parametrize("kind", KINDS)
def test_the_parts_are_all_of_the_solution_s_sigma(kind: str) -> None:
    fits = fitted(*KINDS[kind]())
    solution, budgets = report(fits), budget(fits, EXACT)
    sigma = dict(zip(solution.names, np.sqrt(np.diag(solution.covariance)), strict=True))
    assert [one.name for one in budgets] == [
        name for name in solution.names
        if name.split(".")[1] in ("scale_factor", "bias") or ("misalignment" in name and name[-1] != name[-2])
    ]  # fmt: skip
    for one in budgets:
        parts = [
            part for part in one.contributions if part.source not in (sources.UNEXPLAINED, sources.TEMPERATURE)
        ]
        assert sum(part.std**2 for part in parts) == pytest.approx(sigma[one.name] ** 2, rel=2e-9)
        assert sum(part.std**2 for part in one.contributions) == pytest.approx(one.std**2, rel=1e-12)
        assert one.expanded == one.coverage_factor * one.std
        assert {part.source for part in parts} <= set(SOURCES)


def by_name(campaigns: list[Campaign], inputs: GivenValues = EXACT) -> dict[str, ParameterBudget]:
    return {one.name: one for one in budget(fitted(*campaigns), inputs)}


@cache
def fitted(*campaigns: Campaign) -> CampaignFits:
    return fit(campaigns)


def part(one: ParameterBudget, source: str) -> float:
    return next((each.std for each in one.contributions if each.source == source), 0.0)


def test_each_part_grows_with_its_own_source_and_no_other() -> None:
    campaign = simulated(1, 5e-6)
    before = by_name([campaign])
    site, sigma = campaign.site, campaign.sigma
    wider = {
        (sources.CLOSURE, "gyroscope.scale_factor.x"): replace(
            campaign, sigma=replace(sigma, closure=1.1 * sigma.closure)
        ),
        (sources.GRAVITY, "accelerometer.scale_factor.y"): replace(
            campaign, site=replace(site, gravity_std=1.1 * site.gravity_std)
        ),
        (sources.HEADING, "gyroscope.bias.z"): replace(
            campaign, sigma=replace(sigma, heading=1.1 * sigma.heading)
        ),
    }
    for (source, name), changed in wider.items():
        after = by_name([changed])[name]
        assert part(after, source) == pytest.approx(1.1 * part(before[name], source), rel=2e-2), source
        for other in set(SOURCES) - {source}:
            assert part(after, other) == pytest.approx(part(before[name], other), rel=2e-2, abs=2e-3 * after.std)


def test_latitude_does_what_a_solve_at_another_latitude_shows() -> None:
    campaign, step = simulated(1), 1e-3
    moved = replace(campaign, site=replace(campaign.site, latitude=campaign.site.latitude + step))
    shift = shifts(fit([moved]), fitted(campaign))
    for name, one in by_name([campaign], GivenValues(step, 0.0)).items():
        if name.startswith("gyroscope"):
            assert part(one, sources.LATITUDE) == pytest.approx(abs(shift[name]), rel=0.05, abs=2e-3 * one.std)
        else:
            assert part(one, sources.LATITUDE) == 0


@pytest.mark.parametrize("rates", [False, True])
def test_the_clock_does_what_a_solve_with_another_second_shows(rates: bool) -> None:
    campaign, step = simulated(1), 1e-4
    campaign = as_rates(campaign) if rates else campaign

    def slowed(record: object) -> object:
        s = record.series  # type: ignore[attr-defined]
        return replace(record, series=replace(s, t=s.t * (1 + step), period=s.period * (1 + step)))  # type: ignore[type-var]

    other = replace(
        campaign, dwells=tuple(map(slowed, campaign.dwells)), turns=tuple(map(slowed, campaign.turns))  # type: ignore[arg-type]
    )  # fmt: skip
    shift = shifts(fit([other]), fitted(campaign))
    budgets = by_name([campaign], GivenValues(0.0, step))
    for name, one in budgets.items():
        assert part(one, sources.CLOCK) == pytest.approx(abs(shift[name]), rel=0.05, abs=2e-2 * by_name_std(one))
    moved = "gyroscope.scale_factor.x" if rates else "accelerometer.scale_factor.x"
    assert part(budgets[moved], sources.CLOCK) == pytest.approx(step * budgets[moved].value, rel=1e-3)


def by_name_std(one: ParameterBudget) -> float:
    """The sigma of a parameter without the clock."""
    return float(np.sqrt(one.std**2 - part(one, sources.CLOCK) ** 2))


def shifts(after: CampaignFits, before: CampaignFits) -> dict[str, float]:
    a, b = ({one.name: one.value for one in budget(fits, EXACT)} for fits in (after, before))
    return {name: a[name] - b[name] for name in b}


def test_a_bias_that_follows_the_temperature_is_found_and_covered() -> None:
    drift = 3e-4  # g/K, times 2 K of swing
    seeds = [by_name([simulated(seed, swing=2.0, drift=drift)])["accelerometer.bias.x"] for seed in range(4)]
    for one in seeds:
        assert part(one, sources.TEMPERATURE) > 3 * np.sqrt(one.std**2 - part(one, sources.TEMPERATURE) ** 2)
        assert part(one, sources.UNEXPLAINED) < part(one, sources.TEMPERATURE)


def test_temperature_that_does_nothing_adds_nothing() -> None:
    for seed in range(4):
        one = by_name([simulated(seed, swing=2.0)])["accelerometer.bias.x"]
        assert part(one, sources.TEMPERATURE) == 0


def test_what_no_source_explains_is_a_line_of_its_own() -> None:
    campaign = simulated(1)
    assert part(by_name([campaign])["accelerometer.bias.x"], sources.UNEXPLAINED) == 0
    dwells = list(campaign.dwells)
    samples = np.array(dwells[2].series.accel)
    samples[::25, 0] += 1  # 2 count/s: 2 mg
    dwells[2] = replace(dwells[2], series=replace(dwells[2].series, accel=samples))
    one = by_name([replace(campaign, dwells=tuple(dwells))])["accelerometer.bias.x"]
    assert part(one, sources.UNEXPLAINED) > 0.8 * one.std
    assert one.dof < 20
    assert one.coverage_factor > 2.08  # Student's at 20


def test_bias_instability_has_the_few_degrees_of_freedom_of_the_dwells() -> None:
    one = by_name([simulated(1)])["gyroscope.bias.x"]
    (found,) = [each for each in one.contributions if each.source == sources.INSTABILITY]
    assert 15 < found.dof < 33  # 36 rates less three biases and what they share with the turns
    assert part(one, sources.INSTABILITY) > 0.8 * one.std
    assert one.coverage_factor > 2.0


def test_degrees_of_freedom_are_those_of_welch_and_satterthwaite() -> None:
    variance = {SourceCell("counting noise", "x", 12.0): 4.0, SourceCell("counting noise", "y", 5.0): 1.0,
    SourceCell("cube"): 2.5,
                SourceCell("bias instability", "", 7.5): 3.0}  # fmt: skip
    one = combined_budget("accelerometer.bias.x", 1.0, "g", variance)
    by_hand = 10.5**2 / (4.0**2 / 12 + 1.0**2 / 5 + 3.0**2 / 7.5)
    assert one.std == pytest.approx(np.sqrt(10.5))
    assert one.dof == pytest.approx(by_hand, rel=1e-9)
    assert [(each.source, each.type) for each in one.contributions] == [
        ("counting noise", "A"), ("bias instability", "A"), ("cube", "B"),
    ]  # fmt: skip
    assert one.contributions[0].dof == pytest.approx(25.0 / (16 / 12 + 1 / 5))
    assert combined_budget("n", 0.0, "1", {SourceCell("cube"): 1.0}).coverage_factor == pytest.approx(1.959964)
    assert combined_budget("n", 0.0, "1", {SourceCell("cube", "", 3.0): 1.0}).coverage_factor == pytest.approx(
        3.182446
    )


def test_effects_in_the_model_are_a_line_of_their_own_and_the_budget_still_adds_up() -> None:
    warm = {"temperature_rise_k": 6.0, "temperature_tau_s": 900.0, "temperature_swing_k": 2.0}
    truth = replace(Truth.example(3), **warm, effects={"accelerometer.bias_temperature": {"x": 2e-5, "y": -2e-5}})
    found = diagnose([simulate_campaign(truth, 3, dwell_s=30.0)])
    solution = report(found.after)
    std = dict(zip(solution.names, np.sqrt(np.diag(solution.covariance)), strict=True))
    budgets = {one.name: one for one in budget(found.after, EXACT)}
    bias = budgets["accelerometer.bias.x"]
    assert "effects added" in [part.source for part in bias.contributions]
    assert all(abs(one.std / std[name] - 1) < 1e-4 for name, one in budgets.items())


def test_six_faces_by_hand_have_the_prior_of_the_angles_in_their_budget() -> None:
    """Only the prior says how far the sensors are from right angles: without its share U is too small."""
    rng, up = np.random.default_rng(7), np.vstack((np.eye(3), -np.eye(3)))
    tilted = up + np.radians(2.0) * rng.standard_normal((6, 3))
    attitudes = [turned_up(each / np.linalg.norm(each)) for each in tilted]
    truth = Truth.example(5)
    campaign = simulate_campaign(truth, 5, dwell_s=20.0, positions=(), free=attitudes)
    fits = fitted(campaign)
    solution = report(fits)
    sigma = dict(zip(solution.names, np.sqrt(np.diag(solution.covariance)), strict=True))
    for one in budget(fits, EXACT):
        if one.name.startswith("accelerometer.") and one.name.split(".")[1] in ("scale_factor", "bias"):
            left = (sources.UNEXPLAINED, sources.TEMPERATURE)
            parts = [each for each in one.contributions if each.source not in left]
            assert sum(each.std**2 for each in parts) == pytest.approx(sigma[one.name] ** 2, rel=1e-6)


def turned_up(up: FloatArray) -> FloatArray:
    """Return a rotation C_bl whose last column, the vertical in the body, is ``up``."""
    other = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    east = other / np.linalg.norm(other)
    return np.column_stack((east, np.cross(up, east), up))
