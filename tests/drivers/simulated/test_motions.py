"""Flights, drives and carried cubes: what their sensors measure, integrated, is where they are."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drivers.errors import TruthRefused
from drivers.simulated.cube_motion import carry
from drivers.simulated.device import ByteDevice
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import MIN_SPEED_M_S, VehicleTrack
from procedures.arrays import FloatArray
from procedures.frames import rotation
from procedures.positions import C_bn, nominal_C_lb
from procedures.units import STANDARD_GRAVITY
from tests.drivers.simulated.drives import bends
from tests.drivers.simulated.flight import LEVEL_S, PERIOD_S, paper_flight, sensor_errors

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
    with pytest.raises(TruthRefused, match="1 s"):
        imu.drive(VehicleTrack(np.array([0.0, 1.0]), np.zeros((2, 3))))


PERIOD = 0.01
BEGIN, END = nominal_C_lb(1).T, nominal_C_lb(2).T


@pytest.mark.parametrize("seed", range(4))
def test_the_rates_lead_from_one_attitude_to_the_other(seed: int) -> None:
    made = carry(BEGIN, END, 400, PERIOD, np.random.default_rng(seed), 40.0)
    turned = Rotation.identity()
    before = np.zeros(3)
    for rate in made.rate_b(0, 400, PERIOD):
        step = rate * PERIOD
        turned, before = Rotation.from_rotvec(-(step + np.cross(before, step) / 12)) * turned, step
    off = (Rotation.from_matrix(made.end_C_bn() @ BEGIN.T) * turned.inv()).magnitude()
    assert off < np.radians(1 / 60)  # what tremor cones at 100 Hz, drawn through no spline
    assert made.end_C_bn() is END
    assert np.linalg.norm(np.degrees(made.rates), axis=1).max() > 60
    up = made.seen(np.array([0.0, 0.0, 1.0]), 0, 400)
    assert up[0] == pytest.approx(BEGIN[:, 2], abs=1e-2)
    assert up[-1] == pytest.approx(END[:, 2], abs=1e-2)


def test_hands_that_do_not_tremble_turn_about_one_axis_and_stop_in_the_air() -> None:
    made = carry(BEGIN, END, 900, PERIOD, np.random.default_rng(1), 0.0, pause_s=5.0)
    rates = np.linalg.norm(made.rates, axis=1)
    assert rates[250:650].max() < 1e-9
    assert rates[100] > 0.1
    assert np.linalg.matrix_rank(made.rates, tol=1e-6) == 1


def test_the_command_puts_the_cube_where_it_is_to_stand() -> None:
    device = ByteDevice(Truth.example(1), None, "counts")
    assert device.execute("carry 20 4 40 2").startswith("ok time")
    device.imu.read(round(7.0 / device.truth.sample_period_s))
    last = device.imu.read(50).accel.sum(axis=0) / device.truth.accel_k
    up = C_bn(20, np.zeros(2), np.zeros(2))[:, 2]
    assert last / np.linalg.norm(last) == pytest.approx(up, abs=0.01)
    assert device.imu.position == 20


@pytest.mark.parametrize(
    "command", ["carry 25 4 40", "carry 3 0 40", "carry 3 4 1e4", "carry 3 4 40 -1", "carry 3 x 40"]
)
def test_what_no_hand_does_is_refused_in_a_line(command: str) -> None:
    answer = ByteDevice(Truth.example(1), None, "counts").execute(command)
    assert answer.startswith("error")
    assert "\n" not in answer


def strapdown(C: FloatArray, rate: FloatArray, force: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Attitude and velocity change by plain integration, half of each turn at a time."""
    v = np.zeros(3)
    for w, f in zip(rate, force, strict=True):
        half = rotation(0.5 * w * PERIOD_S)
        v += (C @ half @ f + [0, 0, STANDARD_GRAVITY]) * PERIOD_S
        C = C @ half @ half
    return C, v


def test_the_turn_changes_heading_by_90_deg_and_its_sensors_integrate_to_it() -> None:
    clean = paper_flight(0, 50.0)
    gyro, force = sensor_errors(np.random.default_rng(0), len(clean.t))
    C, change = strapdown(rotation(np.array([0.0, np.radians(3.0), 0.0])), clean.omega_b - gyro, clean.f_b - force)
    assert clean.true_down is not None
    assert C[2] == pytest.approx(clean.true_down[-1], abs=1e-5)
    course = np.radians(1.8) * 45.0  # 5 s each to roll in and out count half
    assert change == pytest.approx(200 * np.array([np.cos(course) - 1, np.sin(course), 0.0]), abs=0.01)
    assert clean.roll is not None
    assert np.degrees(clean.roll.max()) == pytest.approx(32.6, abs=0.1)
    assert (np.abs(clean.roll[clean.t < LEVEL_S]) < 1e-12).all()
