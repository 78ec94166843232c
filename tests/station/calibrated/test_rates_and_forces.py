"""A unit turned at known rates about known axes, read with its calibration and with its maker's scale factors."""

import numpy as np
import pytest

from drivers.wire import NominalScale
from procedures.arrays import FloatArray
from procedures.counts.sample_records import CountBlock, RateBlock
from station.calibrated.rates_and_forces import Sensors
from tests.station.calibrated.test_calibration_applied import D_A, D_G, E_A, E_G, K_A, K_G, calibration, effect

PERIOD, G = 0.01, 9.80665
F, OMEGA = np.array([[0.5, -0.2, 0.8]]), np.array([[10.0, -20.0, 30.0]])  # g, deg/s
C = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # not its own inverse


def block(
    rates: bool = False, t: float = 1.0, temperature: float = 25.0, healthy: bool = True
) -> CountBlock | RateBlock:
    gyro = K_G * (OMEGA @ E_G.T + D_G / 3600)
    accel = K_A * (F @ E_A.T + D_A)
    kept = {"counter": np.array([7]), "device_time": np.array([t]), "status": np.array([0]),
            "temperature": np.array([temperature]), "healthy": np.array([healthy])}  # fmt: skip
    if rates:
        return RateBlock(gyro=gyro, accel=accel, **kept)
    return CountBlock(
        gyro=np.round(gyro * PERIOD).astype(np.int64), accel=np.round(accel * PERIOD).astype(np.int64), **kept
    )


def body(values: FloatArray) -> FloatArray:
    return values[:, [1, 2, 0]]


def test_rates_are_taken_back_to_what_the_unit_went_through_in_body_axes() -> None:
    tick = Sensors(calibration(), None, C, PERIOD, counts=False).take(block(rates=True))
    assert tick.calibrated.rate == pytest.approx(body(np.radians(OMEGA)), abs=1e-9)
    assert tick.calibrated.force == pytest.approx(body(F * G), abs=1e-9)
    assert (tick.t.tolist(), tick.temperature, tick.is_healthy, tick.not_applied) == ([1.0], 25.0, True, ())
    assert not Sensors(calibration(), None, C, PERIOD).take(block(healthy=False)).is_healthy


def test_counts_are_of_a_sample_and_give_the_same_to_a_counts_worth() -> None:
    sensors = Sensors(calibration(), None, C, PERIOD)
    tick = sensors.take(block())
    assert tick.calibrated.rate == pytest.approx(body(np.radians(OMEGA)), abs=np.radians(1 / 355 / 1.9))
    assert tick.calibrated.force == pytest.approx(body(F * G), abs=G / 9.9 / 1.9)
    # without the calibration: mean scale factors to three digits
    expected = np.round(K_A * (F @ E_A.T + D_A) * PERIOD) / PERIOD / 1000.0 * G  # mean 1001.7
    assert tick.nominal.force == pytest.approx(body(expected))


def test_a_counts_worth_is_of_the_coarsest_axis() -> None:
    turned = calibration()
    turned["accelerometer"]["scale_factor"]["value"][1] *= -1
    sensors = Sensors(turned, None, C, PERIOD)
    assert sensors.quanta() == pytest.approx((np.radians(1 / 35900.0), G / 1000.0))  # means 35933, 1001.7
    assert sensors.quantum(0.5) == pytest.approx(G / 500.0)
    assert Sensors(turned, None, C, PERIOD, counts=False).quantum(0.5) == 0.0


def test_a_sample_that_cannot_be_undone_goes_into_filters_as_without_the_calibration() -> None:
    sine = calibration(effect("gyroscope.sagnac_sine", z=0.05))  # no rate puts out more than 20 deg/s
    tick = Sensors(sine, None, C, PERIOD, counts=False).take(block(rates=True))
    assert np.array_equal(tick.calibrated.rate, tick.nominal.rate)
    read = Sensors(sine, None, C, PERIOD, counts=False).calibrated(block(rates=True))
    assert np.isnan(read.found.rate).all()
    assert read.unsettled.tolist() == [True]
    assert read.found.force == pytest.approx(body(F * G), abs=1e-9)


def test_without_a_calibration_the_makers_scale_factors_are_taken() -> None:
    made = NominalScale("X", gyro=2e-6, accel=5e-3, rate_hz=100.0, source="table 4")
    sensors = Sensors(None, made, np.eye(3), PERIOD)
    one = block()
    tick = sensors.take(one)
    assert tick.calibrated is tick.nominal
    assert tick.nominal.rate == pytest.approx(one.gyro * 2e-6 / PERIOD)
    assert tick.nominal.force == pytest.approx(one.accel * 5e-3 / PERIOD)
    assert sensors.quanta() == pytest.approx((2e-6, 5e-3))
    with pytest.raises(ValueError, match="neither"):
        Sensors(None, None, C, PERIOD)
