"""A cube that IMUs measured, as the prior of the next solve."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.bench.cube_measurement import measure_cube
from procedures.calibration.joint_calibration import fit, report
from procedures.campaign.campaign import Campaign, Fixture, MeasuredCube
from procedures.campaign.measured_cube import NAMES, from_tilts
from procedures.campaign.observations import dwell_rates
from procedures.free_positions.free_attitude_fit import solve_with_rests
from procedures.twelve_positions.accelerometer_fit import TriadFit
from procedures.twelve_positions.bench_parameters import mean_axes
from tests.procedures.measured_units import calibrated, campaigns, some_unit, values

ALL = ("as drawn", "about z", "about x")


def measured_before(rng: np.random.Generator, faces: FloatArray, mountings: tuple[str, ...] = ALL) -> MeasuredCube:
    """What another unit, which has K2, found of the cube."""
    return measure_cube(campaigns(rng, faces, 1, mountings)).cube


def with_prior(campaign: Campaign, measured: MeasuredCube | None) -> Campaign:
    return replace(campaign, fixture=Fixture({}, campaign.fixture.C_sb, "A", measured))


def tilts_in_sigma(joint: TriadFit, faces: FloatArray, names: tuple[str, ...]) -> FloatArray:
    rows = from_tilts()[[NAMES.index(name) for name in names]]
    at = 12 + joint.bench.cube_slice(0).start
    value, covariance = rows @ joint.fit.x[at : at + 12], joint.fit.covariance[at : at + 12, at : at + 12]
    error = value - np.array([values(faces)[name] for name in names])
    z: FloatArray = error / np.sqrt(np.diag(rows @ covariance @ rows.T))
    return z


def perpendicularity(faces: FloatArray) -> FloatArray:
    up, down = faces[0::2], faces[1::2]
    q: FloatArray = (up - down) / 2
    return q


@pytest.mark.parametrize("mountings", [("as drawn",), ALL])
def test_a_solve_with_a_measured_cube_has_honest_sigmas(mountings: tuple[str, ...]) -> None:
    tilts, own, misaligned = list[FloatArray](), list[FloatArray](), list[FloatArray]()
    for seed in range(8):
        rng = np.random.default_rng([seed, 1])
        faces = 3e-5 * rng.standard_normal((6, 2))
        measured = measured_before(rng, faces, mountings)
        it = some_unit(rng, 0.0)  # a solve knows of no K2
        plain = calibrated(rng, it, faces)
        fits = fit([with_prior(plain, measured)])
        assert fits.accelerometer is not None
        tilts.append(tilts_in_sigma(fits.accelerometer, faces, measured.names))
        solved = report(fits)
        assert solved.accelerometer is not None
        assert solved.quality.p_value > 1e-4
        if mountings == ALL:
            E = solved.accelerometer.misalignment
            true = it.k[:, None] * it.E @ mean_axes(perpendicularity(faces))
            misaligned.append(angles(E.value) - angles(true / np.linalg.norm(true, axis=1)[:, None]))
            own.append(misaligned[-1] / angle_sigma(E.std))
    for z in (np.concatenate(tilts), *([np.concatenate(own)] if own else [])):
        assert np.mean(np.abs(z) < 1.959964) > 0.95 - 4 * np.sqrt(0.05 * 0.95 / z.size)
        assert np.mean(z**2) < 1 + 4 * np.sqrt(2 / z.size) * 1.5  # values of one seed are correlated


def angles(E: FloatArray) -> FloatArray:
    """Cosines between the input axes (3,): they need no frame, so that how the IMU sat does not matter."""
    G = E @ E.T
    return np.array([G[0, 1], G[0, 2], G[1, 2]])


def angle_sigma(std: FloatArray) -> FloatArray:
    """Their 1 sigma from that of E, the elements taken as independent: no less than half of it, and near."""
    return np.array(
        [np.hypot(std[0, 1], std[1, 0]), np.hypot(std[0, 2], std[2, 0]), np.hypot(std[1, 2], std[2, 1])]
    )


def test_a_cube_measured_with_the_imu_turned_determines_k2_of_the_next_unit_from_parallelism() -> None:
    z = list[FloatArray]()
    for seed in range(8):
        rng = np.random.default_rng([seed, 2])
        faces = 3e-5 * rng.standard_normal((6, 2))
        it = some_unit(rng)
        campaign = with_prior(calibrated(rng, it, faces), measured_before(rng, faces))
        joint = solve_with_rests([campaign], dwell_rates([campaign], "accelerometer"), None, quadratic=True)
        assert joint is not None
        assert joint.K2 is not None
        std = np.sqrt(np.diag(joint.fit.covariance)[-3:])
        assert np.all(std < 1e-6)
        z.append((joint.K2 - it.K2) / std)
    assert np.mean(np.square(z)) == pytest.approx(1.0, abs=4 * np.sqrt(2 / np.size(z)))
