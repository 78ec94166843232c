"""The heading from the Earth's rate; positions are written a second time in `tests.procedures.independent`."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.truth import Truth, imu_from_cube
from procedures.arrays import FloatArray
from procedures.campaign.plan_steps import Dwell
from procedures.frames import rotation
from procedures.geodesy import EARTH_RATE
from procedures.gyrocompass import (
    CertainDwell,
    find_heading,
    first_position,
    heading_change,
)
from procedures.positions import FACES, TURN_START, face_of
from procedures.units import RAD_S_PER_DEG_H
from tests.procedures.independent import body_from_level

K = 2e6  # count/rad
STD = np.full(3, K * 0.1 * RAD_S_PER_DEG_H)
I3 = np.eye(3)
SOUTH, CHINA, EUROPE = np.radians([-33.0, 31.17, 48.1])


def seen(position: int, latitude: float, turned: float = 0.0) -> FloatArray:
    """Earth rate (3,) in the cube, which stands ``turned`` [rad] counter-clockwise off a position."""
    east_north = EARTH_RATE * np.cos(latitude) * np.array([np.sin(turned), np.cos(turned)])
    rate: FloatArray = body_from_level(position) @ np.array([*east_north, EARTH_RATE * np.sin(latitude)])
    return rate


def found(
    rate: FloatArray, position: int, latitude: float, known: tuple[CertainDwell, ...] = (), **options: object
):  # type: ignore[no-untyped-def]
    return find_heading(rate, STD, face_of(position), latitude, I3, known, **options)  # type: ignore[arg-type]


def known(position: int, latitude: float, bias: FloatArray) -> CertainDwell:
    return CertainDwell(position, K * (seen(position, latitude) + bias), STD)


@pytest.mark.parametrize("latitude", [SOUTH, CHINA, EUROPE])
@pytest.mark.parametrize("position", range(1, 13))
def test_every_position_is_determined_from_the_rate_alone(position: int, latitude: float) -> None:
    bias = RAD_S_PER_DEG_H * np.array([0.5, -0.4, 0.3])
    heading = found(K * (seen(position, latitude) + bias), position, latitude)
    assert heading.is_sure
    assert heading.position == position
    assert heading.quarter == (0 if position % 2 else 2)


@pytest.mark.parametrize("quarter", [1, 3])
@pytest.mark.parametrize("face", FACES)
def test_a_cube_set_down_a_quarter_turn_off_is_reported(face: str, quarter: int) -> None:
    heading = found(K * seen(first_position(face), CHINA, quarter * np.pi / 2), first_position(face), CHINA)
    assert heading.is_sure
    assert heading.position is None
    assert heading.quarter == quarter


def test_an_imu_that_sits_turned_in_its_cube_is_read_in_the_cubes_axes() -> None:
    C_sb = imu_from_cube(("-y", "+x", "+z"))
    heading = find_heading(K * C_sb @ seen(6, CHINA), STD, "y_up", CHINA, C_sb)
    assert heading.is_sure
    assert heading.position == 6


def test_near_a_pole_it_is_not_sure() -> None:
    for position in range(1, 13):
        assert not found(K * seen(position, np.radians(88.0)), position, np.radians(88.0)).is_sure


def test_a_short_look_is_not_sure() -> None:
    rate = K * seen(1, CHINA)
    assert find_heading(rate, STD, "x_up", CHINA, I3).is_sure
    assert not find_heading(rate, 60 * STD, "x_up", CHINA, I3).is_sure


def test_counts_that_contradict_the_vertical_earth_rate_are_not_believed() -> None:
    for position in (1, 5, 9):
        up = body_from_level(position)[:, 2]
        backwards = seen(position, EUROPE) * (1 - 2 * np.abs(up))
        assert not found(K * backwards, position, EUROPE).is_sure
        assert not found(-K * seen(position, EUROPE), position, EUROPE).is_sure


def test_a_large_bias_is_not_sure_until_known_dwells_take_it_off() -> None:
    bias = RAD_S_PER_DEG_H * np.array([8.0, -7.0, 6.0])
    before = tuple(known(position, CHINA, bias) for position in (1, 10, 3))
    for position in (2, 5, 8, 12):
        rate = K * (seen(position, CHINA) + bias)
        assert not found(rate, position, CHINA).is_sure
        heading = found(rate, position, CHINA, before, bias_std=8 * RAD_S_PER_DEG_H)
        assert heading.is_sure
        assert heading.position == position


def test_a_scale_factor_that_would_hide_the_earth_rate_behind_the_bias_is_not_likely() -> None:
    """With a bias of a third of the Earth's rate any heading fits, if k is so large that all counts are few."""
    bias = RAD_S_PER_DEG_H * np.array([5.0, -4.0, 4.0])
    heading = found(K * (seen(2, CHINA) + bias), 2, CHINA, (known(1, CHINA, bias),), bias_std=5 * RAD_S_PER_DEG_H)
    assert heading.position == 2
    assert heading.margin > 30


