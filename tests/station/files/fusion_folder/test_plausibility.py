"""Units that cannot be are refused right beyond their limits, and not before."""

from pathlib import Path

import numpy as np
import pytest

from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from station.errors import DataRefused
from station.files.fusion_folder.plausibility import refuse_apart, refuse_far, refuse_units
from tests.refusals import refused

FILE = Path("imu.csv")


def imu(force: float = 9.8, rate: float = 0.5, peak_force: float = 0.0, peak_rate: float = 0.0) -> ImuSeries:
    f, omega = (
        np.tile([0.6 * force, 0.0, -0.8 * force], (101, 1)),
        np.tile([0.0, 0.8 * rate, 0.6 * rate], (101, 1)),
    )
    f[50, 1] += peak_force
    omega[50, 0] += peak_rate
    return ImuSeries(np.arange(101.0), omega, f)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (imu(4.1), ""), (imu(3.9), "3.9"), (imu(24.9), ""), (imu(25.1), "25"), (imu(0.51), "of g,"),
        (imu(1.99), "of g,"), (imu(501.0), "of mg,"), (imu(1999.0), "of mg,"), (imu(2001.0), "2001"),
        (imu(peak_force=4990.0), ""), (imu(peak_force=-5010.0), "5010"), (imu(rate=2.99), ""),
        (imu(rate=3.01), "deg/s"), (imu(rate=0.0, peak_rate=29.0), ""), (imu(rate=0.0, peak_rate=40.0), "40"),
    ],
)  # fmt: skip
def test_forces_and_rates_that_no_vehicle_has_are_of_another_unit(given: ImuSeries, said: str) -> None:
    if not said:
        refuse_units(given, FILE)
        return
    with refused(DataRefused, None, said):
        refuse_units(given, FILE)


def fixes(t: list[float], p: float = 0.0) -> GnssFixes:
    n = len(t)
    place = np.zeros((n, 3))
    place[-1, 1] = p
    return GnssFixes(np.array(t), place, np.zeros((n, 3)), np.zeros(n), np.ones(n), np.ones(n))


def test_a_place_beyond_ten_thousand_kilometres_is_of_another_frame() -> None:
    refuse_far(fixes([0.0, 1.0], -0.99e7), FILE)
    with refused(DataRefused, None, "1.01e+07 m"):
        refuse_far(fixes([0.0, 1.0], -1.01e7), FILE)


@pytest.mark.parametrize(
    ("t", "overlaps"),
    [
        ([0.0, 5.1], True),
        ([0.0, 5.0], False),
        ([9.0, 12.0], False),
        ([8.9, 12.0], True),
        ([6.0, 7.0], True),
    ],
)
def test_clocks_that_do_not_meet_are_told(t: list[float], overlaps: bool) -> None:
    moved = np.arange(5.0, 9.1)
    if overlaps:
        refuse_apart(fixes(t), moved, "IMU", FILE)
        return
    with refused(DataRefused, None, "5.000 to 9.000 s"):
        refuse_apart(fixes(t), moved, "IMU", FILE)
