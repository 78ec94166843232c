from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.bench.cube_drift import drift
from procedures.bench.cube_measurement import K2_STD_G_PER_G2, measure_cube
from procedures.campaign.campaign import MeasuredCube
from procedures.campaign.measured_cube import PARALLELISM, CubeMeasurement, UnitShare, common_and_difference
from procedures.errors import ErrorCode, NotObservable
from tests.procedures.measured_units import calibrated, campaigns, some_unit, values
from tests.refusals import refused

ALL = ("as drawn", "about z", "about x")


def cube(seed: int) -> tuple[np.random.Generator, FloatArray]:
    rng = np.random.default_rng(seed)
    return rng, 3e-5 * rng.standard_normal((6, 2))


def in_sigma(found: CubeMeasurement, faces: FloatArray) -> FloatArray:
    true = values(faces)
    error = found.cube.value - np.array([true[name] for name in found.cube.names])
    whitened: FloatArray = np.linalg.solve(np.linalg.cholesky(found.cube.covariance), error)
    plain = error / np.sqrt(np.diag(found.cube.covariance))
    return np.stack((plain, whitened))


def spread(found: CubeMeasurement, kind: str) -> FloatArray:
    """1 sigma of the means or the differences."""
    names, H = common_and_difference(found.cube.names)
    rows = H[[kind in name for name in names]]
    sigma: FloatArray = np.sqrt(np.diag(rows @ found.cube.covariance @ rows.T))
    return sigma


@pytest.mark.proof
@pytest.mark.parametrize(
    ("units", "mountings", "free", "seeds"),
    [
        (1, ("as drawn",), 0, 16),
        (1, ALL[:2], 0, 6),
        (1, ALL, 0, 4),
        (3, ("as drawn",), 0, 4),
        (1, ("as drawn",), 14, 6),
    ],
)
def test_intervals_cover_whatever_the_campaigns_show(
    units: int, mountings: tuple[str, ...], free: int, seeds: int
) -> None:
    z = []
    for seed in range(seeds):
        rng, faces = cube(seed)
        z.append(in_sigma(measure_cube(campaigns(rng, faces, units, mountings, free)), faces))
    plain, whitened = np.concatenate(z, axis=1)
    sure = 4 * np.sqrt(0.05 * 0.95 / len(whitened))
    assert abs(np.mean(np.abs(whitened) < 1.959964) - 0.95) < sure
    assert np.mean(whitened**2) == pytest.approx(1.0, abs=4 * np.sqrt(2 / len(whitened)))
    assert np.mean(np.abs(plain) < 1.959964) > 0.95 - 2 * sure


def test_twelve_positions_know_the_differences_and_leave_the_means_to_the_range_of_k2() -> None:
    rng, faces = cube(1)
    found = measure_cube(campaigns(rng, faces))
    assert found.cube.names == PARALLELISM
    assert spread(found, "mean") == pytest.approx(2 * K2_STD_G_PER_G2, rel=0.02)
    assert np.all(spread(found, "less") < 0.02 * K2_STD_G_PER_G2)
    assert found.shares[0].quadratic_left == pytest.approx(K2_STD_G_PER_G2, rel=0.02)


def test_turned_about_z_the_imu_determines_x_and_y_and_not_z() -> None:
    rng, faces = cube(2)
    found = measure_cube(campaigns(rng, faces, 1, ALL[:2]))
    names, _ = common_and_difference(found.cube.names)
    means = dict(zip([n[-1] for n in names if "mean" in n], spread(found, "mean"), strict=True))
    assert means["x"] < 1e-6
    assert means["y"] < 1e-6
    assert means["z"] == pytest.approx(2 * K2_STD_G_PER_G2, rel=0.02)
    assert [name for name in found.cube.names if "skew" in name] == ["skew.x.y", "skew.x.z", "skew.y.z"]


def test_rests_in_free_attitudes_determine_all_without_a_second_mounting() -> None:
    rng, faces = cube(3)
    found = measure_cube(campaigns(rng, faces, free=14))
    assert len(found.cube.names) == 9
    assert np.all(np.sqrt(np.diag(found.cube.covariance)) < 2e-6)


def test_units_that_disagree_are_reported() -> None:
    rng, faces = cube(6)
    other = faces.copy()
    other[0, 0] += 2e-5
    agree = measure_cube(campaigns(rng, faces, 2))
    assert agree.dof > 0
    assert agree.p_value > 1e-3
    two = [calibrated(rng, some_unit(rng), f, serial=s) for f, s in ((faces, "S1"), (other, "S2"))]
    found = measure_cube(two)
    assert found.p_value < 1e-6
    assert any("disagree" in warning for warning in found.warnings)


