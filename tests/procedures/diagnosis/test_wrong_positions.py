from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import multivariate_normal

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.checks_before_effects import check_campaigns
from procedures.diagnosis.dwell_headings import HeadingLikelihood
from procedures.diagnosis.wrong_positions import find_wrong_labels, label_findings, with_true_labels
from procedures.diagnosis.wrong_turn_directions import with_true_directions
from procedures.errors import WrongFace
from procedures.frames import nominal_C_lb
from tests.procedures.diagnosis.planted import lively, planted, with_reference_time


def recorded(seed: int, labels: dict[int, int], turns: bool = True) -> Campaign:
    """Return a campaign whose dwells in ``labels`` (recorded: actual) have one another's names."""
    campaign = planted(seed, dwell_s=8.0, turns=turns)
    stood = {dwell.position: dwell for dwell in campaign.dwells}
    dwells = [replace(stood[labels.get(p, p)], position=p, name=stood[p].name) for p in stood]
    return replace(campaign, dwells=tuple(dwells))


def found(campaign: Campaign) -> dict[int, int]:
    """Return the labels found wrong: recorded, actual."""
    return {campaign.dwells[each.dwell].position: each.position for each in find_wrong_labels([campaign])}


@pytest.mark.parametrize("seed", [4, 5])
def test_a_wrong_label_is_found_with_the_position_it_was(seed: int) -> None:
    rng = np.random.default_rng(seed)
    position = seed + 1
    for actual in rng.choice([p for p in range(1, 13) if p != position], 3, replace=False):
        effects = {"placement.label": {"position": float(position), "actual": float(actual)}}
        assert found(planted(seed, effects, dwell_s=6.0, turns=bool(seed % 2))) == {position: actual}


@pytest.mark.parametrize("labels", [{5: 9, 9: 5}, {1: 3, 6: 2, 9: 12}])
def test_several_wrong_labels_and_swapped_ones_are_found(labels: dict[int, int]) -> None:
    assert found(recorded(7, labels)) == labels


def test_the_half_turn_is_found_under_large_effects() -> None:
    for seed in range(2):
        position = seed + 1
        actual = position + 1 if position % 2 else position - 1
        label = {"placement.label": {"position": float(position), "actual": float(actual)}}
        assert found(planted(seed, lively(seed) | label, turns=True)) == {position: actual}


def test_right_labels_are_left_alone_whatever_else_is_wrong() -> None:
    for seed in range(4):
        assert found(planted(seed, lively(seed), dwell_s=8.0, turns=bool(seed % 2))) == {}


def test_without_gyroscopes_the_face_is_told_and_the_heading_left_open() -> None:
    campaign = planted(3, {"placement.label": {"position": 3.0, "actual": 9.0}})
    without = tuple(replace(d, series=replace(d.series, gyro=None)) for d in campaign.dwells)
    campaign = replace(campaign, dwells=without)
    findings, _ = label_findings([campaign], find_wrong_labels([campaign]))
    assert [dict(each.where) for each in findings] == [{"position": 3, "file": "dwell_03"}]
    assert findings[0].confidence == "likely"
    assert abs(findings[0].value[0] - 9) <= findings[0].std[0] == 1


def test_without_accelerometers_the_faces_are_taken_as_named_and_the_heading_is_told() -> None:
    campaign = recorded(7, {1: 2, 2: 1})
    without = tuple(replace(d, series=replace(d.series, accel=None)) for d in campaign.dwells)
    assert found(replace(campaign, dwells=without)) == {1: 2, 2: 1}


def test_solved_with_the_right_label_it_gives_the_truth() -> None:
    effects = {"placement.label": {"position": 3.0, "actual": 12.0}}
    campaign = planted(5, effects, turns=True)
    with pytest.raises(WrongFace):
        solve([campaign])
    corrected = with_true_labels([campaign], find_wrong_labels([campaign]))
    assert corrected[0].dwells[2].position == 12
    got, expected = solve(corrected).accelerometer, solve([planted(5, turns=True)]).accelerometer
    assert got is not None
    assert expected is not None
    assert np.all(np.abs(got.bias.value - expected.bias.value) < 4 * got.bias.std)


# Turns about one axis whose labels are exchanged: told by the Earth's rate in the dwells, and turned round


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return simulate_campaign(Truth.example(1), 1, dwell_s=30.0)


def relabelled(campaign: Campaign, axis: str) -> Campaign:
    other = {"+": "-", "-": "+"}
    return replace(campaign, turns=tuple(
        replace(turn, direction=other[turn.direction]) if turn.axis == axis else turn for turn in campaign.turns
    ))  # fmt: skip


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_turns_with_the_wrong_label_are_turned_round_and_named(campaign: Campaign, axis: str) -> None:
    (corrected,), (finding,) = with_true_directions([relabelled(campaign, axis)])
    assert [turn.direction for turn in corrected.turns] == [turn.direction for turn in campaign.turns]
    assert finding.where == {"file": [turn.name for turn in campaign.turns if turn.axis == axis]}
    assert finding.confidence == "established"


def test_right_labels_are_left_alone(campaign: Campaign) -> None:
    (same,), findings = with_true_directions([campaign])
    assert same is campaign
    assert findings == ()


