"""From campaigns to a solution.

Where the estimate of rates is not what is tested, units count so finely that remainders do not matter: such
campaigns are solved in a tenth of the time.
"""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import solve
from procedures.calibration.solution_values import Solution, TriadCalibration
from procedures.campaign.campaign import Campaign, FaceCertificate, Fixture
from procedures.counts.sample_records import CountSeries, RateSeries, Series
from procedures.errors import ErrorCode, FitsNoFace, NotObservable
from procedures.positions import FACES
from station.files.campaign_folder.campaign_reading import read_campaign
from tests.paths import DATA
from tests.procedures.calibration.simulated_campaigns import OFF, fine, scores, simulated, usual, z
from tests.refusals import refused

CAMPAIGNS = DATA / "campaigns"
OFF_DIAGONAL = ("xy", "xz", "yx", "yz", "zx", "zy")


def both(solution: Solution) -> tuple[TriadCalibration, TriadCalibration]:
    assert solution.accelerometer is not None
    assert solution.gyroscope is not None
    return solution.accelerometer, solution.gyroscope


def mapped(campaign: Campaign, change: Callable[[Series], Series]) -> Campaign:
    """The campaign with every recording changed."""
    return replace(
        campaign,
        dwells=tuple(replace(d, series=change(d.series)) for d in campaign.dwells),
        turns=tuple(replace(t, series=change(t.series)) for t in campaign.turns),
    )


def mean_cube_of(faces: FloatArray) -> FloatArray:
    normals = np.eye(3)
    for pair in range(3):
        others = [i for i in range(3) if i != pair]
        normals[others, pair] = (faces[2 * pair] - faces[2 * pair + 1]) / 2
    return normals


def referred(E: FloatArray, cube: FloatArray) -> FloatArray:
    turned = E @ cube
    return turned / np.linalg.norm(turned, axis=1)[:, None]


@pytest.mark.parametrize("name", ["clean", "bench_only"])
def test_the_reference_campaigns_are_solved_within_four_sigma(name: str) -> None:
    if not (CAMPAIGNS / name).is_dir():
        pytest.skip(f"no reference campaign {name} in {CAMPAIGNS}: set STATION_DATA")
    solution = solve([read_campaign(CAMPAIGNS / name).campaign])
    planted = json.loads((CAMPAIGNS / name / "truth.json").read_text())["truth"]
    accel, gyro = both(solution)
    faces = np.array(planted["faces"])
    cube = mean_cube_of(faces)
    for triad, k, E, D in (
        (accel, "ka", "Ea", np.array(planted["Da"])),
        (gyro, "kg", "Eg", np.array(planted["Dg"]) * 3600),
    ):
        assert np.abs(z(triad.scale_factor, np.array(planted[k]))).max() < 4
        assert np.abs(z(triad.bias, D)).max() < 4
        # without a certificate E refers to the mean cube
        assert np.abs(z(triad.misalignment, referred(np.array(planted[E]), cube))[OFF]).max() < 4
    assert solution.slab_tilt is not None
    assert solution.parallelism is not None
    assert np.abs(z(solution.slab_tilt, -np.array(planted["slab"]))).max() < 4  # data/README: up is (-s_e, -s_n)
    assert np.abs(z(solution.parallelism, faces[0::2] + faces[1::2])).max() < 4
    assert solution.quality.p_value > 1e-3
    assert not [w for w in solution.warnings if "residual" in w]


def test_a_campaign_on_a_coarse_counter_is_solved_within_four_sigma() -> None:
    truth = Truth.example(1)
    assert np.abs(scores(solve([simulate_campaign(truth, 1)]), truth)).max() < 4


def test_an_imu_turned_in_the_cube_is_solved_in_its_own_axes() -> None:
    truth = replace(fine(4), imu_axes=("-y", "+z", "-x"))
    campaign = simulated(truth, 4)
    assert not np.array_equal(campaign.fixture.C_sb, np.eye(3))
    solution = solve([campaign])
    assert np.abs(scores(solution, truth)).max() < 4
    cube = campaign.fixture.C_sb @ mean_cube_of(truth.faces_rad) @ campaign.fixture.C_sb.T
    for triad, E in zip(both(solution), (truth.accel_e, truth.gyro_e), strict=True):
        assert np.abs(z(triad.misalignment, referred(E, cube))[OFF]).max() < 4


