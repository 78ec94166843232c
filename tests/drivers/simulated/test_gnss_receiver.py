"""A simulated receiver's fixes: the fields of MAVLink's messages, and the statistics of its errors."""

import math

import numpy as np
import pytest

from drivers.simulated.companions.autopilot import SimulatedFix, SimulatedReceiver
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack

TRUTH = Truth.example(7)
PILOT = AutopilotTruth(position_std_m=0.8, velocity_std_m_s=0.05, undulation_m=12.5)
FIX = SimulatedFix(55.1234567, -37.7654321, 210.25, np.array([3.0, -4.0, 1.5]), has_fix=True, autopilot=PILOT)


def test_a_fix_has_the_units_of_its_message() -> None:
    """MAVLink common.xml, GPS_RAW_INT: degE7, mm, cm/s, cdeg from North to East, mm and mm/s of accuracy."""
    m = FIX.gps_raw_int(17)
    assert (m.time_usec, m.fix_type, m.lat, m.lon) == (17, 3, 551234567, -377654321)
    assert (m.alt, m.alt_ellipsoid) == (197750, 210250)
    assert (m.eph, m.epv, m.satellites_visible) == (90, 140, 14)
    assert m.vel == 500
    assert m.cog == round((math.degrees(math.atan2(3.0, -4.0)) % 360) * 100)
    assert (m.h_acc, m.v_acc, m.vel_acc, m.hdg_acc, m.yaw) == (800, 1280, 50, 0, 0)


def test_the_global_position_is_north_east_down() -> None:
    m = FIX.global_position(5)
    assert (m.time_boot_ms, m.lat, m.lon, m.alt, m.relative_alt) == (5, 551234567, -377654321, 197750, 0)
    assert (m.vx, m.vy, m.vz, m.hdg) == (-400, 300, -150, 65535)


def test_without_a_fix_or_where_it_is_not_stated_a_field_is_unknown() -> None:
    none = SimulatedFix(1.0, 2.0, 3.0, np.zeros(3), has_fix=False, autopilot=PILOT).gps_raw_int(0)
    assert (none.fix_type, none.lat, none.lon, none.alt, none.satellites_visible) == (1, 0, 0, 0, 3)
    assert {none.eph, none.epv, none.vel, none.cog} == {65535}
    assert {none.alt_ellipsoid, none.h_acc, none.v_acc, none.vel_acc, none.hdg_acc} == {0}
    for silent in (
        AutopilotTruth(states_accuracy=False), AutopilotTruth(position_std_m=0.0),
    ):  # fmt: skip
        m = SimulatedFix(1.0, 2.0, 3.0, np.zeros(3), has_fix=True, autopilot=silent).gps_raw_int(0)
        assert (m.fix_type, m.h_acc, m.alt_ellipsoid) == (3, 0, 0)
    slow = SimulatedFix(1.0, 2.0, 3.0, np.ones(3), has_fix=True, autopilot=AutopilotTruth(states_velocity=False))
    assert (slow.gps_raw_int(0).vel, slow.gps_raw_int(0).cog) == (65535, 65535)


def test_metres_are_degrees_by_the_radii_of_the_ellipsoid() -> None:
    track = VehicleTrack(np.array([0.0, 100.0]), np.array([[0.0, 0.0, 0.0], [1000.0, 2000.0, 30.0]]))
    fix = SimulatedReceiver(TRUTH, PILOT, track, None).look(100.0, 40.0, has_fix=True)
    latitude, e2 = math.radians(TRUTH.latitude_deg), 6.69437999014e-3
    curve = math.sqrt(1 - e2 * math.sin(latitude) ** 2)
    meridian, normal = 6378137.0 * (1 - e2) / curve**3, 6378137.0 / curve
    assert math.radians(fix.latitude - TRUTH.latitude_deg) * meridian == pytest.approx(2000.0)
    east = math.radians(fix.longitude - TRUTH.longitude_deg) * normal * math.cos(latitude)
    assert east == pytest.approx(1040.0)
    assert fix.height == pytest.approx(TRUTH.height_m + 30.0)


def test_errors_have_their_sigma_and_fade_over_a_minute() -> None:
    receiver = SimulatedReceiver(TRUTH, PILOT, None, 3)
    looks = [receiver.look(30.0 * i, 0.0, has_fix=True) for i in range(6000)]
    up = np.array([each.height for each in looks]) - TRUTH.height_m
    north = np.radians(np.array([each.latitude for each in looks]) - TRUTH.latitude_deg) * 6.37e6
    assert up.std() == pytest.approx(0.8 * 1.6, rel=0.06)  # 1600 independent ones and more: 2 %
    assert north.std() == pytest.approx(0.8, rel=0.06)
    assert np.corrcoef(up[1:], up[:-1])[0, 1] == pytest.approx(math.exp(-0.5), abs=0.04)
    assert abs(np.corrcoef(up, north)[0, 1]) < 0.08
    v = np.array([each.v_n for each in looks])
    assert v.std(axis=0) == pytest.approx([0.05] * 3, rel=0.05)
    assert np.abs(v.mean(axis=0)).max() < 0.003
    first = [
        SimulatedReceiver(TRUTH, PILOT, None, seed).look(0.0, 0.0, has_fix=True).height for seed in range(400)
    ]
    assert np.std(first) == pytest.approx(1.28, rel=0.15)
