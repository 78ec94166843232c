"""Where a tilted cube would not be noticed: what is reported is what a tilt does when the campaign is solved."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import chdtri

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import CampaignFits, fit, report, solve
from procedures.calibration.undetectable_tilt import (
    HARMFUL,
    UndetectableTilt,
    undetectable_tilts,
)
from procedures.campaign.campaign import Campaign
from procedures.twelve_positions.accelerometer_fit import TriadFit, solve_accelerometer, specific_force
from procedures.twelve_positions.placement_transfers import seating_rotations
from procedures.units import RAD_PER_ARCSEC

TRUTH = Truth.example(7)


def campaign_of(
    *positions: int, dwell_s: float = 100.0, seed: int = 3, manual_rotations: bool = False
) -> Campaign:
    turns = {} if manual_rotations else {"turns": ()}
    return simulate_campaign(TRUTH, seed, dwell_s=dwell_s, positions=positions, **turns)


def found_of(campaigns: Sequence[Campaign], tilted: Sequence[tuple[int, str]] = ()) -> dict[int, UndetectableTilt]:
    fits = fit(campaigns)
    assert fits.accelerometer is not None
    noticed = report(fits).quality.noticed_sigmas
    tilts = undetectable_tilts(fits.accelerometer, fits.gyroscope, noticed, tilted)
    return {each.position: each for each in tilts if each.harmed or each.is_of_moves}


def test_both_positions_of_every_face_leave_nothing_unnoticed() -> None:
    assert not found_of([campaign_of(*range(1, 13))])
    assert not found_of([simulate_campaign(TRUTH, 3, dwell_s=100.0, moves=True)])


def test_of_each_dwell_it_is_reported_what_shows_and_what_a_smaller_tilt_moves() -> None:
    """Of twelve positions of 100 s 6 arcsec show, and move a value by no more than by what they show."""
    solution = solve([campaign_of(*range(1, 13))])
    noticed = solution.quality.noticed_sigmas
    assert [each.position for each in solution.undetectable_tilts] == list(range(1, 13))
    for each in solution.undetectable_tilts:
        assert each.tilt / RAD_PER_ARCSEC == pytest.approx(6, abs=1)
        assert 0.3 * noticed < each.sigmas < HARMFUL * noticed
        assert each.value.split()[0] == "accelerometer"


def test_a_face_that_stood_once_is_named_with_what_depends_on_it() -> None:
    found = found_of([campaign_of(1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12)])
    assert list(found) == [3]
    assert set(found[3].harmed) == {"misalignment yx", "misalignment zx"}
    assert found[3].largest > 100 * RAD_PER_ARCSEC


def tilt_of(fits: CampaignFits, i: int, tilt: np.ndarray) -> TriadFit:
    """Return the fit of the same rates with the cube of dwell ``i`` leaning by (2,) [rad] more."""
    fitted = fits.accelerometer
    assert fitted is not None
    force = specific_force(fitted.bench, fitted.fit.x[12 : 12 + fitted.bench.size])[i]
    axis = fitted.bench.C_sb[i] @ (seating_rotations([fitted.bench.placements[i].position])[0] @ tilt)
    rate = fitted.seen.rate.copy()
    rate[i] += fitted.K @ np.cross(axis, force)
    again = solve_accelerometer(fits.campaigns, replace(fitted.seen, rate=rate))
    assert again is not None
    return again


@pytest.mark.parametrize("position", [3, 7])
def test_a_tilt_of_the_size_that_is_stated_shows_by_so_much_and_makes_a_value_so_wrong(position: int) -> None:
    """Solved with the tilt in the direction that hides most, chi2 rises to its limit, and a value moves so far."""
    campaign = campaign_of(1, 2, 3, 5, 6, 7, 9, 10, 11, 12)
    exact = replace(campaign, sigma=replace(campaign.sigma, seat=1e-12))  # the fit's sigmas are without the seats
    fits = fit([exact])
    plain, reported = fits.accelerometer, found_of([exact])[position]
    assert plain is not None
    i = [dwell.position for _, dwell in plain.seen.dwells].index(position)
    std = np.sqrt(np.diag(plain.fit.covariance))[:9]
    small = 1e-2 * reported.largest
    tilts = [(np.cos(a), np.sin(a)) for a in np.radians(np.arange(0, 180, 15))]
    rises, moves = list[float](), list[float]()
    for tilt in tilts:
        both = [tilt_of(fits, i, way * small * np.array(tilt)) for way in (1, -1)]
        rises.append((sum(one.fit.chi2 for one in both) / 2 - plain.fit.chi2) / small**2)
        moves.append(float(np.max(np.abs(both[0].fit.x[:9] - both[1].fit.x[:9]) / std)) / (2 * small))
    quality = report(fits).quality
    limit = chdtri(quality.dof, 0.01) - quality.dof  # above what is expected of chi2
    hidden = np.sqrt(limit / rises)  # rad, in each direction
    assert max(hidden) == pytest.approx(reported.largest, rel=0.1)
    assert max(hidden * moves) > HARMFUL * np.sqrt(limit)
    assert max(np.minimum(hidden, 1e-3) * moves) == pytest.approx(reported.sigmas, rel=0.1)
