from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits, fit, report
from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign, Site
from procedures.frames import rotation
from procedures.free_positions.gyroscopes_from_moves import moves_and_rests
from procedures.twelve_positions.transfer_rotation import integrate_moves, move_rotations, padded_moves
from procedures.units import STANDARD_GRAVITY
from tests.procedures.free_units import LATITUDE, PERIOD, Unit, sequence, unit

Case = tuple[Campaign, Unit, Unit, CampaignFits]


def campaign_of(
    seed: int, *, rests: int = 20, accel_noise: float, gyro_noise: float, bias: float = 0.1
) -> tuple[Campaign, Unit, Unit]:
    rng = np.random.default_rng(seed)
    accel, gyro = unit(rng, 400.0, 1e-2, lower=True), unit(rng, 80.0, bias)
    record = sequence(rng, accel, gyro, rests=rests, accel_noise=accel_noise, gyro_noise=gyro_noise)
    site = Site(LATITUDE, STANDARD_GRAVITY, 1e-9)
    return Campaign("M", "S", False, site, (), (), sequences=(record,)), accel, gyro


def z_of(campaign: Campaign, accel: Unit, gyro: Unit) -> FloatArray:
    """Errors over sigma: k (3), E (9), D (3) of the gyroscopes."""
    return z_of_solution(report(fit([campaign])), gyro)


def z_of_solution(solution: Solution, gyro: Unit) -> FloatArray:
    found = solution.gyroscope
    assert found is not None
    bias = gyro.D * 3600
    return np.concatenate([
        (found.scale_factor.value - gyro.k) / found.scale_factor.std,
        ((found.misalignment.value - gyro.E) / found.misalignment.std).ravel(),
        (found.bias.value - bias) / found.bias.std,
    ])  # fmt: skip


@cache
def z_of_mems(seed: int) -> FloatArray:
    return z_of(*campaign_of(seed, accel_noise=1e-3, gyro_noise=0.1))


@pytest.mark.parametrize("seed", range(2))
def test_moves_give_the_gyroscopes_of_a_mems_unit_within_their_own_sigma(seed: int) -> None:
    assert np.max(np.abs(z_of_mems(seed))) < 4.5


@pytest.mark.parametrize("seed", range(2))
def test_moves_give_the_gyroscopes_of_a_fog_that_sees_the_earth_turn(seed: int) -> None:
    """The Earth's rate, left out, would put 15 deg/h into the bias: two hundred of its sigmas."""
    campaign, _, gyro = campaign_of(seed, accel_noise=1e-5, gyro_noise=1e-3, bias=1e-4)
    solution = report(fit([campaign]))
    assert np.max(np.abs(z_of_solution(solution, gyro))) < 4.5
    bias = solution.gyroscope
    assert bias is not None
    assert np.all(bias.bias.std < 0.5)  # deg/h


@pytest.mark.proof
def test_the_sigmas_are_honest_over_many_units() -> None:
    z = np.array([z_of_mems(seed) for seed in range(25)])
    k_and_D = z[:, [0, 1, 2, 12, 13, 14]]
    off_axis = z[:, [4, 5, 6, 8, 9, 10]]
    assert 0.7 < np.sqrt(np.mean(k_and_D**2)) < 1.3  # 150 numbers each
    assert 0.7 < np.sqrt(np.mean(off_axis**2)) < 1.3


def disturbed(seed: int, *, rest_g: float = 0.0, rest_deg_s: float = 0.0, move_rad: float = 0.0) -> Case:
    """A campaign with what is not noise: 1 sigma of each axis, drawn again at each rest of 4 s and move of 2 s.

    The gyroscopes' bias during a move is the mean of what it is at the rests next to it.
    """
    campaign, accel, gyro = campaign_of(seed, accel_noise=1e-4, gyro_noise=1e-2)
    (record,) = campaign.sequences
    assert record.series.accel is not None
    assert record.series.gyro is not None
    t = np.arange(len(record.series.gyro)) * PERIOD
    part, is_rest = (t / 6).astype(int), (t % 6 < 4 - PERIOD / 2)[:, None]
    a, w, turn = np.random.default_rng(seed).standard_normal((3, part[-1] + 2, 3))
    bias = rest_deg_s * np.where(is_rest, w[part], (w[part] + w[part + 1]) / 2)
    lost = np.degrees(move_rad) / 2 * ~is_rest * turn[part]
    series = replace(
        record.series,
        accel=record.series.accel + 400 * rest_g * is_rest * a[part],
        gyro=record.series.gyro + 80 * (bias + lost),
    )
    campaign = replace(campaign, sequences=(replace(record, series=series),))
    return campaign, accel, gyro, fit([campaign])


def rms_z(cases: list[Case]) -> float:
    changing = [0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14]  # the diagonal of E follows the rest of its row
    return float(
        np.sqrt(np.mean([z_of_solution(report(fits), gyro)[changing] ** 2 for _, _, gyro, fits in cases]))
    )


def test_a_seat_that_gives_tilts_the_directions_and_is_in_their_sigma() -> None:
    cases = [disturbed(seed, rest_g=1e-3) for seed in range(5)]
    for campaign, _, _, fits in cases:
        assert fits.accelerometer is not None
        seen = moves_and_rests([campaign], fits.segmented, fits.accelerometer)
        assert seen is not None
        assert np.mean(seen.up_std) == pytest.approx(1e-3, rel=0.3)  # rad: 1e-3 of 1 g; 20 rests
    assert 0.7 < rms_z(cases) < 1.35  # 60 numbers


def test_a_gyroscope_that_is_mounted_backwards_has_a_negative_row() -> None:
    campaign, _, gyro = campaign_of(3, accel_noise=1e-3, gyro_noise=0.1)
    (record,) = campaign.sequences
    assert record.series.gyro is not None
    record.series.gyro[:, 1] *= -1
    found = report(fit([campaign])).gyroscope
    assert found is not None
    assert found.misalignment.value[1] == pytest.approx(-gyro.E[1], abs=5e-3)


def test_too_few_moves_leave_the_gyroscopes_out_and_say_so() -> None:
    campaign, _, _ = campaign_of(4, rests=20, accel_noise=1e-3, gyro_noise=0.1)
    (record,) = campaign.sequences
    assert record.series.gyro is not None
    record.series.gyro[:] = record.series.gyro[0]
    solution = report(fit([campaign]))
    assert solution.accelerometer is not None
    assert solution.gyroscope is None
    assert "gyroscope.scale_factor" in solution.not_observable


def test_coning_within_a_sample_is_counted() -> None:
    """An axis that sweeps a cone at 2 Hz, sampled at 20 Hz: the mean rates alone drift (Savage, 1998)."""
    fine, coarse, amplitude = 20000, 20, 0.05
    t = (np.arange(fine) + 0.5) / fine
    w = np.degrees(amplitude * 4 * np.pi) * np.stack(
        (-np.sin(4 * np.pi * t), np.cos(4 * np.pi * t), 0 * t), axis=1
    )
    truth = move_rotations(padded_moves([w], [1 / fine]), np.eye(3), np.zeros(3))
    mean = padded_moves([w.reshape(coarse, -1, 3).mean(axis=1)], [1 / coarse])
    steps = rotation(-np.radians(mean.output[0]) / coarse)
    plain = np.linalg.multi_dot(list(steps[::-1]))
    for careful in (
        integrate_moves(mean, np.eye(3), np.zeros(3)).rotation,
        move_rotations(mean, np.eye(3), np.zeros(3)),
    ):
        assert np.abs(careful - truth).max() < 0.2 * np.abs(plain - truth).max()