def test_a_certificate_makes_misalignment_the_imu_s_own() -> None:
    truth = fine(5)
    with_it, without = (solve([simulated(truth, 5, certificate_sigma=s)]) for s in (5e-6, None))
    assert np.abs(scores(with_it, truth, misalignment=True)).max() < 4
    assert np.abs(scores(without, truth)).max() < 4
    assert not any("perpendicularity" in name for name in with_it.not_observable)
    assert sum("perpendicularity" in name for name in without.not_observable) == 6


def test_a_wrong_certificate_shows_in_the_residual() -> None:
    _, campaign = usual()
    faces = {face: FaceCertificate(np.array([2e-4, -2e-4]), 1e-12 * np.eye(2)) for face in FACES}
    solution = solve([replace(campaign, fixture=Fixture(faces))])
    assert solution.quality.p_value < 1e-6
    assert any("residual" in warning for warning in solution.warnings)


def test_repeated_positions_are_used() -> None:
    truth = fine(6)
    once = solve([simulated(truth, 6, turns=())])
    twice = solve([simulated(truth, 6, turns=(), positions=[*range(1, 13), *range(1, 13)])])
    assert np.abs(scores(twice, truth)).max() < 4
    assert once.accelerometer is not None
    assert twice.accelerometer is not None
    gain = twice.accelerometer.bias.std / once.accelerometer.bias.std
    assert np.all(gain < 0.85)  # noise falls by 0.71; what the skew leaves open does not
    assert twice.accelerometer.bias_12_position is not None


@pytest.mark.parametrize("ids", [("A", "A"), ("A", "B"), (None, None)])
def test_two_campaigns_of_one_unit_are_better_than_one(ids: tuple[str | None, str | None]) -> None:
    truth = fine(7)
    other = truth if ids[0] == ids[1] == "A" else replace(truth, faces_rad=np.roll(truth.faces_rad, 1, axis=0))
    pair = [simulated(truth, 7), simulated(other, 8)]
    pair = [replace(c, fixture=replace(c.fixture, id=name)) for c, name in zip(pair, ids, strict=True)]
    one, joint = solve(pair[:1]), solve(pair)
    assert np.abs(scores(joint, truth)).max() < 4
    for single, double in zip(both(one), both(joint), strict=True):
        assert np.all(double.bias.std < single.bias.std)
    assert np.all(both(joint)[1].scale_factor.std < 0.8 * both(one)[1].scale_factor.std)


@pytest.mark.parametrize("positions", [tuple(range(1, 12)), (2, 4, 6, 8, 10, 12, 1)])
def test_fewer_positions_are_solved_within_four_sigma(positions: tuple[int, ...]) -> None:
    truth = fine(8)
    solution = solve([simulated(truth, 8, positions=positions)])
    assert np.abs(scores(solution, truth)).max() < 4
    accel, _ = both(solution)
    assert accel.bias_12_position is None
    assert accel.bias_two_direction is None


def test_two_faces_are_refused_by_what_is_missing() -> None:
    _, campaign = usual()
    few = replace(campaign, dwells=campaign.dwells[:4], turns=())
    missing = tuple(f"position {p}" for p in range(5, 13))
    with refused(NotObservable, ErrorCode.NOT_OBSERVABLE, missing=missing):
        solve([few])


@pytest.mark.parametrize(("absent", "left"), [("gyro", "accelerometer"), pytest.param("accel", "gyroscope")])
def test_a_triad_that_is_absent_is_left_out(absent: str, left: str) -> None:
    truth, campaign = usual()
    solution = solve([mapped(campaign, lambda s: replace(s, **{absent: None}))])
    other = {"accelerometer": "gyroscope", "gyroscope": "accelerometer"}[left]
    assert getattr(solution, other) is None
    assert getattr(solution, left) is not None
    assert f"{other}.scale_factor" in solution.not_observable
    assert all(name.startswith((left, "slab", "fixture")) for name in solution.names)
    if left == "accelerometer":
        assert np.abs(scores(solution, truth)).max() < 4


def test_gyroscopes_alone_have_honest_sigmas() -> None:
    truth, campaign = usual()
    solution = solve([mapped(campaign, lambda s: replace(s, accel=None))])
    assert np.abs(scores(solution, truth)).max() < 4