def test_a_seating_that_is_off_makes_the_sigmas_larger_and_is_reported() -> None:
    rng, faces = cube(7)
    seen = campaigns(rng, faces)
    quiet = measure_cube(seen)
    third = seen[0].dwells[2].series
    assert third.accel is not None
    np.asarray(third.accel)[:, 1] += 5e-3  # 5 urad
    found = measure_cube(seen)
    assert any("residuals exceed" in warning for warning in found.warnings)
    assert np.all(spread(found, "less") > 1.5 * spread(quiet, "less"))


def test_too_few_positions_are_refused() -> None:
    rng, faces = cube(8)
    (whole,) = campaigns(rng, faces)
    with refused(NotObservable, ErrorCode.NOT_OBSERVABLE):
        measure_cube([replace(whole, dwells=whole.dwells[:2])])
    with refused(NotObservable, ErrorCode.NOT_OBSERVABLE):
        measure_cube([replace(whole, dwells=())])


BY_K2 = np.array([[0, -2.0, 0], [0, 0, -2], [-2, 0, 0], [0, 0, -2], [-2, 0, 0], [0, -2, 0]])
NOISE, RANGE = 1e-7, 5e-5
MONTHS = [0.0, 3.0, 6.0, 9.0]


def months_of_one_unit(
    rng: np.random.Generator, per_month: float = 0.0, unit: str | None = "S"
) -> list[CubeMeasurement]:
    """A cube whose parallelism x.y moves by ``per_month``; another unit each time where ``unit`` is None."""
    found, K2 = list[CubeMeasurement](), RANGE * rng.standard_normal(3)
    for i, month in enumerate(MONTHS):
        if unit is None:
            K2 = RANGE * rng.standard_normal(3)
        value = BY_K2 @ K2 + NOISE * rng.standard_normal(6)
        value[0] += per_month * month
        covariance = NOISE**2 * np.eye(6) + RANGE**2 * BY_K2 @ BY_K2.T
        name = unit or f"S{i}"
        share = UnitShare(name, BY_K2, RANGE, np.full(3, RANGE))
        found.append(
            CubeMeasurement(MeasuredCube(PARALLELISM, value, covariance, (name,)), NOISE**2 * np.eye(6), (share,))
        )
    return found


def trends(seeds: int, per_month: float, unit: str | None) -> FloatArray:
    """(seeds, q): how far each trend is from the true one, in its sigma."""
    z = []
    for seed in range(seeds):
        moved = drift(months_of_one_unit(np.random.default_rng(seed), per_month, unit), MONTHS)
        assert moved is not None
        true = [
            per_month * ((name.startswith("parallelism.x.y")) + 0.5 * ("mean of parallelism.x.y" in name))
            for name in moved.names
        ]
        z.append((moved.trend - true) / moved.trend_std)
    return np.array(z)


@pytest.mark.parametrize("unit", ["S", None])
@pytest.mark.parametrize("per_month", [0.0, 1e-6])
def test_a_trend_is_found_within_its_sigma(unit: str | None, per_month: float) -> None:
    z = trends(100, per_month, unit)
    assert np.mean(z**2) == pytest.approx(1.0, abs=4 * np.sqrt(2 / z.size))


def test_a_cube_that_stays_is_reported_as_changed_once_in_a_hundred() -> None:
    changed = 0
    for seed in range(200):
        moved = drift(months_of_one_unit(np.random.default_rng(seed)), MONTHS)
        assert moved is not None
        changed += bool(moved.changed)
    assert changed <= 2 + 4 * np.sqrt(2)


def test_between_measurements_of_one_unit_k2_cancels() -> None:
    rng = np.random.default_rng(1)
    same, other = (drift(months_of_one_unit(rng, 5e-7, unit), MONTHS) for unit in ("S", None))
    assert same is not None
    assert other is not None
    assert set(same.changed) == {
        "parallelism.x.y less parallelism.z.y",
        "mean of parallelism.x.y and parallelism.z.y",
    }
    assert set(other.changed) == {"parallelism.x.y less parallelism.z.y"}
    assert max(same.shift_std) < 3 * NOISE
    assert max(other.shift_std) > 1e-4
