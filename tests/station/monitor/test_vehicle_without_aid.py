"""A live unit without aid in a vehicle: told by how it moves, with a true sigma from then on; a hand is none."""

from functools import partial

import numpy as np
import pytest

from procedures.attitude.attitude_log import AttitudeLog, down_of, inclination
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.units import STANDARD_GRAVITY
from station.attitude.live_kalman_filter import AttitudeEstimator
from station.calibrated.filter_settings import filter_settings, in_a_vehicle
from station.calibrated.rates_and_forces import RatesAndForces
from tests.drivers.simulated.vehicles import MEMS, vehicle_log
from tests.procedures.attitude.test_unaided_motion import in_a_hand


def settings(log: AttitudeLog, knows_heading: bool) -> KalmanSettings:
    return filter_settings(None, "none", log, STANDARD_GRAVITY, None, knows_heading)


def followed(log: AttitudeLog, watched: bool = True) -> tuple[AttitudeEstimator, np.ndarray]:
    """Return the estimator, and for each tick error [deg], sigma [deg] and whether it is taken for a vehicle."""
    estimator = AttitudeEstimator(
        "none", settings, in_vehicle=partial(in_a_vehicle, calibration=None) if watched else None
    )
    n, rows = max(1, round(0.1 / log.nominal)), list[tuple[float, float, bool]]()
    truth = log.true_down  # of all samples: once, not for every tick
    assert truth is not None
    for first in range(0, len(log.t) - n + 1, n):
        part = slice(first, first + n)
        read = estimator.take(log.t[part], RatesAndForces(log.omega_b[part], log.f_b[part]))
        if read is not None:
            down = down_of(np.radians([read.roll]), np.radians([read.pitch]))
            off = float(np.degrees(inclination(down, truth[first + n - 1 : first + n])[0]))
            rows.append((off, read.sigma, estimator.is_vehicle))
    return estimator, np.array(rows)


def ratio(rows: np.ndarray) -> float:
    """Return the rms of error over sigma."""
    return float(np.sqrt(np.mean((rows[:, 0] / rows[:, 1]) ** 2)))


@pytest.mark.parametrize("kind", ["motorway_car"])
def test_from_when_it_is_reported_sigma_is_what_the_error_is(kind: str) -> None:
    log = vehicle_log(kind, 31, MEMS, 200.0)
    found, rows = followed(log)
    assert found.is_vehicle
    noticed = rows[:, 2] > 0
    assert noticed[len(noticed) // 3 :].all()
    now, before = (ratio(each[noticed]) for each in (rows, followed(log, watched=False)[1]))
    assert 0.3 < now < 2.6
    assert before > 2 * now


def test_a_hand_is_no_vehicle_and_reads_as_it_did() -> None:
    log = in_a_hand(1)
    found, rows = followed(log)
    assert not found.is_vehicle
    assert (rows == followed(log, watched=False)[1]).all()