def test_without_turns_there_is_no_gyroscope_and_a_warning_says_why() -> None:
    truth, campaign = usual()
    solution = solve([replace(campaign, turns=())])
    assert solution.gyroscope is None
    assert "gyroscope.bias" in solution.not_observable
    assert any("gyroscope not solved" in warning and "x, y, z" in warning for warning in solution.warnings)
    assert np.abs(scores(solution, truth)).max() < 4


def test_a_missing_axis_leaves_the_gyroscope_out_and_names_the_unused_turns() -> None:
    _, campaign = usual()
    solution = solve([replace(campaign, turns=campaign.turns[:4])])
    assert solution.gyroscope is None
    assert any("no turn about z" in warning for warning in solution.warnings)
    assert solution.unused_steps == tuple(t.name for t in campaign.turns[:4])


def test_names_and_covariance_are_those_of_the_values() -> None:
    _, campaign = usual()
    solution = solve([campaign])
    assert solution.slab_tilt is not None
    assert solution.parallelism is not None
    parts = {"slab.tilt": (solution.slab_tilt, 1.0), "fixture.parallelism": (solution.parallelism, 1.0)}
    for name in ("accelerometer", "gyroscope"):
        for part in ("scale_factor", "misalignment", "bias"):
            parts[f"{name}.{part}"] = (getattr(getattr(solution, name), part), 1.0)
    std = np.sqrt(np.diag(solution.covariance))
    for part, (estimate, _) in parts.items():
        index = [i for i, name in enumerate(solution.names) if name.startswith(part + ".")]
        assert std[index] == pytest.approx(estimate.std.ravel(), rel=1e-12)
    assert len(solution.names) == len(set(solution.names)) == 15 + 8 + 15 == len(solution.covariance)
    assert solution.covariance == pytest.approx(solution.covariance.T)
    assert solution.names[3:6] == tuple(f"accelerometer.misalignment.{pair}" for pair in ("xx", "xy", "xz"))
    scale = np.where(std > 0, std, 1.0)
    assert np.linalg.eigvalsh(solution.covariance / np.outer(scale, scale)).min() > -1e-6


def test_a_rate_output_is_solved() -> None:
    """ADC counts of white noise, with an offset, as a sensor without an integrator puts out."""
    truth, campaign = usual()
    solution = solve([replace(mapped(campaign, rates), counts=False)])
    accel, gyro = both(solution)
    assert accel.scale_factor.unit == "output/g"
    assert gyro.scale_factor.unit == "output/(deg/s)"
    assert np.abs(scores(solution, truth)).max() < 4
    counted = both(solve([campaign]))[0]
    assert accel.bias.std == pytest.approx(counted.bias.std, rel=0.3)


def rates(series: Series) -> Series:
    assert isinstance(series, CountSeries)
    assert series.gyro is not None
    assert series.accel is not None
    gyro, accel = (x / series.period for x in (series.gyro, series.accel))
    return RateSeries(series.t, gyro, accel, series.temperature, series.period, series.starts)


@pytest.mark.parametrize("triad", ["accel", "gyro"])
def test_a_triad_with_a_dead_channel_is_left_out(triad: str) -> None:
    truth, campaign = usual()

    def dead(series: Series) -> Series:
        samples = np.array(getattr(series, triad))
        samples[:, 0] = 0
        return replace(series, **{triad: samples})

    solution = solve([mapped(campaign, dead)])
    assert (solution.accelerometer if triad == "accel" else solution.gyroscope) is None
    assert np.abs(scores(solution, truth)).max() < 4


def test_a_channel_that_answers_to_nothing_but_noise_leaves_its_triad_out() -> None:
    truth, campaign = usual()
    rng = np.random.default_rng(1)

    def deaf(series: Series) -> Series:
        samples = np.array(series.accel)
        samples[:, 1] = rng.integers(-40, 41, len(samples))
        return replace(series, accel=samples)

    solution = solve([mapped(campaign, deaf)])
    assert solution.accelerometer is None
    assert any("accelerometer not solved" in warning for warning in solution.warnings)
    assert np.abs(scores(solution, truth)).max() < 4


def test_a_unit_that_sends_nothing_but_zeros_is_not_observable() -> None:
    _, campaign = usual()

    def silent(series: Series) -> Series:
        return replace(series, gyro=np.zeros_like(series.gyro), accel=np.zeros_like(series.accel))

    with refused(NotObservable, ErrorCode.NOT_OBSERVABLE):
        solve([mapped(campaign, silent)])


