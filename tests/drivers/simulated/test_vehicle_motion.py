"""A drive: what the IMU says, integrated, is where the receiver says that it went."""

import numpy as np
import pytest

from drivers.simulated.errors import TruthRefused
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import MIN_SPEED_M_S, VehicleTrack
from procedures.frames import rotation
from tests.drivers.simulated.drives import bends

EXACT = Truth(accel_k=np.full(3, 1e7), gyro_k=np.full(3, 1e8), latitude_deg=48.0)


def test_the_imu_dead_reckons_along_the_track() -> None:
    track, imu = bends(40.0, still=5.0), SimulatedImu(EXACT, None)
    imu.drive(track)
    block, period = imu.read(1999), EXACT.sample_period_s
    turned = np.radians(block.gyro / 1e8)
    gained = block.accel / 1e7 * 9.80665
    C = _first_attitude(track)
    v, p = np.zeros(3), np.zeros(3)
    earth_n = np.radians(imu.world.omega_ie_n) * period
    for dtheta, dv in zip(turned, gained, strict=True):
        step = rotation(dtheta - C.T @ earth_n)
        before, C = v, C @ step
        v = v + C @ rotation(-dtheta / 2) @ dv - [0, 0, imu.world.gravity * period]
        p = p + (before + v) / 2 * period
    assert np.linalg.norm(v - track.velocity(39.98)) < 0.01
    assert np.linalg.norm(p - track.position(39.98)) < 0.15  # of 170 m
    assert np.degrees(np.arccos(C[:, 0] @ _ahead(track, 39.99))) < 0.1


def _ahead(track: VehicleTrack, t: float) -> np.ndarray:
    east, north, _ = track.velocity(t)
    return np.array([east, north, 0.0]) / np.hypot(east, north)


def _first_attitude(track: VehicleTrack) -> np.ndarray:
    t = np.arange(0.0, 40.0, 0.02)
    first = float(t[np.linalg.norm(track.velocities(t)[:, :2], axis=1) > MIN_SPEED_M_S][0])
    ahead = _ahead(track, first)
    return np.stack([ahead, np.cross([0, 0, 1.0], ahead), [0, 0, 1.0]], axis=1)


def test_a_track_stands_between_equal_points_and_after_its_end() -> None:
    track = VehicleTrack(
        np.array([0.0, 10.0, 20.0, 30.0]), np.array([[0, 0, 0], [0, 0, 0], [50, 0, 0], [50, 0, 0.0]])
    )
    assert np.allclose(track.velocity(5.0), 0)
    assert np.allclose(track.position(40.0), [50, 0, 0])
    assert np.allclose(track.velocity(40.0), 0)
    t = np.arange(0.0, 30.0, 0.1)
    assert np.all(np.diff(track.positions(t)[:, 0]) >= 0)


def test_a_track_that_is_over_is_refused() -> None:
    imu = SimulatedImu(EXACT, None)
    imu.read(100)
    with pytest.raises(TruthRefused, match="ended at 1 s"):
        imu.drive(VehicleTrack(np.array([0.0, 1.0]), np.zeros((2, 3))))
