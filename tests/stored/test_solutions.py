"""Whole solutions with their budgets: twelve positions at two sites, rests on six faces, moves between rests."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.calibration.joint_calibration import fit, report
from procedures.calibration.residuals import fit_quality
from procedures.campaign.campaign import Campaign, RestRecord, Site
from procedures.campaign.plan_steps import turn_steps
from procedures.frames import rotation
from procedures.uncertainty.budget import budget
from procedures.uncertainty.sources import GivenValues, Unexplained
from procedures.units import STANDARD_GRAVITY
from tests.procedures.free_units import LATITUDE, sequence
from tests.procedures.free_units import unit as free_unit
from tests.stored.conftest import StoredResult
from tests.stored.small_campaigns import stated, unit

TURNS = turn_steps(2, 3.0)
ROUNDED = ("dof",)  # other kernels of OpenBLAS round them otherwise


def whole(campaigns: list[Campaign]) -> dict[str, object]:
    """Return the solution, how well it fits and where its uncertainty comes from."""
    fits = fit(campaigns)
    joint = fits.accelerometer
    left = {"accelerometer": Unexplained(1e-6), "gyroscope": Unexplained(1e-5)}
    return {
        "solution": report(fits), "quality": None if joint is None else fit_quality(joint, None),
        "budget": stated(budget(fits, GivenValues(unexplained=left))),
    }  # fmt: skip


def test_twelve_positions_and_turns_on_a_certified_cube_at_two_sites(stored_result: StoredResult) -> None:
    truth = unit(2, temperature_rise_k=3.0)
    first = simulate_campaign(truth, 2, dwell_s=20.0, certificate_sigma=5e-6, turns=TURNS, repeats=1)
    away = replace(truth, latitude_deg=48.0, gravity_m_s2=9.8081)
    second = simulate_campaign(away, 3, dwell_s=20.0, turns=TURNS, positions=range(1, 12))
    same = [replace(each, fixture=replace(each.fixture, id="CUBE")) for each in (first, second)]
    stored_result.check(whole(same), without=[*ROUNDED, "slab_tilt", "parallelism"])


def test_positions_on_six_faces_and_rests_between_them(stored_result: StoredResult) -> None:
    free = [rotation(each) for each in np.random.default_rng(4).standard_normal((9, 3))]
    truth, faces = unit(5, imu_axes=("-y", "+x", "+z")), (1, 3, 5, 7, 9, 11)
    campaign = simulate_campaign(truth, 5, dwell_s=20.0, positions=faces, turns=TURNS[:3], free=free)
    names = ("x_up", "x_down", "y_up", "y_down", "z_up", "z_down")
    on_faces = tuple(
        RestRecord(each.name, face, each.series) for each, face in zip(campaign.dwells, names, strict=True)
    )
    without = replace(campaign, dwells=(), rests=(*on_faces, *campaign.rests))
    both = {"with heading": whole([campaign]), "without": whole([without])}
    stored_result.check(both, without=[*ROUNDED, "slab_tilt", "parallelism"])


def test_moves_between_rests_of_a_mems_unit(stored_result: StoredResult) -> None:
    rng = np.random.default_rng(6)
    accel, gyro = free_unit(rng, 400.0, 1e-2, lower=True), free_unit(rng, 80.0, 0.1)
    record = sequence(rng, accel, gyro, rests=14, accel_noise=1e-3, gyro_noise=0.1)
    site = Site(LATITUDE, STANDARD_GRAVITY, 1e-9)
    campaign = Campaign("M", "S", False, site, (), (), sequences=(record,))
    stored_result.check(whole([campaign]), without=[*ROUNDED, "contributions"])
