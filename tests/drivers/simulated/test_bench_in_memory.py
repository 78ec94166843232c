from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import SimulatedBench, simulate_campaign, turn_segment, world_with_effects
from drivers.simulated.cube_motion import rest
from drivers.simulated.truth import Truth, paper_truth
from procedures.arrays import FloatArray
from procedures.campaign.plan_steps import Dwell, Turn, turn_steps
from procedures.positions import face_of
from procedures.units import STANDARD_GRAVITY

QUIET = {"accel_noise_g": 0.0, "gyro_arw_deg_rt_s": 0.0, "gyro_instability_dph": 0.0}


def paper_rates(counting: bool) -> FloatArray:
    """Accelerometer count rates (12, 3) of the P1 cube: exact, or counted without noise for 100 s."""
    truth = paper_truth()
    bench = SimulatedBench(truth, None)
    if counting:
        return np.array([bench.perform(Dwell(p, 100.0)).accel.sum(0) / 100.0 for p in range(1, 13)])
    dwells = [rest(bench.world.attitude(p), None, p) for p in range(1, 13)]
    return np.array([bench.sensor.output(dwell, 0, 0, 1)[0, :3] * truth.accel_k for dwell in dwells])


@pytest.mark.parametrize(("counting", "margin_g"), [(False, 0.01e-7), (True, 1 / (100 * 1000 * 2))])
def test_the_paper_cube_gives_the_papers_bias_errors(counting: bool, margin_g: float) -> None:
    truth, rates = paper_truth(), paper_rates(counting)
    twelve = rates.mean(0) / truth.accel_k - truth.accel_d_g  # P1 eq. (8)
    two = [
        rates[4 * q : 4 * q + 4, q].mean() / truth.accel_k[q] - truth.accel_d_g[q] for q in range(3)
    ]  # (9)-(11)
    # checked without noise, printed to 5 and 3 digits
    assert np.max(np.abs(twelve - [1.6704e-4, 0.6711e-4, 1.0065e-4])) < 0.06e-7 + margin_g
    assert np.max(np.abs(np.array(two) - [5.21e-7, 6.90e-7, 10.91e-7])) < 0.06e-8 + margin_g


def test_mean_rates_follow_the_model_within_the_noise() -> None:
    seed = 1
    truth = replace(Truth.example(seed), gyro_instability_dph=0.0, heading_std_deg=0.0)
    bench, world = SimulatedBench(truth, seed), world_with_effects(truth)
    for position in range(1, 13):
        series, C_bn = bench.perform(Dwell(position, 20.0)), world.attitude(position)
        f_b = C_bn @ [0, 0, truth.local_gravity / STANDARD_GRAVITY]
        accel = truth.accel_k * (truth.accel_e @ f_b + truth.accel_d_g)
        gyro = truth.gyro_k * (truth.gyro_e @ C_bn @ world.omega_ie_n + truth.gyro_d_deg_s)
        # a count at each end, and 5 sigma of the white noise
        sigma = truth.accel_k * truth.accel_noise_g * 0.02 * np.sqrt(1000)
        assert np.all(np.abs(series.accel.sum(0) - 20 * accel) < 1 + 5 * sigma)
        sigma = truth.gyro_k * truth.gyro_arw_deg_rt_s * np.sqrt(20)
        assert np.all(np.abs(series.gyro.sum(0) - 20 * gyro) < 1 + 5 * sigma)


def test_a_closed_turn_integrates_to_whole_revolutions() -> None:
    truth = replace(Truth.example(4), slab_tilt_rad=np.array([3e-5, -2e-5]), closure_std_deg=0.0, **QUIET)
    bench = SimulatedBench(truth, None)
    omega = bench.world.omega_ie_n
    for turn in turn_steps():
        series = bench.perform(turn)
        seconds = 0.02 * len(series)
        axis_b = bench.world.attitude(turn.start_position) @ bench.world.slab_normal_n()
        sense = 1 if turn.direction == "+" else -1
        rates = (series.gyro.sum(0) / truth.gyro_k) - truth.gyro_d_deg_s * seconds
        turned = np.linalg.solve(truth.gyro_e, rates)
        along = sense * 1080.0 + omega @ bench.world.slab_normal_n() * seconds
        # the horizontal Earth rate is as uneven as the hand: bounded by what a turn of this length can leave
        assert np.max(np.abs(turned - axis_b * along)) < 0.0042 * seconds
        assert abs(turned @ axis_b - along) < 2 / 36000 + 1e-9
        speed = np.abs(np.diff(series.gyro[:, "xyz".index(turn.axis)]))
        assert max(speed[:90].max(), speed[-90:].max()) < 30, "at rest for 2 s at each end"


