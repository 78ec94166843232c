from dataclasses import replace

import numpy as np
import pytest

from procedures.attitude.attitude_estimate import estimate
from procedures.attitude.attitude_log import AttitudeLog, earth_rate_ned, inclination, roll_pitch_of
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.kalman.unaided_motion import heading_at_rest
from procedures.frames import rotation
from procedures.geodesy import EARTH_RATE
from procedures.units import RAD_S_PER_DEG_H
from tests.drivers.simulated.flight import paper_bench
from tests.drivers.simulated.vehicles import FOG, MEMS, VEHICLES, vehicle_log
from tests.procedures.attitude.driving import G, driving

REPORTED = "moves like a vehicle"


def error_and_ratio(log: AttitudeLog, settings: KalmanSettings | None = None) -> tuple[float, float]:
    """Return the rms error [deg] without aid and the rms of error over sigma."""
    track = estimate(log, "none", settings=settings)
    assert log.true_down is not None
    assert track.sigma is not None
    error = inclination(track.down, log.true_down)
    return float(np.degrees(np.sqrt(np.mean(error**2)))), float(np.sqrt(np.mean((error / track.sigma) ** 2)))


@pytest.mark.parametrize("kind", list(VEHICLES))
def test_sigma_without_aid_is_what_the_error_is_in_every_vehicle(kind: str) -> None:
    """Seeds that had no say in the settings: error over sigma of each vehicle, and no error that grows on."""
    for seed, grade in ((20, MEMS), (21, FOG)):
        log = vehicle_log(kind, seed, grade)
        error, ratio = error_and_ratio(log)
        assert 0.15 < ratio < 2.2
        assert error < 12
        assert any(REPORTED in reported for reported in estimate(log, "none").warnings)


def in_a_hand(seed: int, reach: float = 0.3) -> AttitudeLog:
    """Two minutes in a hand: moved ``reach`` [m] to and fro, a radian about each axis, rests between."""
    rng, dt = np.random.default_rng(seed), 0.01
    t = np.arange(0, 120, dt)
    moves = np.clip(np.sin(2 * np.pi * t / 40) * 4, 0, 1)
    f, phase = rng.uniform(0.3, 0.7, (2, 3)), rng.uniform(0, 6, (2, 3))
    rate = 2.0 * moves[:, None] * np.sin(2 * np.pi * f[0] * t[:, None] + phase[0])
    place = reach * moves[:, None] * np.sin(2 * np.pi * f[1] * t[:, None] + phase[1])
    C, all_C = np.eye(3), list[np.ndarray]()
    for each in rate:
        C = C @ rotation(each * dt)
        all_C.append(C)
    C_nb = np.array(all_C)
    acceleration = np.gradient(np.gradient(place, dt, axis=0), dt, axis=0)
    force = np.einsum("nji,nj->ni", C_nb, acceleration - [0, 0, G])
    roll, pitch = roll_pitch_of(C_nb[:, 2])
    noise = rng.standard_normal((2, len(t), 3)) / np.sqrt(dt)
    return AttitudeLog(t, rate + 0.004 + 1e-4 * noise[0], force + 1e-3 * noise[1], roll=roll, pitch=pitch)


def test_a_hand_and_a_bench_are_no_vehicles() -> None:
    for log in (in_a_hand(1), in_a_hand(2), paper_bench(2, 7)):
        track = estimate(log, "none")
        assert not any(REPORTED in reported for reported in track.warnings)
        assert track.parameters["speed_noise"] < 1


def test_a_steady_cruise_that_looks_like_rest_misleads_nothing() -> None:
    """A car that never shakes: at 15 m/s and straight its sensors say what they say at rest."""
    log, down = driving(bias=np.zeros(3))
    smooth = replace(log, roll=roll_pitch_of(down)[0], pitch=roll_pitch_of(down)[1])
    error, ratio = error_and_ratio(smooth)
    assert error < 1.5
    assert ratio < 2


LATITUDE = 0.7


def rest(heading: float, bias_deg_h: float, seed: int, seconds: float = 60.0) -> AttitudeLog:
    """A rest 3 deg nose up and 5 deg right down, of gyros with a bias of ``bias_deg_h`` (1 sigma)."""
    n, rng = round(seconds / 0.01), np.random.default_rng(seed)
    C = rotation(np.array([0, 0, heading])) @ rotation(np.array([0, 0.05, 0])) @ rotation(np.array([0.09, 0, 0]))
    rate = C.T @ earth_rate_ned(LATITUDE) + bias_deg_h * RAD_S_PER_DEG_H * rng.standard_normal(3)
    noise = 2e-5 * rng.standard_normal((n, 3))
    return AttitudeLog(np.arange(n) * 0.01, rate + noise, np.tile(C.T @ [0, 0, -G], (n, 1)))


@pytest.mark.parametrize("heading", [0.0, 1.0, 2.5, -2.0])
def test_a_calibrated_unit_at_rest_finds_north_within_its_sigma(heading: float) -> None:
    z = []
    for seed in range(20):
        found = heading_at_rest(rest(heading, 0.5, seed), LATITUDE, 0.5 * RAD_S_PER_DEG_H)
        assert found is not None
        z.append(((found[0] - heading + np.pi) % (2 * np.pi) - np.pi) / found[1])
    assert np.abs(z).max() < 4
    assert np.std(z) == pytest.approx(1, abs=4 / np.sqrt(2 * 20))


def test_gyros_too_poor_or_a_rest_too_short_say_nothing() -> None:
    assert heading_at_rest(rest(1.0, 50.0, 1), LATITUDE, 50 * RAD_S_PER_DEG_H) is None
    assert heading_at_rest(rest(1.0, 0.1, 1, 20.0), LATITUDE, 0.1 * RAD_S_PER_DEG_H) is None
    turning = rest(1.0, 0.1, 1)
    turning.omega_b[1000:] += [0.0, 0.0, 0.1]
    assert heading_at_rest(turning, LATITUDE, 0.1 * RAD_S_PER_DEG_H) is None


def test_the_heading_found_takes_the_horizontal_earth_rate_off() -> None:
    log = rest(1.0, 0.0, 3, 300.0)
    known = estimate(log, "none", latitude=LATITUDE, gyro_bias_std=0.1 * RAD_S_PER_DEG_H)
    assert np.linalg.norm(known.gyro_bias) < 0.05 * EARTH_RATE
    unknown = estimate(log, "none")
    assert np.linalg.norm(unknown.gyro_bias) > 0.3 * EARTH_RATE
