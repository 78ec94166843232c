"""Rate tables of few points, and of analogue outputs with an offset: scale factor, asymmetry, cubic and offset."""

import numpy as np
import pytest

from procedures.campaign.campaign import Campaign, RateTable, Site
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.rate_points import LEAST_POINTS
from procedures.diagnosis.result import Diagnosis
from procedures.error_codes import ErrorCode
from procedures.errors import NotObservable
from tests.refusals import refused

K, OFFSET, CUBIC = 12.4, 2500.0, 1.6e-7  # mV/(deg/s), mV, 1/(deg/s)^2
ASYMMETRY = 900e-6  # (k+ - k-) / k
UP = np.linspace(-100.0, 100.0, 11)
STAYS = [0, 20, 50, 80, 100, 80, 50, 20, 0, -20, -50, -80, -100, -80, -50, -20, 0]
ORDERS = {
    "up and down": np.concatenate((UP, UP[::-1])),
    "twice": np.tile(UP, 2),
    "each rate once": np.linspace(-100, 100, 22),
    "both ways": np.ravel(np.column_stack((np.linspace(5, 100, 11), -np.linspace(5, 100, 11)))),
}


def diagnosed(rate: np.ndarray, seed: int, *, size: float, noise: float, offset: float = OFFSET) -> Diagnosis:
    """Diagnose a table of an analogue gyroscope with ``size`` times the planted asymmetry and cubic."""
    rng = np.random.default_rng(seed)
    seen = rate + size * (ASYMMETRY / 2 * np.abs(rate) + CUBIC * rate**3) + noise * rng.standard_normal(len(rate))
    output = np.full((len(rate), 3), np.nan)
    output[:, 2] = offset + K * seen
    table = RateTable("table.csv", "z", rate, output, np.full(len(rate), np.nan), None)
    return diagnose([Campaign("M", "S", False, Site(0.8, 9.80665, 1e-3), (), (), rate_tables=(table,))])


def value(found: Diagnosis, effect: str) -> tuple[float, float]:
    (one,) = [each for each in found.findings if each.effect == effect]
    return float(np.atleast_1d(one.value)[0]), float(np.atleast_1d(one.std)[0])


@pytest.mark.parametrize(("order", "offset"), [(each, OFFSET) for each in ORDERS] + [("twice", -3.0)])
def test_22_points_that_are_well_measured_show_asymmetry_and_cubic(order: str, offset: float) -> None:
    found = diagnosed(ORDERS[order], 1, size=1.0, noise=0.002, offset=offset)
    asymmetry, asymmetry_std = value(found, "gyroscope.scale_asymmetry")
    cubic, cubic_std = value(found, "gyroscope.scale_nonlinearity")
    assert abs(asymmetry - 900) < 4 * asymmetry_std < 250  # ppm
    assert abs(cubic - 0.16) < 4 * cubic_std < 0.02  # ppm/(deg/s)^2
    (sensor,) = found.on_table
    assert abs(sensor.scale - K) < 5 * sensor.scale_std
    assert abs(sensor.offset - offset) < 5 * sensor.offset_std
    assert sensor.is_offset == (offset == OFFSET)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("seed", [1])
def test_22_points_of_a_linear_sensor_are_consistent(order: str, seed: int) -> None:
    found = diagnosed(ORDERS[order], seed, size=0.0, noise=0.002)
    assert found.verdict == "consistent"
    assert found.findings == ()


def test_stays_at_each_rate_show_asymmetry_and_cubic() -> None:
    rate = np.repeat(np.array(STAYS, dtype=float), 100)
    found = diagnosed(rate, 3, size=1.0, noise=0.01)
    asymmetry, asymmetry_std = value(found, "gyroscope.scale_asymmetry")
    assert abs(asymmetry - 900) < 4 * asymmetry_std < 250
    assert value(found, "gyroscope.scale_nonlinearity")[0] == pytest.approx(0.16, abs=0.01)


def test_of_too_few_points_nothing_is_said() -> None:
    with refused(NotObservable, ErrorCode.NOT_OBSERVABLE):
        diagnosed(np.linspace(-100, 100, LEAST_POINTS - 1), 1, size=0.0, noise=0.002)