def test_a_label_a_knock_and_the_clock_are_put_right_together() -> None:
    effects = {
        "placement.label": {"position": 2.0, "actual": 9.0},
        "disturbance.dwell": {"x": 0.03, "y": 0.02, "position": 7.0, "at_s": 12.0, "duration_s": 4.0, "hz": 7.3},
        "clock.rate": {"value": -400.0},
    }
    campaign = with_reference_time(planted(8, effects, 30.0, turns=True), -400.0, 8)
    found = check_campaigns([campaign])
    assert [each.effect for each in found.findings] == ["placement.label", "disturbance.dwell", "clock.rate"]
    assert {each.confidence for each in found.findings} == {"established"}
    assert found.settled == {"placement.label", "disturbance.dwell", "clock.rate"}
    got, expected = (
        solve(found.campaigns).accelerometer,
        solve([planted(8, dwell_s=30.0, turns=True)]).accelerometer,
    )
    assert got is not None
    assert expected is not None
    for mine, true in ((got.bias, expected.bias), (got.scale_factor, expected.scale_factor)):
        assert np.all(np.abs(mine.value - true.value) < 4 * np.hypot(mine.std, true.std))


def test_a_clean_campaign_is_left_as_it_is() -> None:
    campaign = planted(9, turns=True)
    found = check_campaigns([campaign])
    assert found.findings == ()
    assert found.campaigns[0].dwells == campaign.dwells
    assert "clock.rate" not in found.settled


# Labellings of dwells judged by their gyros, beside the multivariate normal distribution itself


C_SB = Rotation.from_euler("ZYX", (0.5, 0.2, -0.3)).as_matrix()
TRUE = [*range(1, 13)]
DPH = 1 / 3600.0  # deg/s
SCATTERS = np.array([0.1, 0.4, 1.5, 6.0, 25.0, 100.0]) * DPH
H = np.diag([8.0, -9.0, 10.0]) * DPH  # of North, rates over the largest of K


def likelihood(noise: float = 0.5 * DPH) -> HeadingLikelihood:
    rng, rows = np.random.default_rng(2), np.array([0, 1, 2, *range(4, 12)])
    north = np.array([C_SB @ nominal_C_lb(TRUE[i])[1] for i in rows])
    up = np.array([C_SB @ nominal_C_lb(TRUE[i])[2] for i in rows])
    bias, by_up = np.array([0.3, -0.2, 0.1]), 0.004 * rng.normal(size=(3, 3))
    rate = bias + up @ by_up.T + north @ (1.2 * H).T + noise * rng.normal(size=(11, 3))
    variance = np.tile(noise**2 * np.array([1.0, 1.2, 1.4])[None], (11, 1)) * np.linspace(1, 2, 11)[:, None]
    hours = np.linspace(0.0, 0.9, 11) ** 2
    return HeadingLikelihood(C_SB, rows, rate, variance, hours - hours.mean(), H)


def cost(judge: HeadingLikelihood, labelling: list[int]) -> float:
    """Return the negative log density of all gyros, the coefficients integrated out."""
    C_bl = [nominal_C_lb(labelling[i]).T for i in judge.rows]
    up, north = (np.array([judge.C_sb @ each[:, column] for each in C_bl]) for column in (2, 1))
    totals = []
    for scatter in SCATTERS:
        total = 0.0
        for q in range(3):
            H_q = judge.H[q]
            covariance = np.diag(judge.variance[:, q] + scatter**2) + 1.0**2
            covariance += 0.01**2 * up @ up.T + (0.5 * np.linalg.norm(H_q)) ** 2 * north @ north.T
            covariance += (10.0 * DPH) ** 2 * np.outer(judge.hours, judge.hours)
            total -= multivariate_normal(north @ H_q, covariance).logpdf(judge.rate[:, q])
        totals.append(total)
    return min(totals)


def test_costs_are_negative_log_likelihoods_up_to_a_constant() -> None:
    judge, other = likelihood(), [TRUE, [2, *TRUE[1:]], [1, 1, 4, 4, 5, 6, 8, 8, 9, 10, 12, 11]]
    costs = judge.costs(np.array(other))
    expected = np.array([cost(judge, each) for each in other])
    np.testing.assert_allclose(np.diff(costs), np.diff(expected), rtol=1e-6)
    assert costs[0] - expected[0] == pytest.approx(-16.5 * np.log(2 * np.pi))  # 33 rates


@pytest.mark.parametrize("wrong", [[1, 5], [2, 3, 4]])
def test_the_best_labelling_is_found_one_or_two_dwells_at_a_time(wrong: list[int]) -> None:
    judge = likelihood(0.05 * DPH)
    start = [(p + 1 if p % 2 else p - 1) if i in wrong else p for i, p in enumerate(TRUE)]
    found, margins = judge.best(start)
    kept = [start[i] if i == 3 else p for i, p in enumerate(TRUE)]  # the gyros say nothing of the fourth
    assert found == kept
    assert margins[3] == 0.0
    one = [found[0] + 1, *found[1:]]
    assert margins[0] == pytest.approx(float(np.diff(judge.costs(np.array([found, one])))[0]))
    assert (np.delete(margins, 3) > 0.0).all()
