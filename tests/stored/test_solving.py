"""Solutions of made campaigns: twelve positions and turns, rests anywhere, moves between rests, rates."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.calibration.joint_calibration import fit, report
from procedures.calibration.residuals import fit_quality
from procedures.campaign.campaign import Campaign, RestRecord, Site
from procedures.campaign.plan_steps import turn_steps
from procedures.frames import rotation
from procedures.uncertainty.budget import budget
from procedures.uncertainty.given_values import GivenValues, Unexplained
from procedures.units import STANDARD_GRAVITY
from tests.benchmarks.diagnosing.designs import unit as simulated_unit
from tests.procedures.free_units import LATITUDE, sequence, unit
from tests.stored.held import assert_held

# other kernels of OpenBLAS round them otherwise; of moves even which sources are nought
ROUNDED = (".contributions.dof", ".slab_tilt.value", ".parallelism.value.1")
OF_MOVES = (".contributions.type", ".contributions.source", ".contributions.std")
TURNS = turn_steps(2, 3.0)


def assert_solution_held(name: str, campaigns: list[Campaign], rounded: tuple[str, ...] = ()) -> None:
    """Hold the solution, how well it fits and where its uncertainty comes from."""
    fits = fit(campaigns)
    joint = fits.accelerometer
    quality = None if joint is None else fit_quality(joint, None)
    left = {"accelerometer": Unexplained(1e-6), "gyroscope": Unexplained(1e-5)}
    given = GivenValues(unexplained=left)
    told = {"solution": report(fits), "quality": quality, "budget": budget(fits, given)}
    assert_held("solving", name, told, (*ROUNDED, *rounded))


def test_twelve_positions_and_turns_on_a_certified_cube_at_two_sites() -> None:
    truth = simulated_unit(2, temperature_rise_k=3.0)
    first = simulate_campaign(truth, 2, dwell_s=20.0, certificate_sigma=5e-6, turns=TURNS, repeats=1)
    away = replace(truth, latitude_deg=48.0, gravity_m_s2=9.8081)
    second = simulate_campaign(away, 3, dwell_s=20.0, turns=TURNS, positions=range(1, 12))
    same = [replace(each, fixture=replace(each.fixture, id="CUBE")) for each in (first, second)]
    assert_solution_held("two sites", same)


def test_positions_on_six_faces_and_rests_between_them() -> None:
    free = [rotation(each) for each in np.random.default_rng(4).standard_normal((9, 3))]
    truth, faces = simulated_unit(5, imu_axes=("-y", "+x", "+z")), (1, 3, 5, 7, 9, 11)
    campaign = simulate_campaign(truth, 5, dwell_s=20.0, positions=faces, turns=TURNS[:3], free=free)
    assert_solution_held("six faces", [campaign])
    on_faces = tuple(
        RestRecord(each.name, face, each.series)
        for each, face in zip(campaign.dwells, ("x_up", "x_down", "y_up", "y_down", "z_up", "z_down"), strict=True)
    )
    without = replace(campaign, dwells=(), rests=(*on_faces, *campaign.rests))
    # a slab that none of these sees is at nought but for rounding
    assert_solution_held("faces without heading", [without], ("slab_tilt.value", "parallelism.value.0"))


def test_moves_between_rests_of_a_mems_unit() -> None:
    rng = np.random.default_rng(6)
    accel, gyro = unit(rng, 400.0, 1e-2, lower=True), unit(rng, 80.0, 0.1)
    record = sequence(rng, accel, gyro, rests=14, accel_noise=1e-3, gyro_noise=0.1)
    site = Site(LATITUDE, STANDARD_GRAVITY, 1e-9)
    assert_solution_held("moves", [Campaign("M", "S", False, site, (), (), sequences=(record,))], OF_MOVES)