def test_one_absurd_sample_names_its_own_dwell_and_no_other_face() -> None:
    _, campaign = usual()
    first = campaign.dwells[0]
    accel = np.array(first.series.accel)
    accel[7, 0] = 2_000_000_000
    spoilt = replace(first, series=replace(first.series, accel=accel))
    with refused(FitsNoFace, step=first.name, position=first.position):
        solve([replace(campaign, dwells=(spoilt, *campaign.dwells[1:]))])


@pytest.mark.parametrize("exchanged", [("x",), ("x", "y", "z")])
def test_turns_labelled_the_wrong_way_round_do_not_pass_unseen(exchanged: tuple[str, ...]) -> None:
    _, campaign = usual()
    other = {"+": "-", "-": "+"}
    turns = tuple(replace(t, direction=other[t.direction]) if t.axis in exchanged else t for t in campaign.turns)
    solution = solve([replace(campaign, turns=turns)])
    assert solution.quality.p_value < 1e-6
    assert any("residual" in warning for warning in solution.warnings)


@cache
def many(certified: bool) -> list[tuple[Truth, Solution]]:
    """Two dozen units on as many cubes; gravity, headings, closures and certificates drawn from stated sigmas."""
    found = []
    for seed in range(500, 524):
        truth = fine(seed)
        found.append((truth, solve([simulated(truth, seed, certificate_sigma=5e-6 if certified else None)])))
    return found


@pytest.mark.proof
@pytest.mark.parametrize("certified", [False, True])
def test_errors_are_as_large_as_their_sigmas_say(certified: bool) -> None:
    """The short form of tests/benchmarks/coverage.py."""
    everything = np.array([scores(solution, truth, certified) for truth, solution in many(certified)])
    assert 0.8 < np.sqrt(np.mean(everything**2)) < 1.2
    assert np.abs(everything).max() < 5


def test_what_the_triads_share_cancels_in_the_angles_between_them() -> None:
    """Certified faces are 5e-6 rad off and tilt both triads alike: between them angles are far better known."""
    errors = []
    for truth, solution in many(True):
        accel, gyro = (triad.misalignment for triad in both(solution))
        at = [
            solution.names.index(f"{triad}.misalignment.{pair}")
            for triad in ("accelerometer", "gyroscope")
            for pair in OFF_DIAGONAL
        ]
        difference = np.hstack((np.eye(6), -np.eye(6)))
        C = solution.covariance[np.ix_(at, at)]
        std = np.sqrt(np.diag(difference @ C @ difference.T))
        assert np.all(std < 0.3 * np.minimum(accel.std, gyro.std)[OFF])
        errors.append(((accel.value - truth.accel_e) - (gyro.value - truth.gyro_e))[OFF] / std)
    assert 0.8 < np.sqrt(np.mean(np.square(errors))) < 1.2  # 144 numbers


def test_residuals_over_their_sigmas_are_unit_normals() -> None:
    steps = [step for _, solution in many(False) for step in solution.residuals]
    for kind, triad in (("dwell", "accelerometer"), ("dwell", "gyroscope"), ("turn", "gyroscope")):
        found = np.array([s.residual / s.sigma for s in steps if s.kind == kind and s.triad == triad])
        assert len(found) == 24 * (12 if kind == "dwell" else 6)
        assert 0.9 < np.sqrt(np.mean(found**2)) < 1.1  # 432 values or more, less what the fit ties together
        assert np.abs(np.mean(found)) < 0.15


def test_the_global_test_is_uniform_where_the_model_is_right() -> None:
    p = np.sort([solution.quality.p_value for _, solution in many(True)])
    distance = np.max(np.abs(p - (np.arange(24) + 0.5) / 24))
    assert distance < 0.40  # Kolmogorov-Smirnov, 24 values, one in two thousand


def test_the_closed_forms_of_the_papers_stand_next_to_the_fit_and_are_the_units_bias() -> None:
    truth = replace(fine(8), faces_rad=np.zeros((6, 2)))
    accelerometer, _ = both(solve([simulate_campaign(truth, 8, dwell_s=2.0)]))
    for found in (accelerometer.bias_12_position, accelerometer.bias_two_direction):
        assert found is not None
        assert found.value == pytest.approx(truth.accel_d_g, abs=5e-5)