def test_a_turn_is_about_the_slabs_normal_however_the_slab_is_tilted() -> None:
    truth = Truth(slab_tilt_rad=np.array([3e-3, -2e-3]), slab_azimuth_rad=0.3)
    world = world_with_effects(truth)
    for position, axis in ((1, 0), (4, 0), (5, 1), (8, 1), (9, 2), (12, 2)):
        sign = 1.0 if face_of(position).endswith("up") else -1.0
        assert np.allclose(world.attitude(position) @ world.slab_normal_n(), sign * np.eye(3)[axis], atol=1e-12)


@pytest.mark.parametrize(("start", "direction", "sign"), [(1, "+", 1), (1, "-", -1), (3, "+", 1), (4, "-", -1)])
def test_a_direction_is_right_handed_about_the_cube_axis_even_where_it_points_down(start, direction, sign) -> None:
    series = SimulatedBench(Truth(**QUIET), None).perform(Turn("x", direction, 1, start, 2.0))
    assert abs(series.gyro.sum(0)[0] / 36000 - sign * 360) < 0.3


def test_what_is_fixed_in_n_is_seen_turning_the_other_way() -> None:
    truth = Truth(slab_tilt_rad=np.array([0.01, 0.02]), **QUIET)
    bench = SimulatedBench(truth, None)
    C_bn = bench.world.attitude(5)
    segment = turn_segment(bench.world, C_bn, Turn("y", "+", 1, 5, 1.0), 0.3, 0.02, np.random.default_rng(1))
    for vector_n in np.eye(3):
        seen = segment.seen(vector_n, 0, segment.samples)
        assert np.allclose(seen[0], C_bn @ vector_n, atol=1e-12)
        assert np.allclose(seen[-1], segment.end_C_bn() @ vector_n, atol=1e-12)
        # d(v_b)/dt = -omega x v_b for a vector fixed in n
        omega = segment.rate_b(0, segment.samples, 0.02)
        slope = np.gradient(seen, 0.02, axis=0)
        assert np.max(np.abs(slope + np.cross(omega, seen))) < 0.05 * np.max(np.abs(omega))


def test_equal_seeds_give_equal_campaigns_and_others_differ() -> None:
    truth = Truth.example(2)
    first, again, other = (simulate_campaign(truth, seed, dwell_s=2.0) for seed in (7, 7, 8))
    steps = [[*campaign.dwells, *campaign.turns] for campaign in (first, again, other)]
    for a, b, c in zip(*steps, strict=True):
        assert np.array_equal(a.series.gyro, b.series.gyro)
        assert np.array_equal(a.series.accel, b.series.accel)
        assert not np.array_equal(a.series.accel[:100], c.series.accel[:100])
    times = np.concatenate([step.series.t for step in steps[0]])
    assert np.all(np.diff(times) > 0.019)


def test_what_a_campaign_states_differs_from_what_is_true_by_the_stated_sigma() -> None:
    truth = replace(Truth.example(3), **QUIET)
    ups, stated = [], []
    for seed in range(40):
        campaign = simulate_campaign(
            truth, seed, dwell_s=20.0, positions=[9], turns=(), certificate_sigma=1e-5, gravity_std=1e-3
        )
        ups.append(campaign.dwells[0].series.accel.sum(0)[2] / 20 / truth.accel_k[2])
        stated.append([campaign.fixture.faces["x_up"].up_tilt, campaign.fixture.faces["z_down"].up_tilt])
    scatter = np.std(np.array(stated) - truth.faces_rad[[0, 5]]) / 1e-5
    assert abs(scatter - 1) < 4 / np.sqrt(2 * 160)
    assert abs(np.std(ups) * STANDARD_GRAVITY / 1e-3 - 1) < 4 / np.sqrt(2 * 40) + 0.1  # counting adds a little
    exact = simulate_campaign(truth, 1, dwell_s=1.0, turns=(), certificate_sigma=1e-5, draw_stated=False)
    assert np.array_equal(exact.fixture.faces["y_down"].up_tilt, truth.faces_rad[3])


def test_bias_instability_has_its_sigma_and_correlation() -> None:
    truth = replace(Truth.example(1), accel_noise_g=0.0, gyro_arw_deg_rt_s=0.0, gyro_instability_dph=30.0,
                    gyro_k=np.full(3, 1e6), instability_tau_s=20.0)  # fmt: skip
    series = SimulatedBench(truth, 5).perform(Dwell(1, 8000.0))
    per_second = series.gyro.reshape(-1, 50, 3).sum(1) / 1e6 * 3600
    deviation = per_second - per_second.mean(0)
    # 8000 s hold some 200 independent values a channel
    assert abs(np.std(deviation) / 30.0 - 1) < 4 / np.sqrt(2 * 600)
    lag = np.mean(deviation[20:] * deviation[:-20]) / np.var(deviation)
    assert abs(lag - np.exp(-1)) < 0.15
