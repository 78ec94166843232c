from dataclasses import replace

import numpy as np
import pytest

from procedures.calibration.triad_calibration import triad_vector
from procedures.planning.campaign_design import CampaignDesign, HandTimes, usual_design
from procedures.planning.design_sigmas import OF_TRIAD
from procedures.planning.identifiability import IdentifiableEffect, identifiable_effects
from procedures.positions import POSITIONS
from procedures.twelve_positions.accelerometer_fit import solve_accelerometer
from procedures.twelve_positions.gyroscope_fit import solve_gyroscope
from tests.procedures.planning.bench_of_moves import ARCSEC, HALVES, OFF_DIAGONAL, D, E, K, bench, order, rms, unit
from tests.procedures.twelve_positions.carried_cube import campaign


def of_gyroscopes(found: np.ndarray) -> tuple[float, float, float]:
    """Return rms of k [ppm], E [arcsec], D [deg/h]."""
    own = found[OF_TRIAD:]
    return rms(own[K]) * 1e6, rms(own[E]) / ARCSEC, rms(own[D])


def uncarried(design: CampaignDesign) -> CampaignDesign:
    """Return the design with no move recorded."""
    return CampaignDesign(tuple(replace(at, is_carried=False) for at in design.placements))


@pytest.mark.parametrize(
    ("design", "minutes", "k", "D_dph"),
    [
        (usual_design(), 35.1, 2.95, 0.0114),
        (order(list(POSITIONS)), 29.0, 4.9, 0.0117),
        (order(HALVES), 29.0, 2.3, 0.0117),
    ],
)
def test_the_bounds_of_known_campaigns_are_reproduced(design, minutes, k, D_dph) -> None:
    found = bench(unit()).of(design)
    ppm, _, bias = of_gyroscopes(found)
    assert design.minutes(HandTimes()) == pytest.approx(minutes, abs=0.05)
    assert ppm == pytest.approx(k, rel=0.05)
    assert bias == pytest.approx(D_dph, rel=0.03)
    assert rms(found[D]) == pytest.approx(0.71e-7 * 1.03, rel=0.04)  # the bound, and what counting adds


@pytest.mark.parametrize(("letters", "seed"), [(HALVES, 1), (list(POSITIONS), 3)])
def test_the_sigma_of_a_plan_is_that_which_the_solve_states(letters: list[str], seed: int) -> None:
    made = campaign(seed, tuple(letters))
    accelerometer = solve_accelerometer([made.campaign], made.accelerometer)
    fit = solve_gyroscope([made.campaign], made.gyroscope, [], accelerometer)
    assert fit is not None
    assert accelerometer is not None
    stated = []
    for joint, triad in ((accelerometer, "accelerometer"), (fit.joint, "gyroscope")):
        vector = triad_vector(joint, triad, accelerometer)
        sigma = np.sqrt(np.diag(vector.covariance))
        sigma[:3] /= vector.value[:3]
        stated.append(sigma[[0, 1, 2, *OFF_DIAGONAL, 12, 13, 14]])
    # as the campaign showed it: the draw of one is wide
    instability = float(np.mean(fit.joint.excess / fit.joint.k))
    noise = replace(unit(1e-6 / 1.03, instability), gyro_white=np.full(3, 1e-4 / 1.03))
    planned = bench(noise).of(order(letters)).reshape(2, OF_TRIAD)[:, [0, 1, 2, *OFF_DIAGONAL, 12, 13, 14]]
    assert stated[1] == pytest.approx(planned[1], rel=0.06)
    assert stated[0] == pytest.approx(planned[0], rel=0.12)  # a heading times the slab's tilt is not in the plan


def test_what_a_design_leaves_open_has_no_sigma() -> None:
    found = bench(unit()).of(order(["ENU"]))
    assert not np.isfinite(found[:2]).any()
    assert not np.isfinite(found[OF_TRIAD:][K]).any()


def test_turns_and_longer_dwells_make_no_sigma_larger() -> None:
    engine = bench(unit())
    short, long = engine.of(order(HALVES, 50.0)), engine.of(order(HALVES, 100.0))
    with_turns = engine.of(
        replace(usual_design(), placements=(*order(HALVES).placements, *usual_design().placements[12:]))
    )
    assert np.all(long <= short * (1 + 1e-9))
    assert np.all(with_turns <= long * (1 + 1e-6))


def reported(design) -> dict[str, IdentifiableEffect]:
    return {one.name: one for one in identifiable_effects(bench(unit()), design)}


def test_twelve_placements_and_turns_determine_what_is_known_that_they_do() -> None:
    """K2 is one with the parallelism of an uncertified cube, K3 with the scale factor (effects.md)."""
    usual = reported(uncarried(usual_design()))
    assert not usual["accelerometer.quadratic"].is_identified
    assert not usual["accelerometer.cubic"].is_identified
    assert usual["accelerometer.bias_drift"].is_identified
    assert usual["gyroscope.g_sensitivity"] == IdentifiableEffect("gyroscope.g_sensitivity", True)
    assert usual["gyroscope.scale_asymmetry"].is_identified
    assert "gyroscope.bias_temperature" not in usual  # nobody plans temperatures


def test_turns_one_way_alone_do_not_determine_an_asymmetry_and_no_turn_determines_nothing_of_scale() -> None:
    usual = uncarried(usual_design())
    one_way = replace(
        usual, placements=tuple(at for at in usual.placements if at.turn is None or at.turn % 2 == 0)
    )
    assert not reported(one_way)["gyroscope.scale_asymmetry"].is_identified
    assert not reported(uncarried(order(list(POSITIONS))))["gyroscope.scale_asymmetry"].is_identified


def test_moves_determine_an_asymmetry_and_the_second_order_that_placements_alone_do_not() -> None:
    halves = reported(order(HALVES))
    assert halves["gyroscope.scale_asymmetry"].is_identified
    quadratic = halves["accelerometer.quadratic"]
    assert quadratic.is_identified
    assert quadratic.not_apart == ("accelerometer.scale_asymmetry",)