def test_a_known_dwell_sharpens_the_verdict_at_high_latitude() -> None:
    latitude, bias = np.radians(70.0), RAD_S_PER_DEG_H * np.array([0.5, -0.8, 0.3])
    rate = K * (seen(2, latitude) + bias)
    assert not found(rate, 2, latitude).is_sure
    heading = found(rate, 2, latitude, (known(1, latitude, bias),))
    assert heading.is_sure
    assert heading.position == 2


def test_it_is_never_sure_and_wrong_with_biases_up_to_three_sigma() -> None:
    rng = np.random.default_rng(5)
    sure = dict.fromkeys((0, 31, 45, 55, 60, 65, 70, 80, 89), 0)
    for latitude in sure:
        for trial in range(30):
            position, turned = int(rng.integers(1, 13)), int(rng.integers(2)) * np.pi / 2
            k = K * (1 + 0.03 * rng.standard_normal(3))
            bias = RAD_S_PER_DEG_H * rng.uniform(-3, 3, 3)
            rate = k * (seen(position, np.radians(latitude), turned) + bias) + STD * rng.standard_normal(3)
            heading = found(rate, position, np.radians(latitude))
            quarter = (0 if position % 2 else 2) + (1 if turned else 0)
            assert not heading.is_sure or heading.quarter == quarter, (latitude, trial)
            sure[latitude] += heading.is_sure
    assert min(sure[0], sure[31], sure[45]) > 26
    assert sure[89] == 0


def test_a_simulated_unit_is_found_in_all_twelve_positions_once_the_first_is_stated() -> None:
    truth = Truth.example(8)
    bench = SimulatedBench(truth, 8)
    dwells: list[CertainDwell] = []
    for position in range(1, 13):
        series = bench.perform(Dwell(position, 10.0))
        assert series.gyro is not None
        rate, std = series.gyro.sum(axis=0) / 10.0, np.full(3, truth.gyro_arw_deg_rt_s * 36000 / np.sqrt(10.0))
        if dwells:
            heading = find_heading(rate, std, face_of(position), np.radians(truth.latitude_deg), I3, dwells)
            assert heading.is_sure
            assert heading.position == position
        dwells.append(CertainDwell(position, rate, std))


@pytest.mark.parametrize("position", TURN_START.values())
def test_a_turn_that_did_not_come_back_is_measured_by_the_earth_rate(position: int) -> None:
    rng, turned = np.random.default_rng(position), np.radians(8.0)
    bias, std = 30 * RAD_S_PER_DEG_H * rng.standard_normal(3), np.full(3, 0.02 * K * RAD_S_PER_DEG_H)
    C_sb = imu_from_cube(("+z", "+x", "+y"))
    before, after = (
        CertainDwell(position, K * C_sb @ (seen(position, EUROPE, a) + bias) + std * rng.standard_normal(3), std)
        for a in (0.0, turned)
    )
    angle, angle_std = heading_change(before, after, EUROPE, C_sb, K)
    assert abs(angle - turned) < 4 * angle_std
    assert angle_std == pytest.approx(
        np.sqrt(2) * 0.02 * RAD_S_PER_DEG_H / (EARTH_RATE * np.cos(EUROPE)), rel=1e-6
    )
    # the same from rotations: the cube turned counter-clockwise sees the world turned clockwise
    turned_cube = body_from_level(position) @ rotation(np.array([0.0, 0.0, -turned]))
    sees = turned_cube @ np.array([0.0, EARTH_RATE * np.cos(EUROPE), EARTH_RATE * np.sin(EUROPE)])
    exact = replace(before, rate=K * C_sb @ (sees + bias))
    start = replace(before, rate=K * C_sb @ (seen(position, EUROPE) + bias))
    assert heading_change(start, exact, EUROPE, C_sb, K)[0] == pytest.approx(turned, abs=1e-9)


def test_at_the_pole_no_return_is_measured() -> None:
    still = CertainDwell(1, K * seen(1, np.pi / 2), STD)
    assert heading_change(still, still, np.pi / 2, I3, K)[1] > 1e6
