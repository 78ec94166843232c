"""A cube that leans as it is turned by hand: seen at rest before and after, and in the sigma of the gyroscopes."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits, fit, report
from procedures.campaign.campaign import Campaign, DwellRecord, TurnRecord
from procedures.counts.sample_records import CountSeries, block_series
from procedures.twelve_positions.rotation_tilt import RotationTilt
from procedures.uncertainty import sources
from procedures.uncertainty.row_variance import gyroscope_shares
from procedures.units import RAD_PER_ARCSEC

DEBRIS = np.radians([0.08, -0.09, 0.0])  # rad, rotation of the cube about its x and y: 433 arcsec
TILT = [
    -DEBRIS[1],
    DEBRIS[0],
]  # of the up vector along x and y: what is up turns the other way, as the cube sees it


def truth(seed: int = 7) -> Truth:
    return replace(Truth.example(seed), accel_k=np.full(3, 2e4), accel_turn_on_g=0.0, gyro_turn_on_dph=0.0)


def turned(imu: SimulatedImu, direction: str, off: FloatArray | None) -> CountSeries:
    """Place, turn once and read the rests with it."""
    imu.place(9, 5.0, off)
    imu.read(round(9 / imu.truth.sample_period_s))  # set down, and settled
    imu.turn("z", direction, 1)
    return block_series(
        [imu.read(round((imu.done - imu.time) / imu.truth.sample_period_s))], imu.truth.sample_period_s
    )


def with_turns_of_z(made: Campaign, imu: SimulatedImu, off: FloatArray | None, turn_on: int = 1) -> Campaign:
    """The campaign with other turns about z."""
    others = tuple(turn for turn in made.turns if turn.axis != "z")
    new = [TurnRecord(f"turn_z_{d}", "z", d, 1, 9, turned(imu, d, off), turn_on) for d in "+-"]
    return replace(made, turns=(*others, *new))


def errors(of: CampaignFits, true: Truth) -> FloatArray:
    """The gyroscopes' k and E against the truth, in sigmas."""
    found = report(of).gyroscope
    assert found is not None
    E = (found.misalignment.value - true.gyro_e)[~np.eye(3, dtype=bool)]
    k = (found.scale_factor.value - true.gyro_k) / found.scale_factor.std
    off: FloatArray = np.concatenate((k, E / found.misalignment.std[~np.eye(3, dtype=bool)]))
    return off


def tilts(of: CampaignFits) -> dict[str, RotationTilt]:
    assert of.gyroscope is not None
    named = zip(of.gyroscope.turns, of.gyroscope.tilts, strict=True)
    return {turn.record.name: tilt for turn, tilt in named if tilt is not None}


def test_debris_under_turns_is_measured_and_reported_and_in_the_sigma() -> None:
    true = truth()
    clean = simulate_campaign(true, 7, dwell_s=20.0, certificate_sigma=5e-6)
    fits = fit([with_turns_of_z(clean, SimulatedImu(true, 8), DEBRIS)])
    for name in ("turn_z_+", "turn_z_-"):
        tilt = tilts(fits)[name]
        assert tilt.is_off
        assert np.all(np.abs(tilt.mean - TILT) < 4 * tilt.std)
        assert np.all(tilt.std < 20 * RAD_PER_ARCSEC)
    assert np.abs(errors(fits, true)).max() < 4
    reported = [each for each in report(fits).warnings if "tilted by 4" in each]
    assert [each.split(":")[0] for each in reported] == ["turn_z_+", "turn_z_-"]
    assert fits.gyroscope is not None
    shares = gyroscope_shares(fits.gyroscope, tilts=True)
    assert any(cell.source == sources.SEAT for cell in shares)


def test_the_bias_step_of_another_turn_on_is_no_debris_and_hides_none() -> None:
    true = truth()
    clean = simulate_campaign(true, 7, dwell_s=20.0, certificate_sigma=5e-6)
    again = replace(true, accel_d_g=true.accel_d_g + np.array([2e-3, -1e-3, 1e-3]))  # 1 mg looks like 206 arcsec
    for off in (None, DEBRIS):
        imu = SimulatedImu(again, 8)
        imu.read(round(8 / true.sample_period_s))
        rest = DwellRecord("dwell_01_2", 1, block_series([imu.read(400)], true.sample_period_s), 2)
        made = with_turns_of_z(clean, imu, off, turn_on=2)
        fits = fit([replace(made, dwells=(*made.dwells, rest))])
        assert [tilts(fits)[name].is_off for name in ("turn_z_+", "turn_z_-")] == [off is not None] * 2
        assert np.abs(errors(fits, true)).max() < 4
