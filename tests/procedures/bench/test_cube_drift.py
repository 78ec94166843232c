import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.bench.cube_drift import drift
from procedures.campaign.campaign import MeasuredCube
from procedures.campaign.measured_cube import PARALLELISM, CubeMeasurement, UnitShare

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


def test_a_cube_that_stays_is_said_to_have_changed_once_in_a_hundred() -> None:
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
